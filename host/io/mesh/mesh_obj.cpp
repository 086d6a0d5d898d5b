// Wavefront OBJ: text, a group and a material for each surface.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "host/io/mesh/mesh_formats.hpp"

namespace pxpl5::host::io {

namespace {

/// Text on its way into the file, in large pieces.
class TextOut {
  public:
    explicit TextOut(PartFile& file) : file_(file) {}
    ~TextOut() { flush(); }
    TextOut(const TextOut&) = delete;
    TextOut& operator=(const TextOut&) = delete;

    template <typename... Values>
    void line(fmt::format_string<Values...> pattern, Values&&... values) {
        fmt::format_to(std::back_inserter(buffer_), pattern, std::forward<Values>(values)...);
        buffer_.push_back('\n');
        if (buffer_.size() > piece_bytes) {
            flush();
        }
    }

  private:
    static constexpr std::size_t piece_bytes = std::size_t{1} << 16;

    void flush() {
        file_.write({buffer_.data(), buffer_.size()});
        buffer_.clear();
    }

    PartFile& file_;
    fmt::memory_buffer buffer_;
};

/// A name without blanks, which end a name here; the number keeps equal names apart.
std::string group_name(const MeshExport& mesh, std::size_t index) {
    std::string name = one_line(mesh.surfaces[index].name);
    std::replace(name.begin(), name.end(), ' ', '_');
    const bool is_alone =
        std::count_if(mesh.surfaces.begin(), mesh.surfaces.end(), [&](const MeshSurface& other) {
            return other.name == mesh.surfaces[index].name;
        }) == 1;
    const bool is_itself = name == mesh.surfaces[index].name;
    return !name.empty() && is_alone && is_itself ? name : fmt::format("{}_{}", name, index);
}

void write_surface(const MeshExport& mesh, std::size_t index, std::size_t before, TextOut& out) {
    const MeshSurface& surface = mesh.surfaces[index];
    out.line("g {}\nusemtl {}", group_name(mesh, index), group_name(mesh, index));
    for (const MeshPoint& vertex : surface.vertices) {
        const glm::vec3 p = turned(vertex.p_mm, mesh.axes);
        out.line("v {} {} {}", p.x, p.y, p.z);
    }
    for (const MeshPoint& vertex : surface.vertices) {
        const glm::vec3 n = turned(vertex.normal, mesh.axes);
        out.line("vn {} {} {}", n.x, n.y, n.z);
    }
    const std::size_t offset = before + 1;  // Vertices count from 1, through the whole file.
    for (std::size_t first = 0; first < surface.indices.size(); first += 3) {
        const std::size_t a = surface.indices[first] + offset,
                          b = surface.indices[first + 1] + offset,
                          c = surface.indices[first + 2] + offset;
        out.line("f {}//{} {}//{} {}//{}", a, a, b, b, c, c);
    }
}

}  // namespace

void write_obj(const MeshExport& mesh, const std::string& material_file, PartFile& file) {
    TextOut out(file);
    out.line("# pxpl5");
    for (const std::string& note : mesh_notes(mesh)) {
        out.line("# {}", note);
    }
    out.line("mtllib {}", material_file);
    std::size_t before = 0;
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        write_surface(mesh, index, before, out);
        before += mesh.surfaces[index].vertices.size();
    }
}

void write_mtl(const MeshExport& mesh, PartFile& file) {
    TextOut out(file);
    out.line("# pxpl5");
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        const auto& c = mesh.surfaces[index].color;
        out.line("newmtl {}\nKa 0 0 0\nKd {:.6g} {:.6g} {:.6g}\nKs 0.2 0.2 0.2\nNs 24\nillum 2",
                 group_name(mesh, index), c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
    }
}

}  // namespace pxpl5::host::io
