// The counted work of a run: the model's only input. It depends on the volume, the
// commands and the camera, never on how many nodes ran it or when.
//
//   recorded run --recorded_work()--+
//                                   +--> RunWork --simulate()--> RunTime
//   live session ----live_work()----+
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "generated/vocabulary.hpp"
#include "isa/instruction_counts.hpp"

namespace pxpl5::host::timing {

/// A volume that is handed to the GPs.
struct VolumeWork {
    std::string name;
    std::uint32_t nx = 0, ny = 0, nz = 0;
    std::uint32_t voxel_bytes = 0;
    /// nz: runs of equal values in the slice's rows, summed over them; ny for a constant slice.
    std::vector<std::uint64_t> runs;
    GradientKernel gradient = GradientKernel::central;
    friend bool operator==(const VolumeWork&, const VolumeWork&) = default;
};

/// Counts of extraction in one slab, the cells between slices `slab` and `slab` + 1.
struct SlabWork {
    std::uint32_t slab = 0;
    std::uint64_t cells_active = 0;  ///< Crossed by the surface.
    std::uint64_t vertices = 0;      ///< Owned by the slab.
    std::uint64_t triangles = 0;
    friend bool operator==(const SlabWork&, const SlabWork&) = default;
};

/// A surface that is extracted again from the volume that was loaded last.
struct BuildWork {
    std::uint16_t surface = 0;
    std::uint32_t revision = 0;
    double isovalue = 0;
    std::vector<SlabWork> slabs;  ///< Ascending.
    friend bool operator==(const BuildWork&, const BuildWork&) = default;
};

/// Primitives of one slab that a GP takes through a frame: transform, cull, set up, bin. Slabs
/// without any are left out; masked triangles count.
struct DrawnSlab {
    std::uint32_t surface = 0;  ///< Index in the frame's list.
    std::uint32_t slab = 0;
    std::uint64_t primitives =
        0;  ///< Triangles, spheres and lines, over all views; before culling.
    friend bool operator==(const DrawnSlab&, const DrawnSlab&) = default;
};

using isa::InstructionClass;
inline constexpr std::size_t instruction_classes = isa::class_count;
using isa::ClassCounts;  ///< Executed; cycles are at the Renderer's clock.

/// Counts of a Renderer for one part of a region.
struct PartWork {
    std::uint32_t region = 0;
    PartKind kind = PartKind::segment;
    std::uint32_t surface = 0;         ///< Segments and doors: index in the frame's list.
    std::uint32_t slab = 0;            ///< Segments only.
    std::uint64_t primitives = 0;      ///< Segments only.
    std::uint64_t words = 0;           ///< Segments only: words from GP to Renderer.
    std::uint64_t port_cycles = 0;     ///< PIXELSTOFB: pixels leave while the array is free.
    std::uint64_t backing_cycles = 0;  ///< BSWAIT only.
    std::array<ClassCounts, instruction_classes> classes{};  ///< All that was executed.
    std::uint64_t cycles() const;                            ///< Over all classes.
    friend bool operator==(const PartWork&, const PartWork&) = default;
};

struct FrameWork {
    std::uint32_t frame = 0;
    std::uint32_t width = 0, height = 0, views = 1;  ///< Pixels of a view.
    bool reads_out = true;                           ///< False for a pass that is not the last.
    std::vector<DrawnSlab> drawn;                    ///< Ascending by (surface, slab).
    std::vector<PartWork> parts;                     ///< By region, then in the order of execution.
    std::vector<std::uint16_t> assignment;           ///< Renderer of each region, as it was drawn.
    std::uint32_t sample = 0, samples = 1;           ///< Which pass of its picture; of how many.
    std::size_t regions() const;
    /// Cycles per region, all its parts together.
    std::vector<std::uint64_t> region_cycles() const;
    friend bool operator==(const FrameWork&, const FrameWork&) = default;
};

using StepWork = std::variant<VolumeWork, BuildWork, FrameWork>;

struct RunWork {
    std::vector<StepWork> steps;       ///< In the order of the host's commands.
    std::vector<std::string> missing;  ///< Missing counts, one sentence each.
};

}  // namespace pxpl5::host::timing
