#include "host/session/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

Session::Session(MachinePort& machine) : machine_(machine), activity_(machine.nodes()) {}

const Volume& Session::volume() const {
    if (archive_) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} is a scene of polygons, spheres and lines: it has no "
                                       "voxels and no isosurfaces; load a volume for them",
                                       archive_->content.file));
    }
    if (!volume_) {
        throw RequestError(ExitCode::usage, "no volume is loaded; load one first: load VOLUME");
    }
    return *volume_;
}

void Session::wait(const std::string& what, const std::function<bool()>& done) {
    machine_.pump([this](const bus::Message& message) { on_message(message); }, done);
    if (fault_) {
        const std::string text =
            what + ": " + *std::exchange(fault_, std::nullopt) + traces_of_fault();
        throw RequestError(ExitCode::failed, text);
    }
}

void Session::begin_request(Answer answer) {
    answered_.clear();
    answer_ = std::move(answer);
}

void Session::send_to_gps(const bus::Payload& request) {
    ++told_;
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, request);
    }
}

void Session::ask_gps(const std::string& what, const bus::Payload& request, Answer answer) {
    struct Forget {
        Answer& answer;
        ~Forget() { answer = nullptr; }  // It may refer to the caller's variables.
    };
    begin_request(std::move(answer));
    const Forget forget{answer_};
    send_to_gps(request);
    wait_for_gps(what);
}

void Session::wait_for_gps(const std::string& what) {
    wait(what, [this] {
        return std::all_of(machine_.gp_ids().begin(), machine_.gp_ids().end(),
                           [this](bus::NodeId gp) { return answered_.count(gp) != 0; });
    });
}

/// Returns true if the fault names a frame that the session no longer waits for. Several GPs may
/// report the same frame; only the first report counts.
bool Session::is_stale(const schema::Fault& fault) const {
    const std::optional<std::uint32_t> frame = fault.frame();
    return frame && std::ranges::none_of(pending_, [&](const PendingFrame& pending) {
               return pending.frame == *frame;
           });
}

void Session::on_message(const bus::Message& message) {
    if (const auto* activity = message.as<schema::Activity>()) {
        activity_.take(message.source(), *activity);
        return;
    }
    const auto* fault = message.as<schema::Fault>();
    if (fault != nullptr && is_stale(*fault)) {
        return;
    }
    on_answer(message);
    if (fault != nullptr) {
        on_fault(*fault);
    } else if (const auto* frame = message.as<schema::FrameDone>()) {
        on_frame_done(*frame);
    } else if (message.kind() == bus::Body::FrameCounts) {
        on_frame_counts(message);
    } else if (const auto* header = message.as<schema::VolumeHeader>()) {
        receiver_.emplace().begin(*header);
    } else if (const auto* slices = message.as<schema::Slices>(); slices != nullptr && receiver_) {
        receiver_->add(*slices);
    } else if (message.kind() == bus::Body::VolumeEnd && receiver_) {
        received_ = receiver_->finish();
    } else if (const auto* outcome = message.as<schema::IoDone>()) {
        io_done_ = true;
        io_report_ = {static_cast<std::int64_t>(outcome->triangles()),
                      outcome->text() != nullptr ? outcome->text()->str() : ""};
        if (!outcome->ok()) {
            throw RequestError(
                outcome->bad_data() ? ExitCode::bad_data : ExitCode::failed,
                outcome->error() ? outcome->error()->str() : "input or output failed");
        }
    }
}

/// A GP's word on what was asked for.
void Session::on_answer(const bus::Message& message) {
    // A fault is an answer too, so that none is left over for the next request; but not what is
    // wrong with a frame that is drawn meanwhile.
    const auto* fault = message.as<schema::Fault>();
    const bool refused = fault != nullptr && !fault->frame();
    if (refused || (answer_ && answer_(message))) {
        answered_.insert(message.source());
    }
}

void Session::on_fault(const schema::Fault& fault) {
    if (!fault_) {  // The first cause is the one to tell.
        fault_ = fault.reason()->str();
        fault_is_of_frame_ = fault.frame().has_value();
        fault_is_ours_ = fault.code() != schema::FaultCode::bad_input &&
                         fault.code() != schema::FaultCode::out_of_memory;
    }
}

}  // namespace pxpl5::host
