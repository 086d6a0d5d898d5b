#include "host/session/conversation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

void Conversation::handle(bus::Body kind, Handler handler) {
    handlers_.insert_or_assign(kind, std::move(handler));
}

void Conversation::handle_frame_faults(std::function<bool(std::uint32_t)> takes_fault) {
    takes_frame_fault_ = std::move(takes_fault);
}

void Conversation::broadcast(const bus::Payload& request) {
    const bool may_change = request.kind() != bus::Body::FetchVoxels;
    broadcasts_ += may_change ? 1 : 0;
    other_changes_ += may_change && request.kind() != bus::Body::SetSurface ? 1 : 0;
    for (const bus::NodeId gp : gps()) {
        machine_.send(gp, request);
    }
}

void Conversation::ask(const std::string& what, const bus::Payload& request, Answer answer) {
    struct Forget {
        Conversation& conversation;
        ~Forget() { conversation.forget(); }  // The answer may refer to the caller's variables.
    };
    expect(std::move(answer));
    const Forget forget{*this};
    broadcast(request);
    wait_for_answers(what);
}

void Conversation::ask_cancelable(const std::string& what, const bus::Payload& request,
                                  const Answer& answers, const Handler& take) {
    const Cancelable cancelable(*this);
    try {
        ask(what, request, [&](const bus::Message& message) {
            const bool is_answer = answers(message);
            if (is_answer) {
                answered_.insert(message.source());  // `take` may throw.
                take(message);
            }
            return is_answer;
        });
    } catch (const RequestError&) {  // Canceled, or recording has stopped.
        Late late{request.kind(), answers, {gps().begin(), gps().end()}};
        std::erase_if(late.from, [this](bus::NodeId gp) { return answered_.contains(gp); });
        if (!late.from.empty()) {
            late_.push_back(std::move(late));
        }
        throw;
    }
}

void Conversation::expect(Answer answer) {
    answered_.clear();
    answer_ = std::move(answer);
}

bool Conversation::is_answered() const {
    return std::ranges::all_of(gps(), [this](bus::NodeId gp) { return answered_.contains(gp); });
}

void Conversation::begin_again() {
    forget();
    answered_.clear();
    late_.clear();
    fault_.reset();
    ++broadcasts_;
    ++other_changes_;
}

void Conversation::wait_for_answers(const std::string& what) {
    wait(what, [this] { return is_answered(); });
}

void Conversation::wait(const std::string& what, const std::function<bool()>& done) {
    machine_.name_work(what);
    machine_.pump([this](const bus::Message& message) { take(message); }, done);
    if (fault_) {
        const Failure failure = *std::exchange(fault_, std::nullopt);
        throw RequestError(ExitCode::failed,
                           fmt::format("{}: {}{}", what, failure.reason, traces_of(failure)));
    }
}

void Conversation::take_arrived() {
    bool came = true;
    machine_.pump(
        [&](const bus::Message& message) {
            came = true;
            take(message);
        },
        [&] { return !std::exchange(came, false); });
    wait("background request", [] { return true; });  // Throws the fault that has arrived.
}

void Conversation::pause(const std::string& what) {
    const Cancelable cancelable(*this);
    machine_.name_work(what);
    machine_.pump([this](const bus::Message& message) { take(message); }, [] { return true; });
}

void Conversation::discard_until(const Handler& take_one, const std::function<bool()>& done) {
    machine_.name_work("discarding a volume");
    machine_.pump(
        [&](const bus::Message& message) {
            // An activity that is lost would be awaited for ever.
            if (message.kind() == bus::Body::Activity) {
                take(message);
            } else if (!is_late(message)) {
                take_one(message);
            }
        },
        done);
    fault_.reset();
}

/// A GP answers the requests of one kind in their order, so an answer or a fault belongs to the
/// oldest that waits for it.
bool Conversation::is_late(const bus::Message& message) {
    const auto* fault = message.as<schema::Fault>();
    if (fault != nullptr && fault->frame()) {
        return false;
    }
    for (auto late = late_.begin(); late != late_.end(); ++late) {
        if (late->from.contains(message.source()) &&
            (fault != nullptr ? fault->request() == static_cast<std::uint16_t>(late->request)
                              : late->answers(message))) {
            late->from.erase(message.source());
            if (late->from.empty()) {
                late_.erase(late);
            }
            return true;
        }
    }
    return false;
}

void Conversation::take(const bus::Message& message) {
    if (message.kind() == bus::Body::Fault) {
        take_fault(message);
        return;
    }
    if (is_late(message)) {
        return;
    }
    if (answer_ && answer_(message)) {
        answered_.insert(message.source());
    }
    if (const auto handler = handlers_.find(message.kind()); handler != handlers_.end()) {
        handler->second(message);
    }
}

void Conversation::take_fault(const bus::Message& message) {
    const auto& fault = *message.as<schema::Fault>();
    if (const auto frame = fault.frame()) {
        if (!takes_frame_fault_ || !takes_frame_fault_(*frame)) {
            return;
        }
    } else if (is_late(message)) {
        return;
    } else {
        // A fault is an answer, too, so that the next request does not receive it.
        answered_.insert(message.source());
    }
    if (!fault_) {  // The first fault is the cause of the others.
        fault_ = {fault.reason()->str(), fault.code() != schema::FaultCode::bad_input &&
                                             fault.code() != schema::FaultCode::out_of_memory};
    }
}

/// Returns where the traces of a fault are, as a suffix of the fault's text.
std::string Conversation::traces_of(const Failure& failure) const {
    if (!failure.is_internal || !machine_.is_recording()) {
        return {};
    }
    try {
        const SavedTraces saved = machine_.save_traces_after_fault();
        return saved.nodes == 0
                   ? ""
                   : fmt::format("; traces of {} nodes: {}", saved.nodes, saved.folder);
    } catch (const RequestError& error) {
        return fmt::format("; no traces: {}", error.what());  // The fault matters more.
    }
}

}  // namespace pxpl5::host
