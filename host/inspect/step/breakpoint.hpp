// Where a stepped run stops: at an instruction, a primitive, a pixel's change.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host/inspect/step/region_stepper.hpp"

namespace pxpl5::host::inspect {

// Breakpoints that stop before an instruction:

/// Its name matches the pattern (* and ?, any case).
struct OpBreak {
    std::string pattern;
};
/// It is the one at this address of this region.
struct AddressBreak {
    std::uint32_t region = 0;
    Address address;
};
/// It begins a primitive: any, or one by its number in the region or by its voxel cell.
struct PrimitiveBreak {
    struct Cell {
        std::uint32_t i = 0, j = 0, k = 0;
    };
    std::optional<std::uint64_t> number;
    std::optional<Cell> cell;
};
/// It begins a part: prologue, a segment, the end-of-region program.
struct PartBreak {};

// Breakpoints that stop after the instruction:

/// It wrote memory of pixel (x, y) of the picture.
struct PixelBreak {
    int x = 0, y = 0;
};
/// It brought z of pixel (x, y) of the picture below a value.
struct DepthBreak {
    int x = 0, y = 0;
    std::uint64_t below = 0;
};
/// It disabled the last enabled pixel.
struct EmptyBreak {};

using Break = std::variant<OpBreak, AddressBreak, PrimitiveBreak, PartBreak, PixelBreak, DepthBreak,
                           EmptyBreak>;

/// "op TREE*", "pixel 100 80", "z 100 80 < 5000".
std::string to_text(const Break& breakpoint);

/// Decides for every place in a region whether breakpoints hold. The places where a breakpoint
/// holds are the same whether the run goes forward or backward.
class Watch {
  public:
    /// All outlive it. `primitives` are those of the region.
    Watch(std::span<const Break> breaks, const RecordedFrame& frame, const RecordedRegion& region,
          std::span<const Primitive> primitives);

    /// False if none of the breakpoints can hold in this region.
    bool possible() const { return !watched_.empty(); }

    /// Must be called before each instruction.
    void before(const RegionStepper& at);
    /// The first breakpoint that holds behind that instruction, or at the region's begin if
    /// `at` has executed none.
    std::optional<std::size_t> after(const RegionStepper& at) const;

  private:
    struct Watched {
        std::size_t index;                      ///< Into the breakpoints.
        int x = 0, y = 0;                       ///< A pixel of the region.
        std::array<bool, isa::op_count> ops{};  ///< Set for an OpBreak.
        bool wrote = false;                     ///< The instruction under way writes the pixel.
        std::uint64_t z = 0;                    ///< Before the instruction.
    };
    bool holds(const Watched& watched, const RegionStepper& at) const;
    std::optional<Watched> watched(std::size_t index) const;

    std::span<const Break> breaks_;
    const RecordedFrame& frame_;
    const RegionPlace& place_;
    std::span<const Primitive> primitives_;
    std::vector<Watched> watched_;
    bool any_enabled_ = false;
};

}  // namespace pxpl5::host::inspect
