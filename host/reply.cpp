#include "host/reply.hpp"

#include <nlohmann/json.hpp>

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

/// One line whatever the bytes: names of files need not be UTF-8.
std::string dump(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string json_text(const Fields& fields) {
    return dump(to_json(fields));
}

std::string json_line(const std::string& command, const Reply& reply, double elapsed_ms) {
    Json line{{"command", command}, {"ok", true}};
    line["result"] = to_json(reply.fields);
    line["ms"] = elapsed_ms;
    return dump(line);
}

std::string json_error_line(const std::string& command, const std::string& error, int exit_code,
                            double elapsed_ms) {
    return dump(Json{{"command", command},
                     {"ok", false},
                     {"error", error},
                     {"exit_code", exit_code},
                     {"ms", elapsed_ms}});
}

}  // namespace pxpl5::host
