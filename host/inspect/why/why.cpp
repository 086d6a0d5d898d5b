#include "host/inspect/why/why.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "gp_firmware/surface/edge_vertex.hpp"
#include "host/base/error.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

/// The newest frame of which everything is there; if there is none, the newest.
RecordedFrame default_frame(const RecordedRun& run) {
    const std::vector<std::uint32_t> frames = run.frames();
    if (frames.empty()) {
        throw RequestError(ExitCode::failed, "no frame is recorded in this run");
    }
    for (std::size_t i = frames.size(); i-- > 0;) {
        RecordedFrame frame = run.frame(frames[i]);
        if (frame.missing.empty() && frame.draw().sample() == 0) {
            return frame;
        }
    }
    return run.frame(frames.back());
}

/// The corner that a mesh's key names.
CornerFacts corner_of(const KnownVolume& volume, double isovalue, std::uint64_t key,
                      const gp::Vertex& vertex) {
    CornerFacts corner;
    corner.p_voxel = glm::dvec3(vertex.p_voxel);
    corner.p_mm = volume.to_mm(corner.p_voxel);
    const std::uint64_t axis = key & 3, voxel = key >> 2;
    corner.is_center = axis == 3;
    if (corner.is_center) {
        return corner;
    }
    const auto nx = static_cast<std::uint64_t>(volume.shape().nx);
    const auto ny = static_cast<std::uint64_t>(volume.shape().ny);
    corner.voxel_0 = {static_cast<int>(voxel % nx), static_cast<int>(voxel / nx % ny),
                      static_cast<int>(voxel / nx / ny)};
    corner.voxel_1 = corner.voxel_0;
    ++corner.voxel_1[axis];
    const auto value = [&](const std::array<int, 3>& v) { return volume.value(v[0], v[1], v[2]); };
    corner.value_0 = value(corner.voxel_0);
    corner.value_1 = value(corner.voxel_1);
    corner.fraction = gp::crossing(corner.value_0, corner.value_1, isovalue);
    return corner;
}

/// Fills in what the voxels tell.
void look_at_voxels(PixelInquiry& inquiry, CellFacts& cell) {
    const auto [surface, i, j, k, triangle] = cell.name;
    if (!inquiry.replayed) {
        cell.unknown = "no trace holds the volume's header";
        return;
    }
    ReplayedGp& again = *inquiry.replayed;
    cell.unknown = again.missing(surface, k);
    if (!cell.unknown.empty()) {
        return;
    }
    const gp::VolumeShape& shape = inquiry.volume.shape();
    if (i + 1 >= shape.nx || j + 1 >= shape.ny) {
        cell.unknown =
            fmt::format("cell ({}, {}, {}) is outside of the volume, which has {} x {} cells", i, j,
                        k, shape.nx - 1, shape.ny - 1);
        return;
    }
    cell.values = again.cell(surface, i, j, k).values;
    cell.doubt = again.difference(surface, k);
    const gp::SlabMesh& mesh = again.slab(surface, k, inquiry.place.view).mesh;
    const auto of_cell = [&](const gp::Origin& o) { return o.i == i && o.j == j; };
    const auto first = std::ranges::find_if(mesh.origins, of_cell);
    cell.triangle_count =
        static_cast<int>(std::find_if_not(first, mesh.origins.end(), of_cell) - first);
    if (triangle >= cell.triangle_count) {
        cell.unknown = fmt::format(
            "extracted again, the cell has {} triangles, recorded is "
            "triangle {}",
            cell.triangle_count, triangle);
        return;
    }
    const auto number = static_cast<std::size_t>(first - mesh.origins.begin() + triangle);
    std::array<glm::dvec3, 3> corners;
    for (std::size_t n = 0; n < 3; ++n) {
        const std::uint32_t vertex = mesh.indices[3 * number + n];
        cell.corners[n] = corner_of(inquiry.volume, *inquiry.surfaces[surface].isovalue,
                                    mesh.keys[vertex], mesh.vertices[vertex]);
        corners[n] = cell.corners[n].p_voxel;
    }
    const glm::dvec3 weights =
        ray_weights(again.projection(inquiry.place.view), corners, inquiry.x, inquiry.y_in_view());
    cell.hit_voxel = weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
    cell.hit_mm = inquiry.volume.to_mm(cell.hit_voxel);
}

}  // namespace

glm::dvec3 ray_weights(const gp::Projection& projection, const std::array<glm::dvec3, 3>& corners,
                       int x, int y) {
    const double center_x = gp::subpixels * (x + 0.5), center_y = gp::subpixels * (y + 0.5);
    glm::dvec3 beside{}, below{};
    for (int n = 0; n < 3; ++n) {
        const glm::dvec4 p =
            projection.voxel_to_grid_exact * glm::dvec4(corners[static_cast<std::size_t>(n)], 1);
        beside[n] = p.x - center_x * p.w;
        below[n] = p.y - center_y * p.w;
    }
    const glm::dvec3 weights = glm::cross(beside, below);
    return weights / (weights.x + weights.y + weights.z);
}

FrameInquiry::FrameInquiry(const RecordedRun& recorded, std::optional<std::uint32_t> number,
                           const Volume* held)
    : run(recorded),
      frame(number ? run.frame(*number) : default_frame(run)),
      surfaces(surfaces_of(run, frame)),
      volume(run, frame.number, held) {
    if (volume.has_shape()) {
        try {
            replayed.emplace(frame, surfaces, volume);
        } catch (const std::invalid_argument& error) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("frame {}: {}", frame.number, error.what()));
        }
    }
}

PixelInquiry::PixelInquiry(FrameInquiry& of, int px, int py)
    : run(of.run),
      frame(of.frame),
      surfaces(of.surfaces),
      volume(of.volume),
      replayed(of.replayed),
      x(px),
      y(py),
      place(frame.region_at(x, y)) {
    if (frame.draw().sample() > 0) {
        const std::uint32_t first = frame.number - frame.draw().sample();
        throw RequestError(
            ExitCode::usage,
            fmt::format("frame {} is {} of one picture, the mean of frames {} to {}: ask about "
                        "frame {}, its first sample, or draw the picture with one",
                        frame.number, frame.pass_text(), first, first + frame.draw().samples() - 1,
                        first));
    }
    if (!frame.regions.contains(place.number)) {
        std::string reasons;
        for (const std::string& reason : frame.missing) {
            reasons += "\n  " + reason;
        }
        throw RequestError(
            ExitCode::failed,
            fmt::format("frame {}: region ({}, {}), which holds pixel ({}, {}), cannot be executed "
                        "again, as its messages are not all recorded:{}",
                        frame.number, place.column, place.row, x, y, reasons));
    }
    history = history_of(frame, region(), x, y);
}

PrimitiveFacts PixelInquiry::facts_of(const Primitive& primitive) {
    const renderer::Segment& segment = region().plan.parts[primitive.part].segment;
    PrimitiveFacts facts;
    facts.address = to_text(region().plan, primitive.address());
    facts.gp = segment.gp;
    facts.gp_word = segment.first_word + primitive.first_word;
    const schema::Header& header =
        frame.inputs.at(region().renderer).programs.at(segment.gp).header();
    facts.sequence = header.sequence();
    facts.clock = header.clock();
    facts.surface = segment.surface;
    facts.slab = segment.slab;
    // A primitive that is no triangle of a volume's surface has no case.
    if (primitive.origin && segment.surface < surfaces.size()) {
        const schema::Origin& o = *primitive.origin;
        CellFacts& cell = facts.cell.emplace();
        cell.name = {segment.surface, o.i(), o.j(), static_cast<int>(segment.slab), o.triangle()};
        cell.origin = {o.i(), o.j(), o.inside(), o.joined(), o.triangle(), o.piece()};
        look_at_voxels(*this, cell);
    }
    return facts;
}

const PrimitiveFacts* WhyFinding::shown() const {
    const PixelVisit* visit = history.shown();
    return visit == nullptr ? nullptr
                            : &facts[static_cast<std::size_t>(visit - history.visits.data())];
}

WhyFinding why_of(PixelInquiry& inquiry) {
    WhyFinding finding;
    finding.frame = inquiry.frame.number;
    finding.renderer = inquiry.region().renderer;
    for (const PixelVisit& visit : inquiry.history.visits) {
        finding.facts.push_back(inquiry.facts_of(inquiry.history.primitives[visit.primitive]));
    }
    if (inquiry.volume.has_shape()) {
        const schema::VolumeHeader& header = inquiry.volume.header();
        finding.source = header.source() == nullptr ? header.name()->str() : header.source()->str();
        finding.values_from = inquiry.volume.values_from();
        finding.slices = static_cast<int>(header.nz());
    }
    finding.surfaces = inquiry.surfaces;
    finding.history = inquiry.history;
    return finding;
}

WhyFinding why(FrameInquiry& frame, int x, int y) {
    PixelInquiry inquiry(frame, x, y);
    return why_of(inquiry);
}

}  // namespace pxpl5::host::inspect
