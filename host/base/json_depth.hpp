// JSON from outside of the program. Copies and dump() of nlohmann's JSON recurse, so that nesting
// has a limit.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

namespace pxpl5::host {

struct ParsedJson {
    nlohmann::json json;  ///< Discarded if the text is no JSON, or nested too deeply.
    int levels = 0;       ///< Lists and objects in each other; above the limit if too deeply.
};

/// Parses a text. Ends at the first list or object that is nested more deeply than `max_levels`.
inline ParsedJson parse_json(std::string_view text, int max_levels) {
    using Json = nlohmann::json;
    ParsedJson parsed;
    const auto note_levels = [&](int outer, Json::parse_event_t event, const Json&) {
        const bool begins =
            event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
        parsed.levels = std::max(parsed.levels, begins ? outer + 1 : outer);
        return parsed.levels <= max_levels;
    };
    parsed.json = Json::parse(text, note_levels, false);
    if (parsed.levels > max_levels) {
        parsed.json = Json(Json::value_t::discarded);
    }
    return parsed;
}

}  // namespace pxpl5::host
