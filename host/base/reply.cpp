#include "host/base/reply.hpp"

#include <fmt/format.h>

#include <cassert>
#include <nlohmann/json.hpp>
#include <type_traits>

namespace pxpl5::host {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Fields& fields);

struct ToJson {
    Json operator()(const Fields& fields) const { return to_json(fields); }
    Json operator()(const std::vector<Fields>& list) const {
        Json array = Json::array();
        for (const Fields& fields : list) {
            array.push_back(to_json(fields));
        }
        return array;
    }
    template <typename T>
    Json operator()(const T& value) const {
        return Json(value);
    }
};

Json to_json(const Fields& fields) {
    Json object = Json::object();
    for (const Field& field : fields) {
        object[field.name] = std::visit(ToJson{}, field.value);
    }
    return object;
}

/// A cell of a CSV table.
struct ToCell {
    std::string operator()(std::nullptr_t) const { return ""; }
    std::string operator()(bool value) const { return value ? "true" : "false"; }
    std::string operator()(const std::string& value) const {
        std::string quoted = "\"";
        for (const char c : value) {
            quoted += c == '"' ? "\"\"" : std::string(1, c);
        }
        return quoted + "\"";
    }
    template <typename T>
    std::string operator()(const T& value) const {
        if constexpr (std::is_arithmetic_v<T>) {
            return fmt::format("{}", value);
        }
        assert(false);
        return "";
    }
};

/// One line whatever the bytes: names of files need not be UTF-8.
std::string dump(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json begin_line(const CommandOutcome& outcome, bool ok) {
    return {
        {"schema", json_schema}, {"command", outcome.command}, {"name", outcome.name}, {"ok", ok}};
}

std::string end_line(Json& line, const CommandOutcome& outcome) {
    for (const Fields& restart : outcome.restarts) {
        line["restarts"].push_back(to_json(restart));
    }
    line["ms"] = outcome.elapsed_ms;
    return dump(line);
}

}  // namespace

void add_warning(Reply& reply, const std::string& warning, std::string_view separator) {
    reply.text += std::string(separator) + warning;
    reply.warnings.push_back(warning);
}

std::string json_text(const Fields& fields) {
    return dump(to_json(fields));
}

std::string csv_heading(const Fields& fields) {
    std::string line;
    for (const Field& field : fields) {
        line += (line.empty() ? "" : ",") + field.name;
    }
    return line + "\n";
}

std::string csv_line(const Fields& fields) {
    std::string line;
    for (const Field& field : fields) {
        line += (&field == fields.data() ? "" : ",") + std::visit(ToCell{}, field.value);
    }
    return line + "\n";
}

std::string json_line(const CommandOutcome& outcome, const Reply& reply) {
    Json line = begin_line(outcome, true);
    line["result"] = to_json(reply.fields);
    line["warnings"] = reply.warnings;
    return end_line(line, outcome);
}

std::string json_error_line(const CommandOutcome& outcome, const std::string& error, int exit_code,
                            const Reply* reply) {
    Json line = begin_line(outcome, false);
    line["error"] = error;
    line["exit_code"] = exit_code;
    if (reply != nullptr) {
        line["result"] = to_json(reply->fields);
    }
    line["warnings"] = reply != nullptr ? reply->warnings : std::vector<std::string>();
    return end_line(line, outcome);
}

}  // namespace pxpl5::host
