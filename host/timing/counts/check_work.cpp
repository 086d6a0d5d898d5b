#include "host/timing/counts/check_work.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "generated/vocabulary.hpp"
#include "host/base/error.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr std::uint64_t max_count = std::uint64_t{1}
                                    << 32;  ///< Limit for primitives, words, triangles.
constexpr std::uint32_t max_voxel_bytes = 16;

template <class... Values>
[[noreturn]] void fail(fmt::format_string<Values...> text, Values&&... values) {
    throw RequestError(ExitCode::bad_data, fmt::format(text, std::forward<Values>(values)...));
}

void check_size(const FrameWork& frame) {
    if (std::clamp<std::uint32_t>(frame.width, 1, max_picture_px) != frame.width ||
        std::clamp<std::uint32_t>(frame.height, 1, max_picture_px) != frame.height) {
        fail("frame {}: {} x {} pixels; 1..{} each way may be", frame.frame, frame.width,
             frame.height, max_picture_px);
    }
    if (frame.views < 1 || frame.views > max_views) {
        fail("frame {}: {} views; 1..{} may be", frame.frame, frame.views, max_views);
    }
}

/// Surfaces that a frame draws: one more than the greatest index.
std::uint32_t surfaces_of(const FrameWork& frame) {
    std::uint32_t surfaces = 0;
    for (const DrawnSlab& slab : frame.drawn) {
        if (slab.surface >= max_surfaces) {
            fail("frame {}: slab {} is of surface {}; at most {} may be", frame.frame, slab.slab,
                 slab.surface, max_surfaces);
        }
        if (slab.primitives > max_count) {
            fail("frame {}: surface {}, slab {}: {} primitives; at most {} may be", frame.frame,
                 slab.surface, slab.slab, slab.primitives, max_count);
        }
        surfaces = std::max(surfaces, slab.surface + 1);
    }
    return surfaces;
}

void check_part(const FrameWork& frame, const PartWork& part, std::size_t regions,
                std::uint32_t surfaces) {
    if (part.region >= regions) {
        fail("frame {}: a part of region {}; {} x {} pixels in {} views have {}", frame.frame,
             part.region, frame.width, frame.height, frame.views, regions);
    }
    if (part.kind > PartKind::end_of_region) {
        fail("frame {}, region {}: a part of kind {}; the last one is {}", frame.frame, part.region,
             static_cast<int>(part.kind), static_cast<int>(PartKind::end_of_region));
    }
    const bool of_surface = part.kind == PartKind::segment || part.kind == PartKind::shut_door ||
                            part.kind == PartKind::open_door;
    if (of_surface && part.surface >= surfaces) {
        fail("frame {}, region {}: a part of surface {}; the frame draws {}", frame.frame,
             part.region, part.surface, surfaces);
    }
    if (std::max({part.primitives, part.words, part.port_cycles, part.cycles()}) > max_count) {
        fail("frame {}, region {}: a part of {} primitives, {} words, {} cycles; at most {} may be",
             frame.frame, part.region, part.primitives, part.words,
             std::max(part.port_cycles, part.cycles()), max_count);
    }
}

}  // namespace

void check_frame(const FrameWork& frame) {
    check_size(frame);
    const std::uint32_t surfaces = surfaces_of(frame);
    const std::size_t regions = frame.regions();
    for (const PartWork& part : frame.parts) {
        check_part(frame, part, regions, surfaces);
    }
}

void check_volume(const VolumeWork& volume) {
    const std::uint32_t greatest = std::max({volume.nx, volume.ny, volume.nz});
    if (std::min({volume.nx, volume.ny, volume.nz}) < 1 || greatest > max_volume_voxels) {
        fail("{}: {} x {} x {} voxels; 1..{} each way may be", volume.name, volume.nx, volume.ny,
             volume.nz, max_volume_voxels);
    }
    if (volume.voxel_bytes < 1 || volume.voxel_bytes > max_voxel_bytes) {
        fail("{}: voxels of {} bytes; 1..{} may be", volume.name, volume.voxel_bytes,
             max_voxel_bytes);
    }
    if (volume.runs.size() != volume.nz) {
        fail("{}: runs of {} slices are counted; it has {}", volume.name, volume.runs.size(),
             volume.nz);
    }
    const std::uint64_t voxels = std::uint64_t{volume.nx} * volume.ny;
    for (std::size_t z = 0; z < volume.runs.size(); ++z) {
        if (volume.runs[z] < volume.ny || volume.runs[z] > voxels) {
            fail("{}: slice {} has {} runs; {} rows of {} voxels have {}..{}", volume.name, z,
                 volume.runs[z], volume.ny, volume.nx, volume.ny, voxels);
        }
    }
}

void check_build(const BuildWork& build, const VolumeWork* volume) {
    if (volume == nullptr) {
        fail("surface {}, revision {}: it is built from a volume; none was loaded before",
             build.surface, build.revision);
    }
    for (const SlabWork& slab : build.slabs) {
        if (slab.slab >= volume->nz - 1) {
            fail("surface {}, revision {}: slab {}; {} has {} slices", build.surface,
                 build.revision, slab.slab, volume->name, volume->nz);
        }
        if (slab.triangles > max_count) {
            fail("surface {}, revision {}: slab {} has {} triangles; at most {} may be",
                 build.surface, build.revision, slab.slab, slab.triangles, max_count);
        }
    }
}

void check_assignment(const FrameWork& frame, std::uint32_t renderers) {
    if (frame.assignment.size() != frame.regions()) {
        fail("frame {}: {} regions are assigned to Renderers; it has {}", frame.frame,
             frame.assignment.size(), frame.regions());
    }
    const std::size_t used = std::size_t{1} + std::ranges::max(frame.assignment);
    const std::size_t expected = std::min<std::size_t>(renderers, frame.regions());
    if (used != expected) {
        fail(
            "frame {}: its regions were assigned to {} Renderers; the machine has {}: a recorded "
            "assignment cannot be taken over",
            frame.frame, used, renderers);
    }
}

}  // namespace pxpl5::host::timing
