#include "ringbus/trace/recorder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <deque>
#include <system_error>
#include <utility>

#include "ringbus/node_loop.hpp"
#include "ringbus/trace/held.hpp"

namespace pxpl5::bus::trace {

namespace {

/// A node that has heard nothing for so long writes what it has.
constexpr int quiet_ms = 50;

struct Timed {
    Held held;
    std::chrono::steady_clock::time_point came;
};

/// At a GP, a Renderer or the frame buffer it comes first, at the host last.
bool begins_frame(Body kind) {
    return kind == Body::DrawFrame || kind == Body::BeginFrame || kind == Body::FrameDone;
}

}  // namespace

Instant Instant::now() {
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    return {static_cast<std::uint64_t>(
                std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count()),
            std::chrono::steady_clock::now()};
}

struct Recorder::Parts {
    Parts(std::filesystem::path to, const Info& about, const Limits& most)
        : path(std::move(to)), info(about), limits(most), setup(most.setup_bytes) {}

    std::filesystem::path path;
    Info info;
    Limits limits;

    std::optional<TraceWriter> file;  ///< File of a full recording.
    std::optional<std::chrono::steady_clock::time_point> waiting_since;  ///< For the file.
    std::string failure;  ///< Why nothing is noted any more.

    std::deque<Timed> window;
    std::size_t window_bytes = 0;
    std::uint64_t noted = 0;  ///< Messages that ever were in the window, so the newest's number.
    std::uint64_t newest_frame = 0, older_frame = 0;  ///< Numbers of the last two that began one.
    HeldSetup setup;

    /// Does what may fail; after a failure the recording is over.
    template <typename Act>
    void guarded(const Act& act) {
        try {
            act();
        } catch (const TraceError& error) {
            failure = error.what();
            waiting_since.reset();
            throw;
        }
    }
    void note_in_file(const Message& message, const Instant& when);
    void note_in_window(const Message& message, const Instant& when);
    Saved write_flight() const;
};

void Recorder::Parts::note_in_file(const Message& message, const Instant& when) {
    if (file->bytes() >= limits.file_bytes) {
        file->close();
        throw TraceError(fmt::format("trace {} has {} bytes, the limit is {}", path.string(),
                                     file->bytes(), limits.file_bytes));
    }
    const std::uint64_t before = file->bytes();
    file->add(message, when.wall_ns);
    if (file->bytes() != before) {
        waiting_since.reset();  // The chunk was full.
    } else if (!waiting_since) {
        waiting_since = when.steady;
    } else if (when.steady - *waiting_since >= patience) {
        file->flush();
        waiting_since.reset();
    }
}

void Recorder::Parts::note_in_window(const Message& message, const Instant& when) {
    window.push_back({{message, when.wall_ns}, when.steady});
    window_bytes += message.bytes().size();
    ++noted;
    if (begins_frame(message.kind())) {
        older_frame = std::exchange(newest_frame, noted);
    }
    const auto is_over = [&](const Timed& oldest) {
        // The displayed frame stays, however old it is. Its streams may have arrived before its
        // BeginFrame, but not before the BeginFrame of the preceding frame.
        const std::uint64_t number = noted - window.size() + 1;
        return (newest_frame == 0 || number < older_frame) &&
               (window_bytes > limits.share_bytes || when.steady - oldest.came > limits.span);
    };
    while (window.size() > 1 && (window_bytes > limits.window_bytes || is_over(window.front()))) {
        window_bytes -= window.front().held.message.bytes().size();
        info.dropped += setup.take(std::move(window.front().held));
        window.pop_front();
    }
}

Recorder::Saved Recorder::Parts::write_flight() const {
    const std::filesystem::path part = path.string() + ".part";
    try {
        TraceWriter writer(part, info);
        for (const Held& held : setup.messages()) {
            writer.add(held.message, held.wall_ns);
        }
        for (const Timed& timed : window) {
            writer.add(timed.held.message, timed.held.wall_ns);
        }
        writer.close();
        std::filesystem::rename(part, path);
        return {writer.messages(), writer.bytes()};
    } catch (const std::exception& error) {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
        throw TraceError(error.what());
    }
}

Recorder::Recorder(std::filesystem::path path, const Info& info, Limits limits)
    : parts_(std::make_unique<Parts>(std::move(path), info, limits)) {
    if (info.recording == Recording::full) {
        parts_->file.emplace(parts_->path, info);
    }
}

Recorder::~Recorder() = default;

void Recorder::note(const Message& message, Instant when) {
    if (!parts_->failure.empty()) {
        return;
    }
    if (parts_->file) {
        parts_->guarded([&] { parts_->note_in_file(message, when); });
    } else {
        parts_->note_in_window(message, when);
    }
}

bool Recorder::has_unwritten() const {
    return parts_->waiting_since.has_value();
}

void Recorder::idle() {
    if (has_unwritten()) {
        parts_->guarded([this] { parts_->file->flush(); });
        parts_->waiting_since.reset();
    }
}

Recorder::Saved Recorder::save() {
    if (!parts_->failure.empty()) {
        throw TraceError(parts_->failure);
    }
    if (!parts_->file) {
        return parts_->write_flight();  // May fail now and succeed later.
    }
    parts_->guarded([this] { parts_->file->flush(); });
    parts_->waiting_since.reset();
    return {parts_->file->messages(), parts_->file->bytes()};
}

void Recorder::close() {
    if (parts_->file && parts_->failure.empty()) {
        parts_->guarded([this] { parts_->file->close(); });
    }
}

template <typename Act>
void RecordingLink::reporting(const Act& act) {
    try {
        act();
    } catch (const TraceError& error) {
        link_.send(host_id, fault_message(id(), id(), 0, schema::FaultCode::internal,
                                          fmt::format("recording stops: {}", error.what())));
    }
}

void RecordingLink::answer(NodeId who) {
    schema::TraceSavedT saved;
    try {
        const Recorder::Saved written = recorder_.save();
        saved.messages = written.messages;
        saved.bytes = written.bytes;
    } catch (const TraceError& error) {
        saved.error = error.what();
    }
    link_.send(who, pack(saved));
}

std::optional<Message> RecordingLink::receive() {
    while (std::optional<Message> message = link_.receive()) {
        const bool is_for_link = message->kind() == Body::SaveTrace;
        const bool is_kept = !is_for_link && !is_onlookers(message->kind());
        if (is_kept && (!leave_out_ || !leave_out_(*message))) {
            reporting([&] { recorder_.note(*message); });
        }
        if (!is_for_link) {
            return message;
        }
        answer(message->source());
    }
    return std::nullopt;
}

bool RecordingLink::wait(int timeout_ms) {
    if (!recorder_.has_unwritten()) {
        return link_.wait(timeout_ms);
    }
    const int first_ms = timeout_ms < 0 ? quiet_ms : std::min(timeout_ms, quiet_ms);
    if (link_.wait(first_ms)) {
        return true;
    }
    reporting([this] { recorder_.idle(); });
    return timeout_ms != first_ms && link_.wait(timeout_ms < 0 ? -1 : timeout_ms - first_ms);
}

}  // namespace pxpl5::bus::trace
