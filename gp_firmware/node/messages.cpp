#include "gp_firmware/node/messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "ringbus/rules/slice_planes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;

glm::dmat4 matrix_of(const schema::Matrix& wire) {
    glm::dmat4 m;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            m[column][row] = wire.m()->Get(static_cast<flatbuffers::uoffset_t>(column * 4 + row));
        }
    }
    return m;
}

}  // namespace

static_assert(sizeof(Origin) == sizeof(schema::Origin) && alignof(Origin) == 2);

flatbuffers::Offset<flatbuffers::Vector<const schema::Origin*>> origins_to_wire(
    flatbuffers::FlatBufferBuilder& builder, std::span<const Origin> origins) {
    static_assert(FLATBUFFERS_LITTLEENDIAN);
    // The fields have the layout of the message.
    schema::Origin* out = nullptr;
    const auto at = builder.CreateUninitializedVectorOfStructs(origins.size(), &out);
    if (!origins.empty()) {  // The list of a slab without triangles has no pointer.
        std::memcpy(static_cast<void*>(out), origins.data(), origins.size_bytes());
    }
    return at;
}

void rethrow_as_fault(const bus::FaultCause& cause) {
    try {
        throw;
    } catch (const OutOfLocalMemory& e) {
        throw bus::NodeFault(schema::FaultCode::out_of_memory, e.what(), cause);
    } catch (const std::invalid_argument& e) {
        throw bus::NodeFault(schema::FaultCode::bad_input, e.what(), cause);
    } catch (const bus::NodeFault& e) {
        throw bus::NodeFault(e.code, e.what(), cause);
    } catch (const std::bad_alloc&) {
        throw bus::NodeFault(schema::FaultCode::out_of_memory, bus::memory_exhausted, cause);
    }
}

std::uint64_t to_us(std::chrono::steady_clock::duration elapsed) {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(elapsed).count());
}

VolumeShape shape_of(const schema::VolumeHeader& header) {
    VolumeShape shape;
    shape.nx = static_cast<int>(header.nx());
    shape.ny = static_cast<int>(header.ny());
    shape.nz = static_cast<int>(header.nz());
    shape.type = header.type();
    shape.voxel_to_patient = matrix_of(*header.voxel_to_patient());
    shape.minimum = header.minimum();
    shape.maximum = header.maximum();
    shape.slabs_per_set = header.slabs_per_set();
    shape.gradient = header.gradient();
    if (header.slice_places() != nullptr) {
        shape.slice_places.assign(header.slice_places()->begin(), header.slice_places()->end());
    }
    if (header.gap_slabs() != nullptr) {
        shape.gap_slabs.assign(header.gap_slabs()->begin(), header.gap_slabs()->end());
    }
    return shape;
}

SlicePlane slice_plane_of(const schema::SlicePlane& plane) {
    return {plane.axis(), static_cast<int>(plane.index()), plane.black(), plane.white()};
}

FrameRequest frame_request(const schema::DrawFrame& draw, const VolumeShape& shape) {
    FrameRequest request;
    request.frame = draw.frame();
    request.counts = draw.counts();
    request.gap_slabs = shape.gap_slabs;
    for (const auto* view : *draw.views()) {
        Camera& camera = request.views.emplace_back();
        camera.voxel_to_eye = matrix_of(*view->voxel_to_eye());
        camera.projection = matrix_of(*view->projection());
        camera.voxel_to_patient = shape.voxel_to_patient;
        camera.width_px = static_cast<int>(draw.width());
        camera.height_px = static_cast<int>(draw.height());
        if (draw.clip_planes() != nullptr) {
            for (const schema::ClipPlane* p : *draw.clip_planes()) {
                camera.clip_planes.emplace_back(p->a(), p->b(), p->c(), p->d());
            }
        }
    }
    for (const schema::SurfaceDraw* surface : *draw.surfaces()) {
        request.surfaces.push_back({surface->surface(), surface->revision(), surface->cull_back(),
                                    surface->slabs(), surface->detail()});
    }
    for (std::size_t index = bus::first_plane(draw); index < request.surfaces.size(); ++index) {
        request.surfaces[index].plane = slice_plane_of(*bus::plane_at(draw, index));
    }
    return request;
}

std::span<const std::uint64_t> costs_of(const schema::DrawFrame& draw) {
    if (draw.region_costs() == nullptr) {
        return {};
    }
    return {draw.region_costs()->data(), draw.region_costs()->size()};
}

bus::Payload begin_frame_message(const schema::DrawFrame& draw,
                                 const std::vector<std::uint16_t>& assignment) {
    schema::BeginFrameT begin;
    begin.draw.reset(draw.UnPack());
    begin.draw->region_costs.clear();  // Only the assignment needs the costs.
    begin.assignment = assignment;
    return bus::pack(begin);
}

SlabMesh slab_mesh_of(const schema::ScenePart& part) {
    SlabMesh mesh;
    mesh.slab = static_cast<int>(part.slab());
    const auto component = [](float value) {
        return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0F, 1.0F) * normal_one));
    };
    mesh.vertices.reserve(part.vertices()->size());
    for (const schema::MeshVertex* v : *part.vertices()) {
        mesh.vertices.push_back({{v->x(), v->y(), v->z()},
                                 {component(v->nx()), component(v->ny()), component(v->nz())}});
    }
    mesh.indices.assign(part.indices()->begin(), part.indices()->end());
    mesh.spheres.reserve(part.spheres()->size());
    for (const schema::SceneSphere* s : *part.spheres()) {
        mesh.spheres.push_back({{s->x(), s->y(), s->z()}, s->radius()});
    }
    mesh.lines.reserve(part.lines()->size());
    for (const schema::SceneLine* l : *part.lines()) {
        mesh.lines.push_back({{l->ax(), l->ay(), l->az()}, {l->bx(), l->by(), l->bz()}});
    }
    return mesh;
}

bus::Payload surface_built_message(std::uint16_t surface, const HeldSurface& held,
                                   std::size_t memory_bytes, std::uint64_t elapsed_us,
                                   int gps_to_hold_all) {
    schema::SurfaceBuiltT built;
    built.surface = surface;
    built.revision = held.revision;
    for (const SlabMesh& mesh : held.slabs) {
        const SlabCounts& c = mesh.counts;
        built.slabs.emplace_back(static_cast<std::uint32_t>(mesh.slab), c.triangles, c.vertices,
                                 c.cells_active, c.cells_ambiguous, c.rows_skipped, c.cells_visited,
                                 c.edges_visited, c.edges_crossed, c.area_mm2, c.volume_mm3);
        built.left_out += mesh.left_out ? 1 : 0;
    }
    built.gps_to_hold_all = static_cast<std::uint32_t>(gps_to_hold_all);
    built.memory_bytes = memory_bytes;
    built.elapsed_us = elapsed_us;
    return bus::pack(built);
}

bus::Payload frame_counts_message(std::uint32_t frame, const FrameDrawing& drawing) {
    schema::FrameCountsT counts;
    counts.frame = frame;
    for (const DrawnSlab& slab : drawing.drawn()) {
        counts.drawn.emplace_back(slab.surface, slab.slab, slab.primitives, slab.culled);
    }
    for (const RegionProgram& region : drawing.programs().regions()) {
        counts.words += region.word_count();
    }
    return bus::pack(counts);
}

bus::Payload isovalues_measured_message(const std::vector<int>& slabs,
                                        std::span<const SlabCounts> counts) {
    schema::IsovaluesMeasuredT measured;
    const std::size_t isovalues = slabs.empty() ? 0 : counts.size() / slabs.size();
    for (std::size_t s = 0; s < slabs.size(); ++s) {
        auto curve = std::make_unique<schema::SlabCurveT>();
        curve->slab = static_cast<std::uint32_t>(slabs[s]);
        for (const SlabCounts& c : counts.subspan(s * isovalues, isovalues)) {
            curve->counts.emplace_back(c.triangles, c.area_mm2, c.volume_mm3);
        }
        measured.slabs.push_back(std::move(curve));
    }
    return bus::pack(measured);
}

}  // namespace pxpl5::gp
