#include "host/serve/director/inspector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "generated/page_schema.hpp"
#include "host/base/error.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/slice_picture.hpp"
#include "host/inspect/why/live_frame.hpp"
#include "host/scene/oblique.hpp"
#include "host/serve/director/slice_packing.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host::serve {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t alignment = 8;
/// Limit of contour pieces in an answer, over all surfaces: 8 MiB. A page can draw so many per
/// frame.
constexpr std::size_t max_pieces = 524'288;

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

template <class Bytes>
void pad(Bytes& bytes) {
    bytes.resize((bytes.size() + alignment - 1) / alignment * alignment);
}

/// Appends the bytes of `values`. All machines of the ring are little-endian.
template <class T>
void append(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
    const auto* first = reinterpret_cast<const std::byte*>(values);
    bytes.insert(bytes.end(), first, first + count * sizeof(T));
}

/// A value in an error's text: the value itself if it is short.
std::string shown(const Json& value) {
    constexpr std::size_t longest = 40;
    const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

Json parse(std::string_view message) {
    Json ask = Json::parse(message, nullptr, false);
    if (!ask.is_object()) {
        refuse("ask: the message is no JSON object");
    }
    return ask;
}

std::string text_of(const Json& ask, const char* key, const char* may_be) {
    const auto found = ask.find(key);
    if (found == ask.end() || !found->is_string()) {
        refuse(fmt::format("ask: '{}' is {}; it must be {}", key,
                           found == ask.end() ? "missing" : shown(*found), may_be));
    }
    return found->get<std::string>();
}

/// A whole number in [low, high].
std::int64_t whole_of(const Json& ask, const char* key, std::int64_t low, std::int64_t high) {
    const auto found = ask.find(key);
    // Numbers above the signed range are out of range here, too.
    const bool is_whole = found != ask.end() && found->is_number_integer() &&
                          !(found->is_number_unsigned() && found->get<std::uint64_t>() > INT64_MAX);
    const std::int64_t value = is_whole ? found->get<std::int64_t>() : 0;
    if (!is_whole || value < low || value > high) {
        refuse(fmt::format("ask: '{}' is {}; it must be a whole number from {} to {}", key,
                           found == ask.end() ? "missing" : shown(*found), low, high));
    }
    return value;
}

std::string hex(Color c) {
    return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
}

Json places_of(const SliceSide& side) {
    return side.places_mm.empty() ? Json(nullptr) : Json(side.places_mm);
}

Json json_of(const SliceFrame& frame, Scalar type) {
    const SliceSide &across = frame.across, &down = frame.down;
    return {{"width", across.count},
            {"height", down.count},
            {"type", enum_name(type)},
            {"spacing_mm", {across.spacing_mm, down.spacing_mm}},
            {"places_mm", {places_of(across), places_of(down)}},
            {"skew_deg", frame.skew_deg},
            {"letters",
             {{"left", across.begin},
              {"right", across.end},
              {"top", down.begin},
              {"bottom", down.end}}},
            {"axes", {across.axis, down.axis, frame.through}},
            {"flips", {across.is_flipped, down.is_flipped}}};
}

/// Nothing for a single slice.
std::optional<SlabWish> slab_of(const Json& ask) {
    const auto found = ask.find("slab_mm");
    if (found == ask.end() || *found == 0) {
        return std::nullopt;
    }
    const double thickness_mm = found->is_number() ? found->get<double>() : -1;
    if (!(thickness_mm > 0 && thickness_mm <= max_place_mm)) {
        refuse(fmt::format("ask: 'slab_mm' is {}; it must be a number from 0 to {}", shown(*found),
                           max_place_mm));
    }
    constexpr const char* may_be = R"("mean", "max" or "min")";
    const std::string name = text_of(ask, "kind", may_be);
    const auto* const kind = std::ranges::find(slab_kinds, name);
    if (kind == slab_kinds.end()) {
        refuse(fmt::format("ask: 'kind' is {}; it must be {}", shown(name), may_be));
    }
    return SlabWish{thickness_mm, static_cast<SlabKind>(kind - slab_kinds.begin())};
}

/// Adds contours to an answer: what the page draws them with to the JSON, pieces to the bytes.
class ContourAppender {
  public:
    ContourAppender(Json& json, Answer& answer) : json_(json), answer_(answer) {
        json_["contours"] = Json::array();
    }
    void add(const Surface& surface, const std::vector<ContourPiece>& pieces) {
        const std::size_t count = pieces.size();
        const bool fits = first_ + count <= max_pieces;
        json_["contours"].push_back({{"surface", surface.name},
                                     {"color", hex(surface.color)},
                                     {"isovalue", surface.isovalue},
                                     {"first", first_},
                                     {"count", fits ? count : 0},
                                     {"left_out", fits ? 0 : count}});
        if (fits) {
            append(answer_.bytes, pieces.data(), count);
            first_ += count;
        }
    }

  private:
    Json& json_;
    Answer& answer_;
    std::size_t first_ = 0;
};

double real_of(const Json& ask, const char* key, double low, double high) {
    const auto found = ask.find(key);
    const bool is_number = found != ask.end() && found->is_number();
    const double value = is_number ? found->get<double>() : 0;
    if (!is_number || !(value >= low && value <= high)) {
        refuse(fmt::format("ask: '{}' is {}; it must be a number from {} to {}", key,
                           found == ask.end() ? "missing" : shown(*found), low, high));
    }
    return value;
}

glm::dvec3 vector_of(const Json& ask, const char* key) {
    const auto found = ask.find(key);
    const bool is_list = found != ask.end() && found->is_array() && found->size() == 3;
    glm::dvec3 vector(0);
    for (std::size_t k = 0; k < 3; ++k) {
        const double number = is_list && (*found)[k].is_number() ? (*found)[k].get<double>() : NAN;
        if (!(std::abs(number) <= max_place_mm)) {
            refuse(fmt::format("ask: '{}' is {}; it must be three numbers from {} to {}", key,
                               found == ask.end() ? "missing" : shown(*found), -max_place_mm,
                               max_place_mm));
        }
        vector[static_cast<int>(k)] = number;
    }
    return vector;
}

ObliquePlane plane_of(const Json& ask) {
    constexpr std::int64_t most_px = 1024;
    constexpr double tolerance = 1e-6, least_mm = 1e-3, most_mm = 1e3;
    ObliquePlane plane;
    plane.center_mm = vector_of(ask, "center_mm");
    plane.right = vector_of(ask, "right");
    plane.down = vector_of(ask, "down");
    plane.width = static_cast<int>(whole_of(ask, "width", 2, most_px));
    plane.height = static_cast<int>(whole_of(ask, "height", 2, most_px));
    plane.pixel_mm = real_of(ask, "pixel_mm", least_mm, most_mm);
    if (std::abs(glm::length(plane.right) - 1) > tolerance ||
        std::abs(glm::length(plane.down) - 1) > tolerance ||
        std::abs(glm::dot(plane.right, plane.down)) > tolerance) {
        refuse(
            fmt::format("ask: 'right' is {} and 'down' is {}; they must have the length 1 and "
                        "be at a right angle",
                        shown(ask["right"]), shown(ask["down"])));
    }
    return plane;
}

/// Whether the page asks for packed bytes.
bool wants_packed(const Json& ask) {
    const auto found = ask.find("packed");
    if (found != ask.end() && !found->is_boolean()) {
        refuse(fmt::format("ask: 'packed' is {}; it must be true or false", shown(*found)));
    }
    return found != ask.end() && found->get<bool>();
}

/// Completes an answer to `ask slice`.
/// packed  Its bytes, of which the first width * height values of `type` are the slice, are packed.
void finish_slice(Answer& answer, Json& json, Scalar type, bool packed) {
    if (packed) {
        const auto count = json["width"].get<std::size_t>() * json["height"].get<std::size_t>();
        const std::size_t bytes = answer.bytes.size();
        const auto begin = std::chrono::steady_clock::now();
        answer.bytes = pack_slice(answer.bytes, count, size_bytes(type));
        const std::chrono::duration<double, std::milli> took =
            std::chrono::steady_clock::now() - begin;
        json["packed"] = {{"bytes", bytes}, {"ms", took.count()}};
    }
    answer.json = json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Answer answer_oblique(const Session& session, const Json& ask) {
    const ObliquePlane plane = plane_of(ask);
    const bool packed = wants_packed(ask);
    const Volume& volume = session.volumes.volume();
    require_all_voxels(volume, "an oblique slice");
    const std::vector<float> values = oblique_values(volume, plane);
    Answer answer;
    append(answer.bytes, values.data(), values.size());
    pad(answer.bytes);
    Json json = json_of(oblique_frame(plane), Scalar::float32);
    json["frame"] = volume.frame;
    json["axes"] = nullptr;
    json["flips"] = nullptr;
    ContourAppender contours(json, answer);
    for (const SurfaceContour& contour : contours_of(session.scene, plane, values)) {
        contours.add(*contour.surface, contour.pieces);
    }
    finish_slice(answer, json, Scalar::float32, packed);
    return answer;
}

Answer answer_slice(Session& session, const Json& ask) {
    const Volume& volume = session.volumes.volume();
    constexpr const char* may_be = R"("x", "y", "z" or "oblique")";
    const std::string name = text_of(ask, "axis", may_be);
    if (name == "oblique") {
        return answer_oblique(session, ask);
    }
    const std::size_t axis = std::string_view("xyz").find(name);
    if (name.size() != 1 || axis == std::string_view::npos) {
        refuse(fmt::format("ask: 'axis' is {}; it must be {}", shown(name), may_be));
    }
    const std::array counts = {volume.nx, volume.ny, volume.nz};
    const auto index = whole_of(ask, "index", 0, counts[axis] - 1);
    const std::optional<SlabWish> wish = slab_of(ask);
    const bool packed = wants_packed(ask);
    const int along = static_cast<int>(axis), at = static_cast<int>(index);
    const Slab slab = wish ? session.voxels.slab(along, at, *wish)
                           : Slab{session.voxels.slice(along, at), {}, {at, at}};
    const Slice& slice = slab.middle;
    const Slice& shown_values = wish ? slab.values : slice;
    Answer answer{"", shown_values.values};
    pad(answer.bytes);
    Json json = json_of(slice.frame, shown_values.type);
    json["frame"] = session.volumes.volume().frame;
    if (wish) {
        json["slab"] = {{"thickness_mm", wish->thickness_mm},
                        {"kind", slab_kinds.at(static_cast<std::size_t>(wish->kind))},
                        {"slices", {slab.range.first, slab.range.last}},
                        {"type", enum_name(slice.type)}};
    }
    ContourAppender contours(json, answer);
    for (const SurfaceContour& contour : contours_of(session.scene, slice)) {
        contours.add(*contour.surface, contour.pieces);
    }
    if (wish) {
        append(answer.bytes, slice.values.data(), slice.values.size());
    }
    finish_slice(answer, json, shown_values.type, packed);
    return answer;
}

Answer answer_scrub(Session& session, const Json& ask) {
    const Size& size = session.scene.size;
    const int x = static_cast<int>(whole_of(ask, "x", 0, size.width - 1));
    const int y = static_cast<int>(whole_of(ask, "y", 0, size.height - 1));
    inspect::ScrubWish wish;
    wish.at = whole_of(ask, "at", -1, INT64_MAX);
    if (ask.contains("field")) {
        wish.field = text_of(ask, "field", "a field of pixel memory, as \"z\"");
    }
    const inspect::ScrubView view = inspect::LiveFrame::of(session).scrub(x, y, wish);
    Json json = {{"at", view.at},           {"count", view.count},
                 {"region", view.region},   {"renderer", view.renderer},
                 {"x0", view.x0_px},        {"y0", view.y0_px},
                 {"enabled", view.enabled}, {"field", view.field},
                 {"lines", Json::array()}};
    for (const inspect::ScrubLine& line : view.lines) {
        json["lines"].push_back({{"at", line.at},
                                 {"address", line.address},
                                 {"text", line.text},
                                 {"meaning", line.meaning},
                                 {"effect", line.effect}});
    }
    Answer answer{json.dump(), {}};
    append(answer.bytes, view.rgba.data(), view.rgba.size());
    return answer;
}

struct Question {
    std::string_view name;
    Answer (*answer)(Session&, const Json&);
};

constexpr std::array questions = {Question{"slice", answer_slice}, Question{"scrub", answer_scrub}};

/// Questions of the page; other files answer the last three.
constexpr const char* all_questions = R"("slice", "scrub", "folder", "series" or "attributes")";

}  // namespace

Answer answer(Session& session, std::string_view message) {
    const Json ask = parse(message);
    const std::string name = text_of(ask, "ask", all_questions);
    for (const Question& question : questions) {
        if (question.name == name) {
            return question.answer(session, ask);
        }
    }
    refuse(fmt::format("ask: 'ask' is {}; it must be {}", shown(name), all_questions));
}

std::string answer_message(std::uint32_t id, const Answer& answer) {
    AnswerHeader header;
    header.id = id;
    header.json_bytes = static_cast<std::uint32_t>(answer.json.size());
    std::string message(reinterpret_cast<const char*>(&header), sizeof header);
    message += answer.json;
    pad(message);
    message.append(reinterpret_cast<const char*>(answer.bytes.data()), answer.bytes.size());
    return message;
}

}  // namespace pxpl5::host::serve
