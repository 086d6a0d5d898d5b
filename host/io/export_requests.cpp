#include "host/io/export_requests.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <vector>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_read.hpp"
#include "host/io/picture/picture.hpp"
#include "host/io/request_needs.hpp"
#include "host/scene/marks_messages.hpp"

namespace pxpl5::host::io {

namespace {

namespace schema = bus::schema;

std::string text_of(const flatbuffers::String* text) {
    return text == nullptr ? "" : text->str();
}

/// A number of the message as one that the writers check against their limits.
int whole(std::uint32_t number) {
    return static_cast<int>(std::min<std::uint32_t>(number, INT32_MAX));
}

Picture picture_of(const schema::ExportPicture& request) {
    Picture picture;
    picture.width = whole(request.width());
    picture.height = whole(request.height());
    picture.rgba = {request.rgba()->data(), request.rgba()->size()};
    picture.description = text_of(request.description());
    picture.count = whole(request.count());
    picture.delay_ms = whole(request.delay_ms());
    if (request.attributes() != nullptr) {
        for (const schema::Attribute* attribute : *request.attributes()) {
            picture.attributes.push_back({attribute->name()->str(), attribute->value()->str()});
        }
    }
    if (request.marks() != nullptr) {
        for (const schema::Mark* mark : *request.marks()) {
            picture.marks.push_back(mark_of(*mark));
        }
    }
    return picture;
}

/// A view of the message's surface: what a scan gives is too large to be copied.
MeshSurface surface_of(const schema::ExportSurface& wire) {
    static_assert(sizeof(MeshPoint) == sizeof(schema::MeshVertex));
    static_assert(alignof(MeshPoint) == alignof(schema::MeshVertex));
    const auto& vertices = *wire.vertices();
    const auto& indices = *wire.indices();
    const schema::Rgb& color = *wire.color();
    return {wire.name()->str(),
            {color.r(), color.g(), color.b()},
            {reinterpret_cast<const MeshPoint*>(vertices.Data()), vertices.size()},
            {reinterpret_cast<const std::uint32_t*>(indices.Data()), indices.size()}};
}

std::unique_ptr<schema::ExportSurfaceT> content_of(const std::string& name,
                                                   std::span<const MeshPoint> vertices,
                                                   std::span<const std::uint32_t> indices) {
    auto surface = std::make_unique<schema::ExportSurfaceT>();
    surface->name = name;
    surface->color = std::make_unique<schema::Rgb>();
    const auto* first = reinterpret_cast<const schema::MeshVertex*>(vertices.data());
    surface->vertices.assign(first, first + vertices.size());
    surface->indices.assign(indices.begin(), indices.end());
    return surface;
}

std::vector<bus::Payload> one(bus::Payload payload) {
    std::vector<bus::Payload> list;
    list.push_back(std::move(payload));
    return list;
}

schema::IoDoneT failed(const std::string& reason) {
    schema::IoDoneT done;
    done.ok = false;
    done.error = reason;
    return done;
}

}  // namespace

schema::IoDoneT export_picture(const schema::ExportPicture& request) {
    try {
        write_picture(request.path()->str(), picture_of(request));
    } catch (const PictureError& error) {
        return failed(error.what());
    }
    schema::IoDoneT done;
    done.ok = true;
    return done;
}

std::vector<bus::Payload> export_mesh(const schema::ExportMesh& request) {
    try {
        MeshExport mesh;
        for (const schema::ExportSurface* surface : *request.surfaces()) {
            mesh.surfaces.push_back(surface_of(*surface));
        }
        mesh.axes = request.axes();
        mesh.description = text_of(request.description());
        mesh.keep = static_cast<double>(request.keep());
        mesh.error_mm = request.error_mm();
        const MeshWritten written = write_mesh(request.path()->str(), mesh);
        std::vector<bus::Payload> answer;
        if (!written.decimated.empty()) {
            schema::MeshContentT content;
            for (const auto& [name, surface] : written.decimated) {
                content.surfaces.push_back(content_of(name, surface.vertices, surface.indices));
            }
            answer.push_back(bus::pack(content));
        }
        schema::IoDoneT done;
        done.ok = true;
        done.text = written.text;
        done.triangles = written.triangles;
        answer.push_back(bus::pack(done));
        return answer;
    } catch (const MeshError& error) {
        return one(bus::pack(failed(error.what())));
    }
}

std::vector<bus::Payload> read_mesh_file(const schema::ReadMesh& request) {
    try {
        const MeshFile file = read_mesh(request.path()->str());
        std::vector<MeshPoint> vertices;
        for (const glm::vec3& p : file.points) {
            vertices.push_back({p, glm::vec3(0)});
        }
        schema::MeshContentT content;
        content.surfaces.push_back(content_of("", vertices, file.indices));
        schema::IoDoneT done;
        done.ok = true;
        done.triangles = file.indices.size() / 3;
        std::vector<bus::Payload> answer = one(bus::pack(content));
        answer.push_back(bus::pack(done));
        return answer;
    } catch (const MeshError& error) {
        schema::IoDoneT done = failed(error.what());
        done.bad_data = true;
        return one(bus::pack(done));
    }
}

int serve_one_request(const Limits& limits, bool confines) {
    constexpr int bad_data = 65, failed_code = 1;
    std::vector<std::uint8_t> body;
    std::array<std::uint8_t, 1 << 16> block{};
    while (const std::size_t got = std::fread(block.data(), 1, block.size(), stdin)) {
        body.insert(body.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(got));
    }
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(bus::Body::ExportPicture), bus::host_id,
                                bus::host_id, 0, 0, 0, body.size(), 0, 0, 0);
    try {
        const bus::Message request(header, body, nullptr);
        limit_next_request(limits);
        if (confines) {
            confine(needs_of(request, {}));
        }
        const bus::Payload answer = bus::pack(export_picture(*request.as<schema::ExportPicture>()));
        const std::span<const std::uint8_t> bytes = answer.bytes();
        const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size();
        return written && std::fflush(stdout) == 0 ? 0 : failed_code;
    } catch (const bus::BadMessage& error) {
        std::fprintf(stderr, "pxpl5-io: %s\n", error.what());
        return bad_data;
    }
}

}  // namespace pxpl5::host::io
