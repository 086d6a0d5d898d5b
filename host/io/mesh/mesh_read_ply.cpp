// PLY as text or binary. assimp loops or crashes on files that are cut.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_polygon.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::string_view blanks = " \t\r\n";

struct Type {
    char kind = 'i';  ///< i: signed, u: unsigned, f: floating point.
    std::size_t bytes = 0;
};

struct Property {
    std::string_view name;
    Type type;                  ///< Type of one value.
    std::optional<Type> count;  ///< Type of the count, if the property is a list.
};

struct Element {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    while (true) {
        line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
        if (line.empty()) return words;
        words.push_back(line.substr(0, line.find_first_of(blanks)));
        line.remove_prefix(words.back().size());
    }
}

class PlyFile {
  public:
    PlyFile(const std::string& path, std::string_view bytes) : path_(path), left_(bytes) {}

    MeshFile run() {
        read_heading();
        for (const Element& element : elements_) {
            if (element.name == "tristrips") fail("has strips, which are not read");
            if (element.properties.empty()) continue;
            for (index_ = 0; index_ < element.count; ++index_) {
                element_ = element.name;
                read_one(element);
            }
        }
        return std::move(out_);
    }

  private:
    [[noreturn]] void fail(const std::string& reason) const {
        throw MeshError(path_ + ": " + reason);
    }

    std::string_view next_line() {
        const std::size_t end = left_.find('\n');
        if (end == std::string_view::npos) {
            fail("has no end_header. The file may be truncated, or it is no PLY file.");
        }
        const std::string_view line = left_.substr(0, end);
        left_.remove_prefix(end + 1);
        return line;
    }

    Type type_of(std::string_view name) const {
        struct Named {
            std::string_view name, other;
            Type type;
        };
        constexpr std::array types = {
            Named{"char", "int8", {'i', 1}},     Named{"uchar", "uint8", {'u', 1}},
            Named{"short", "int16", {'i', 2}},   Named{"ushort", "uint16", {'u', 2}},
            Named{"int", "int32", {'i', 4}},     Named{"uint", "uint32", {'u', 4}},
            Named{"float", "float32", {'f', 4}}, Named{"double", "float64", {'f', 8}}};
        for (const Named& each : types) {
            if (name == each.name || name == each.other) return each.type;
        }
        fail(fmt::format("has type '{}', which PLY does not define", name));
    }

    void read_heading() {
        if (words_of(next_line()) != std::vector<std::string_view>{"ply"}) {
            fail("does not begin with 'ply'");
        }
        while (true) {
            const std::vector<std::string_view> words = words_of(next_line());
            if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
            if (words[0] == "end_header") return;
            if (words[0] == "format" && words.size() == 3) {
                set_format(words[1]);
            } else if (words[0] == "element" && words.size() == 3) {
                const double count =
                    number_of(path_ + ": element " + std::string(words[1]), words[2]);
                if (count < 0 || count > double(max_export_count)) fail("has too many elements");
                elements_.push_back({words[1], static_cast<std::uint64_t>(count), {}});
            } else if (words[0] == "property" && !elements_.empty() && words.size() == 3) {
                elements_.back().properties.push_back({words[2], type_of(words[1]), {}});
            } else if (words[0] == "property" && !elements_.empty() && words.size() == 5 &&
                       words[1] == "list") {
                elements_.back().properties.push_back(
                    {words[4], type_of(words[3]), type_of(words[2])});
            } else {
                fail(fmt::format("heading has '{}', which PLY does not define", words[0]));
            }
        }
    }

    void set_format(std::string_view name) {
        is_text_ = name == "ascii";
        is_big_ = name == "binary_big_endian";
        if (!is_text_ && !is_big_ && name != "binary_little_endian") {
            fail(fmt::format("has format '{}', which PLY does not define", name));
        }
    }

    [[noreturn]] void fail_at_end() const {
        fail(fmt::format("ends in {} {}. The file may be truncated.", element_, index_));
    }

    double next(const Type& type) {
        if (is_text_) {
            left_.remove_prefix(std::min(left_.find_first_not_of(blanks), left_.size()));
            const std::string_view word = left_.substr(0, left_.find_first_of(blanks));
            if (word.empty()) fail_at_end();
            left_.remove_prefix(word.size());
            return number_of(fmt::format("{}: {} {}", path_, element_, index_), word);
        }
        if (left_.size() < type.bytes) fail_at_end();
        std::array<char, 8> raw{};
        std::memcpy(raw.data(), left_.data(), type.bytes);
        left_.remove_prefix(type.bytes);
        if (is_big_) std::reverse(raw.begin(), raw.begin() + static_cast<long>(type.bytes));
        if (type.kind == 'f') return type.bytes == 4 ? as<float>(raw) : as<double>(raw);
        if (type.kind == 'u') return static_cast<double>(as<std::uint64_t>(raw));
        return type.bytes == 1   ? as<std::int8_t>(raw)
               : type.bytes == 2 ? as<std::int16_t>(raw)
                                 : as<std::int32_t>(raw);
    }

    template <typename T>
    static T as(const std::array<char, 8>& raw) {
        T value{};
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }

    void read_one(const Element& element) {
        glm::dvec3 p(0);
        for (const Property& property : element.properties) {
            if (property.count) {
                const bool is_face =
                    element.name == "face" && property.name.starts_with("vertex_ind");
                read_list(property, is_face);
                continue;
            }
            const double value = next(property.type);
            for (int axis = 0; axis < 3; ++axis) {
                if (property.name == std::string_view("xyz").substr(std::size_t(axis), 1)) {
                    p[axis] = value;
                }
            }
        }
        if (element.name == "vertex") out_.points.emplace_back(p);
    }

    void read_list(const Property& property, bool is_face) {
        const double count = next(*property.count);
        std::vector<std::uint32_t> corners;
        for (double i = 0; i < count; ++i) {
            const double corner = next(property.type);
            if (!is_face) continue;
            if (!(corner >= 0 && corner < static_cast<double>(out_.points.size()))) {
                fail(
                    fmt::format("face {} has vertex {} of {}", index_, corner, out_.points.size()));
            }
            corners.push_back(static_cast<std::uint32_t>(corner));
        }
        add_polygon(out_, corners);
    }

    const std::string& path_;
    std::string_view left_;
    bool is_text_ = false, is_big_ = false;
    std::vector<Element> elements_;
    std::string_view element_;  ///< Name of the element that is read, for errors.
    std::uint64_t index_ = 0;   ///< Its number.
    MeshFile out_;
};

}  // namespace

MeshFile read_ply(const std::string& path, std::string_view bytes) {
    return PlyFile(path, bytes).run();
}

}  // namespace pxpl5::host::io
