#include "host/serve/director/viewer_message.hpp"

#include <fmt/core.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/base/command_line.hpp"
#include "host/base/json_depth.hpp"

namespace pxpl5::host::serve {

namespace {

using Json = nlohmann::json;

constexpr std::size_t quoted_bytes = 80;  ///< Bytes of a message that an error quotes.
constexpr int max_depth = 16;             ///< Depth of nested lists and objects.

/// The value of a key, if it exists. Throws RequestError if the value has another type.
template <typename T>
std::optional<T> value(const Json& message, const char* key, Json::value_t type) {
    const auto found = message.find(key);
    if (found == message.end()) {
        return std::nullopt;
    }
    if (found->type() != type) {
        const std::string given = found->is_structured()
                                      ? fmt::format("an {}", found->type_name())
                                      : found->dump(-1, ' ', false, Json::error_handler_t::replace)
                                            .substr(0, quoted_bytes);
        refuse_command(
            fmt::format("message: \"{}\" is {}, which is of the wrong type", key, given));
    }
    return found->get<T>();
}

/// Throws RequestError if lists or objects are nested too deeply for recursive code.
Json parse(std::string_view text) {
    ParsedJson message = parse_json(text, max_depth);
    if (message.levels > max_depth) {
        refuse_command(
            fmt::format("message: '{}' has lists or objects in each other {} deep; {} may be",
                        text.substr(0, quoted_bytes), message.levels, max_depth));
    }
    return std::move(message.json);
}

std::optional<std::uint32_t> id_of(const Json& message) {
    const auto id = value<std::uint64_t>(message, "id", Json::value_t::number_unsigned);
    if (id && *id > std::numeric_limits<std::uint32_t>::max()) {
        refuse_command(fmt::format("message: id {} is above {}", *id,
                                   std::numeric_limits<std::uint32_t>::max()));
    }
    return id ? std::optional(static_cast<std::uint32_t>(*id)) : std::nullopt;
}

/// Reads all but the id.
void read_content(const Json& message, std::string_view text, ViewerMessage& read) {
    read.line = value<std::string>(message, "do", Json::value_t::string);
    read.ask = value<std::string>(message, "ask", Json::value_t::string);
    if (read.ask) {
        read.axis = value<std::string>(message, "axis", Json::value_t::string);
        read.is_ahead = value<bool>(message, "ahead", Json::value_t::boolean).value_or(false);
    }
    read.panel = value<bool>(message, "panel", Json::value_t::boolean);
    read.cancels = value<bool>(message, "cancel", Json::value_t::boolean).value_or(false);
    read.is_ping = value<bool>(message, "ping", Json::value_t::boolean).value_or(false);
    const auto eyes = message.find("eyes");
    read.is_of_headset = eyes != message.end();
    const int meanings = int{read.line.has_value()} + int{read.ask.has_value()} +
                         int{read.panel.has_value()} + int{read.cancels} + int{read.is_ping} +
                         int{read.is_of_headset};
    if (meanings != 1) {
        refuse_command(
            fmt::format("message: '{}' has {} of do, ask, panel, cancel, ping and eyes, not one",
                        text.substr(0, quoted_bytes), meanings));
    }
    if (read.is_of_headset && !eyes->is_null()) {
        read.eyes = read_headset_eyes(*eyes);
    }
    if ((read.ask || read.is_ping) && !read.id) {
        refuse_command(fmt::format("message: {} has no id to answer to",
                                   read.ask ? fmt::format("ask \"{}\"", *read.ask) : "ping"));
    }
}

}  // namespace

ViewerMessage read_viewer_message(std::string_view text) {
    ViewerMessage read;
    try {
        const Json message = parse(text);
        if (!message.is_object()) {
            refuse_command(
                fmt::format("message: '{}' is no JSON object", text.substr(0, quoted_bytes)));
        }
        read.id = id_of(message);
        read_content(message, text, read);
    } catch (const RequestError& error) {
        throw MessageError(error, read.id);
    }
    return read;
}

}  // namespace pxpl5::host::serve
