// The same surface in millimeters, whatever the axes' order and direction and whatever the format.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <map>
#include <unordered_map>

#include "host/io/import.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/host/io/formats/vti_writer.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr double isovalue = 500.5;     // The letters' surface.
constexpr double tolerance_mm = 1e-3;  // Headers hold float32; the block is 120 mm wide.

/// The letters phantom, small, turned and moved so that no axis is the patient's.
Grid letters(bool oblique) {
    host::io::ImportRequest request;
    request.path = "phantom:letters";
    request.resample_size = {34, 22, 29};
    const host::Volume volume = host::io::import_volume(request);
    Grid grid{{volume.nx, volume.ny, volume.nz}, volume.voxel_to_patient, {}};
    grid.values.resize(volume.values.size() / 2);
    std::memcpy(grid.values.data(), volume.values.data(), volume.values.size());
    if (oblique) {
        const glm::dmat4 turn =
            glm::mat4_cast(glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3))));
        grid.affine = turn * grid.affine;
    }
    return grid;
}

/// New axis i is old axis order[i], backwards if flip[i].
Grid permuted(const Grid& old, std::array<int, 3> order, std::array<bool, 3> flip) {
    Grid grid;
    glm::dvec4 first(0, 0, 0, 1);
    glm::dmat4 to_old(0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto from = static_cast<std::size_t>(order[i]);
        grid.dims[i] = old.dims[from];
        to_old[static_cast<int>(i)][order[i]] = flip[i] ? -1 : 1;
        first[order[i]] = flip[i] ? old.dims[from] - 1 : 0;
    }
    to_old[3] = first;
    grid.affine = old.affine * to_old;
    for (int z = 0; z < grid.dims[2]; ++z) {
        for (int y = 0; y < grid.dims[1]; ++y) {
            for (int x = 0; x < grid.dims[0]; ++x) {
                const glm::dvec4 at = to_old * glm::dvec4(x, y, z, 1);
                const auto index =
                    (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(old.dims[1]) +
                     static_cast<std::size_t>(at.y)) *
                        static_cast<std::size_t>(old.dims[0]) +
                    static_cast<std::size_t>(at.x);
                grid.values.push_back(old.values[index]);
            }
        }
    }
    return grid;
}

struct Surface {
    std::vector<glm::dvec3> vertices_mm;
    double volume_mm3 = 0;  ///< Enclosed; negative if the triangles face inwards.
    std::size_t triangles = 0;
};

Surface surface_of(const host::Volume& from) {
    Volume volume;
    volume.shape = {
        from.nx,      from.ny,     from.nz, static_cast<Scalar>(from.type), from.voxel_to_patient,
        from.minimum, from.maximum};
    volume.values = from.values;
    std::map<std::uint64_t, glm::dvec3> by_key;  // Slabs share the vertices between them.
    Surface surface;
    for (const gp::SlabMesh& slab : extract_all(volume, isovalue)) {
        std::vector<glm::dvec3> p;
        for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
            p.emplace_back(from.voxel_to_patient *
                           glm::dvec4(glm::dvec3(slab.vertices[i].p_voxel), 1));
            by_key[slab.keys[i]] = p.back();
        }
        for (std::size_t i = 0; i < slab.indices.size(); i += 3) {
            const glm::dvec3 a = p[slab.indices[i]], b = p[slab.indices[i + 1]],
                             c = p[slab.indices[i + 2]];
            surface.volume_mm3 += glm::dot(a, glm::cross(b, c)) / 6;
            ++surface.triangles;
        }
    }
    for (const auto& [key, position] : by_key) {
        surface.vertices_mm.push_back(position);
    }
    return surface;
}

constexpr double cell_mm = 0.01;

/// The number of a cube of space: 21 bits for each axis. `step` leads to one of the 26 around it.
std::uint64_t cell_of(glm::dvec3 p, glm::ivec3 step) {
    const auto bits = [](double mm, int cells) {
        const long at = std::lround(mm / cell_mm) + cells;
        return static_cast<std::uint64_t>(at) & 0x1fffffU;
    };
    return bits(p.x, step.x) << 42U | bits(p.y, step.y) << 21U | bits(p.z, step.z);
}

/// How far the farthest vertex of `a` is from its nearest in `b`, at most one cell.
double farthest(const Surface& a, const Surface& b) {
    std::unordered_multimap<std::uint64_t, glm::dvec3> cells;
    for (const glm::dvec3 p : b.vertices_mm) {
        cells.emplace(cell_of(p, {0, 0, 0}), p);
    }
    double most = 0;
    for (const glm::dvec3 p : a.vertices_mm) {
        double least = cell_mm;
        for (int i = 0; i < 27; ++i) {
            const auto [begin, end] =
                cells.equal_range(cell_of(p, {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}));
            for (auto at = begin; at != end; ++at) {
                least = std::min(least, glm::length(at->second - p));
            }
        }
        most = std::max(most, least);
    }
    return most;
}

void check_same(const Surface& got, const Surface& want) {
    CHECK(got.vertices_mm.size() == want.vertices_mm.size());
    CHECK(farthest(got, want) < tolerance_mm);
    CHECK(farthest(want, got) < tolerance_mm);
    // Cells are cut into other triangles between the same vertices; inwards would be negative.
    CHECK(got.volume_mm3 == doctest::Approx(want.volume_mm3).epsilon(1e-3));
}

host::Volume as_volume(const Grid& grid) {
    host::Volume volume;
    volume.nx = grid.dims[0];
    volume.ny = grid.dims[1];
    volume.nz = grid.dims[2];
    volume.voxel_to_patient = grid.affine;
    volume.values.resize(grid.values.size() * 2);
    std::memcpy(volume.values.data(), grid.values.data(), volume.values.size());
    const auto [low, high] = std::minmax_element(grid.values.begin(), grid.values.end());
    volume.minimum = *low;
    volume.maximum = *high;
    return volume;
}

/// Calls `f` with each of the 48 orders and directions of axes.
template <typename F>
void for_each_turn(F&& f) {
    std::array<int, 3> order = {0, 1, 2};
    do {
        for (unsigned flips = 0; flips < 8; ++flips) {
            f(order, std::array{(flips & 1U) != 0, (flips & 2U) != 0, (flips & 4U) != 0});
        }
    } while (std::next_permutation(order.begin(), order.end()));
}

/// Writes all 48 by `write`, which returns the path, and compares their surfaces.
template <typename Write>
void check_all_turns(Write&& write) {
    const Grid grid = letters(true);
    const Surface want = surface_of(as_volume(grid));
    REQUIRE(want.triangles > 2000);
    REQUIRE(want.volume_mm3 > 50'000);  // Outward: the block alone has more.
    int turns = 0;
    for_each_turn([&](std::array<int, 3> order, std::array<bool, 3> flip) {
        CAPTURE(order[0] * 100 + order[1] * 10 + order[2]);
        CAPTURE(flip[0] * 100 + flip[1] * 10 + flip[2]);
        const TemporaryFolder folder;
        check_same(surface_of(host::io::import_volume(write(folder, permuted(grid, order, flip)))),
                   want);
        ++turns;
    });
    CHECK(turns == 48);
}

}  // namespace

TEST_SUITE("host/io/orientations") {
    TEST_CASE("NIfTI-1 by its sform: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.nii", nifti1_file(grid));
        });
    }

    TEST_CASE("NIfTI-2 by its qform: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.nii", nifti2_file(grid));
        });
    }

    TEST_CASE("NRRD: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.nrrd", nrrd_file(grid));
        });
    }

    TEST_CASE("MetaImage: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.mha", meta_image_file(grid));
        });
    }

    TEST_CASE("MGH: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.mgh", mgh_file(grid));
        });
    }

    TEST_CASE("VTK XML: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return folder.write("v.vti", vti_file(grid));
        });
    }

    TEST_CASE("DICOM: one surface from 48 orders and directions of axes") {
        check_all_turns([](const TemporaryFolder& folder, const Grid& grid) {
            return write_dicom_series(folder, grid, "series");
        });
    }

    TEST_CASE(
        "VTK holds spacing and origin, no direction: the surface along its axes is the same") {
        const TemporaryFolder folder;
        const Grid grid = letters(false);
        check_same(surface_of(host::io::import_volume(folder.write("v.vtk", vtk_file(grid)))),
                   surface_of(as_volume(grid)));
    }
}
