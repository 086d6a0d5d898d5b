#include "host/serve/server/server_viewer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

namespace pxpl5::host::serve {
namespace {

/// The object that the text is, with this key; empty if the text is something else. Most texts are
/// commands, which the session reads: only texts that may be such an object are read here, too.
nlohmann::json short_object(const std::string& text, const std::string& key) {
    constexpr std::size_t longest = 64;
    if (text.size() <= longest && text.find('"' + key + '"') != std::string::npos) {
        nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
        if (json.is_object()) {
            return json;
        }
    }
    return nlohmann::json::object();
}

/// The value of an object that has this key alone.
std::optional<bool> only_bool(const std::string& text, const std::string& key) {
    const nlohmann::json object = short_object(text, key);
    const nlohmann::json value = object.size() == 1 ? object.value(key, nlohmann::json()) : nullptr;
    return value.is_boolean() ? std::optional(value.get<bool>()) : std::nullopt;
}

}  // namespace

double now_ms() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

std::optional<std::string> Viewer::hear(std::string_view part, bool is_final, double now_ms) {
    if (heard_.size() + part.size() > max_text_bytes) {
        closing = {1009, fmt::format("A message can have at most {} bytes.", max_text_bytes)};
        heard_.clear();
        return std::nullopt;
    }
    heard_ += part;
    if (!is_final) {
        return std::nullopt;
    }
    // A bucket that fills steadily and from which each message takes one.
    may_say_ = std::min(messages_at_once,
                        may_say_ + (now_ms - last_heard_ms_) / 1000 * messages_per_second);
    last_heard_ms_ = now_ms;
    if (may_say_ < 1) {
        closing = {1008, fmt::format("More than {} messages per second arrived, {} at once.",
                                     messages_per_second, messages_at_once)};
        return std::nullopt;
    }
    may_say_ -= 1;
    return std::exchange(heard_, {});
}

void Viewer::line_up(Outgoing message) {
    if (closing.code != 0) {
        return;
    }
    const std::size_t bytes = message.bytes->size();
    if (!messages_.empty() && waiting_bytes_ + bytes > max_waiting_bytes) {
        closing = {1013, fmt::format("This viewer reads too slowly: {} bytes are waiting.",
                                     waiting_bytes_ + bytes)};
        messages_.clear();
        waiting_bytes_ = 0;
        return;
    }
    waiting_bytes_ += bytes;
    messages_.push_back(std::move(message));
}

std::optional<Outgoing> Viewer::next_message() {
    if (messages_.empty()) {
        return std::nullopt;
    }
    Outgoing message = std::move(messages_.front());
    messages_.pop_front();
    is_greeted_ = true;
    waiting_bytes_ -= message.bytes->size();
    return message;
}

const Shown* Viewer::next_of(const NewestFrame& frame) const {
    if (frame.sequence > newest_sent(frame)) {
        return &frame.shown;
    }
    const bool lacks_layers =
        wants_depths && frame.layers && frame.layers->revision != layers_sent_;
    return lacks_layers ? frame.layers.get() : nullptr;
}

void Viewer::want_depths(bool wanted, const NewestFrame& newest) {
    if (wanted && !wants_depths) {
        newest_sent_ = newest.shown.depths.empty() ? newest_sent_ : 0;
        layers_sent_ = 0;
    }
    wants_depths = wanted;
}

bool Viewer::wants_newer(const NewestFrame& frame) const {
    return has_room() && frame.sequence <= newest_sent(frame);
}

bool Viewer::has_room() const {
    return is_greeted_ && closing.code == 0 && link.unacknowledged() < max_unacknowledged_frames;
}

std::uint32_t Viewer::count_frame(const NewestFrame& frame) {
    const Shown* const next = next_of(frame);
    if (next != nullptr && next->layers > 1 && wants_depths) {
        layers_sent_ = next->revision;
    }
    (frame.shown.viewer == 0 ? newest_sent_ : newest_pair_sent_) = frame.sequence;
    return ++frames_;
}

std::optional<ShownFrame> shown_frame(const std::string& text) {
    const nlohmann::json message = short_object(text, "shown");
    const nlohmann::json number = message.value("shown", nlohmann::json());
    const nlohmann::json after = message.value("after_ms", nlohmann::json(0));
    if (!number.is_number_unsigned() || number.get<std::uint64_t>() > UINT32_MAX ||
        !after.is_number() || after.get<double>() < 0 ||
        message.size() > (message.contains("after_ms") ? 2 : 1)) {
        return std::nullopt;
    }
    return ShownFrame{number.get<std::uint32_t>(), after.get<double>()};
}

std::optional<bool> wanted_depths(const std::string& text) {
    return only_bool(text, "depths");
}

std::optional<bool> wanted_video(const std::string& text) {
    return only_bool(text, "video");
}

}  // namespace pxpl5::host::serve
