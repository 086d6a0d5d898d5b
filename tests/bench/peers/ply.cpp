#include "tests/bench/peers/ply.hpp"

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>

namespace pxpl5::peer {

namespace {

constexpr std::size_t max_elements = 100'000'000;
constexpr std::size_t corners = 3;

struct Element {
    std::size_t count = 0;
    std::size_t fixed_bytes = 0;  ///< Size of all properties that are no lists.
};

struct Head {
    std::map<std::string, Element> elements;
    std::string vertex_properties;  ///< "x y z nx ..."
    std::size_t end = 0;            ///< Where the elements begin.
};

std::size_t bytes_of(const std::string& type) {
    static const std::map<std::string, std::size_t> sizes = {
        {"float", 4}, {"int", 4}, {"uint", 4}, {"uchar", 1}, {"short", 2}};
    const auto found = sizes.find(type);
    if (found == sizes.end()) {
        throw std::runtime_error("unknown type " + type);
    }
    return found->second;
}

Head parse_head(std::string_view data) {
    constexpr std::string_view last = "end_header\n";
    const std::size_t end = data.find(last);
    if (!data.starts_with("ply\n") || end == std::string_view::npos) {
        throw std::runtime_error("not a PLY file");
    }
    Head head;
    head.end = end + last.size();
    std::istringstream lines{std::string(data.substr(0, end))};
    std::string element;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string word, type, name;
        words >> word >> type;
        if (word == "format" && type != "binary_little_endian") {
            throw std::runtime_error("format " + type + " is not understood");
        }
        if (word == "element") {
            element = type;
            words >> head.elements[element].count;
        } else if (word == "property" && type != "list") {
            words >> name;
            head.elements[element].fixed_bytes += bytes_of(type);
            head.vertex_properties += element == "vertex" ? name + " " : "";
        }
    }
    return head;
}

/// Takes bytes one after the other.
class Cursor {
  public:
    Cursor(std::string_view data, std::size_t at) : data_(data), at_(at) {}

    const char* take(std::size_t bytes) {
        if (data_.size() - at_ < bytes) {
            throw std::runtime_error("ends before its last element");
        }
        at_ += bytes;
        return data_.data() + at_ - bytes;
    }

  private:
    std::string_view data_;
    std::size_t at_;
};

}  // namespace

Mesh parse_ply(std::string_view data) {
    Head head = parse_head(data);
    const Element vertex = head.elements["vertex"], face = head.elements["face"];
    if (!head.vertex_properties.starts_with("x y z nx ny nz ")) {
        throw std::runtime_error("vertices are not x y z nx ny nz");
    }
    if (vertex.count > max_elements || face.count > max_elements) {
        throw std::runtime_error("has more than " + std::to_string(max_elements) + " elements");
    }
    Cursor cursor(data, head.end);
    Mesh mesh;
    mesh.vertices.resize(vertex.count);
    for (Vertex& v : mesh.vertices) {
        std::memcpy(&v, cursor.take(vertex.fixed_bytes), sizeof v);
    }
    mesh.indices.resize(face.count * corners);
    for (std::size_t i = 0; i < mesh.indices.size(); i += corners) {
        if (*cursor.take(1) != corners) {
            throw std::runtime_error("has a face that is no triangle");
        }
        std::memcpy(&mesh.indices[i], cursor.take(corners * sizeof(std::uint32_t)),
                    corners * sizeof(std::uint32_t));
        cursor.take(face.fixed_bytes);
    }
    for (const std::uint32_t index : mesh.indices) {
        if (index >= mesh.vertices.size()) {
            throw std::runtime_error("a triangle names vertex " + std::to_string(index) + " of " +
                                     std::to_string(mesh.vertices.size()));
        }
    }
    return mesh;
}

Mesh read_ply(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string data{std::istreambuf_iterator<char>(file), {}};
    try {
        return parse_ply(data);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path + ": " + error.what());
    }
}

}  // namespace pxpl5::peer
