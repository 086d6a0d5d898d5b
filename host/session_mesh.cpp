// What a session reads back of surfaces.
#include <span>

#include "host/digest.hpp"
#include "host/session.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

std::uint64_t digest_of(const schema::SlabMesh& mesh) {
    Digest digest;
    const auto add = [&digest](const auto& vector) {
        digest.add({reinterpret_cast<const std::byte*>(vector.Data()),
                    vector.size() * sizeof(*vector.data())});
    };
    add(*mesh.vertices());
    add(*mesh.keys());
    add(*mesh.indices());
    return digest.value();
}

}  // namespace

void Session::fetch_mesh(const std::string& name, bool origins,
                         const std::function<void(const schema::MeshPart&)>& take) {
    const Surface& surface = find_surface(name);
    schema::FetchMeshT request;
    request.surface = surface.id;
    request.origins = origins;
    ask_gps("mesh of " + name, bus::pack(request), [&](const bus::Message& message) {
        const auto* part = message.as<schema::MeshPart>();
        if (part == nullptr || part->surface() != surface.id ||
            part->revision() != surface.revision) {
            return false;
        }
        take(*part);
        return true;
    });
}

std::uint64_t Session::mesh_digest(const std::string& name) {
    std::map<std::uint32_t, std::uint64_t> slab_digests;
    fetch_mesh(name, false, [&](const schema::MeshPart& part) {
        for (const auto* mesh : *part.slabs()) {
            slab_digests[mesh->slab()] = digest_of(*mesh);
        }
    });
    Digest digest;
    for (const auto& [slab, value] : slab_digests) {
        digest.add(std::as_bytes(std::span(&value, 1)));
    }
    return digest.value();
}

}  // namespace pxpl5::host
