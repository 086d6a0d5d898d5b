// Small cases for tests: one slab a GP, all voxels different.
#pragma once

#include "host/timing/paper_case.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing::testing {

/// Edges looked at of a volume of n x n x 2 voxels, no two neighbors alike: in both slices
/// n (n - 1) along x and as many along y, n n along z.
constexpr std::uint64_t edges_of(std::uint64_t n) {
    return 4 * n * (n - 1) + n * n;
}

/// A volume of n x n x 2, a surface of so many triangles in it, a frame of as many primitives.
inline PaperCase small_case(std::uint32_t n, std::uint64_t triangles, std::uint64_t primitives) {
    PaperCase made;
    made.volume = {"small", n, n, 2, 2, {std::uint64_t{n} * n, std::uint64_t{n} * n}};
    made.build.slabs = {{0, triangles / 2, triangles / 2, triangles}};
    made.frame = frame_of(128, 128, 1, primitives);
    made.row.paper = {static_cast<std::int64_t>(triangles), 1, 1};
    return made;
}

/// One GP; pictures are shown almost as soon as they are ready.
inline Machine small_machine() {
    Machine machine = round_machine();
    machine.gps = machine.renderers = machine.frame_buffers = 1;
    machine.frame_buffer_refresh_hz = 1e6;
    return machine;
}

}  // namespace pxpl5::host::timing::testing
