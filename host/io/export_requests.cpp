#include "host/io/export_requests.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <vector>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/picture/picture.hpp"
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
    const schema::Rgb& colour = *wire.colour();
    return {wire.name()->str(),
            {colour.r(), colour.g(), colour.b()},
            {reinterpret_cast<const MeshPoint*>(vertices.Data()), vertices.size()},
            {reinterpret_cast<const std::uint32_t*>(indices.Data()), indices.size()}};
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

schema::IoDoneT export_mesh(const schema::ExportMesh& request) {
    try {
        MeshExport mesh;
        for (const schema::ExportSurface* surface : *request.surfaces()) {
            mesh.surfaces.push_back(surface_of(*surface));
        }
        mesh.axes = request.axes();
        mesh.description = text_of(request.description());
        mesh.keep = static_cast<double>(request.keep());
        const MeshWritten written = write_mesh(request.path()->str(), mesh);
        schema::IoDoneT done;
        done.ok = true;
        done.text = written.text;
        done.triangles = written.triangles;
        return done;
    } catch (const MeshError& error) {
        return failed(error.what());
    }
}

int serve_one_request(const Limits& limits) {
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
