// Times of what the host does with meshes: gathering, certifying, taking apart, counting
// components.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <random>

#include "host/base/stopwatch.hpp"
#include "host/phantom/phantom.hpp"
#include "host/surface/atlas/histogram.hpp"
#include "host/surface/atlas/isovalue_components.hpp"
#include "host/surface/compare.hpp"
#include "tests/host/phantom/phantom_probe.hpp"
#include "tests/host/surface/surface_support.hpp"

using namespace pxpl5;

namespace {

constexpr int runs = 5;

/// The least of some runs, in milliseconds.
template <class Work>
double least_ms(Work work) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < runs; ++i) {
        const std::int64_t start_ns = host::now_ns();
        work();
        least = std::min(least, host::ms_since(start_ns));
    }
    return least;
}

void bench_mesh(const char* name, const test::Volume& volume, double isovalue) {
    const auto grid = test::grid_of(volume.shape);
    const auto messages = test::messages_of(test::extract_slabs(volume, isovalue), 4);
    host::WeldedMesh mesh;
    const double gather_ms = least_ms([&] { mesh = test::gather(messages, grid); });
    host::Certificate certificate;
    const double certify_ms = least_ms([&] { certificate = host::certify(mesh, grid); });
    const double components_ms = least_ms([&] { host::find_components(mesh, grid); });
    const double compare_ms = least_ms([&] { host::compare_meshes(mesh, mesh, grid); });
    const double nearest_ms = least_ms([&] { host::nearest_point(mesh, grid, {1, 2, 3}); });
    fmt::print(
        "{}: {} triangles, {} components; gather {:.1f} ms, certify {:.1f} ms, components "
        "{:.1f} ms, compare {:.1f} ms, nearest {:.1f} ms\n",
        name, mesh.triangles.size(), certificate.components, gather_ms, certify_ms, components_ms,
        compare_ms, nearest_ms);
}

void bench_components(const char* name, const host::Volume& volume) {
    std::vector<double> isovalues;
    for (int i = 0; i < 256; ++i)
        isovalues.push_back(volume.minimum + (i + 0.5) * (volume.maximum - volume.minimum) / 256);
    std::vector<host::ComponentCounts> counts;
    const double count_ms = least_ms([&] { counts = host::count_components(volume, isovalues); });
    const double histogram_ms = least_ms([&] { host::histogram(volume, 256); });
    std::uint32_t most = 0;
    for (const auto& c : counts) most = std::max(most, c.surface());
    fmt::print(
        "{}: {}x{}x{} voxels, 256 isovalues, at most {} components; {:.0f} ms; histogram "
        "{:.1f} ms\n",
        name, volume.nx, volume.ny, volume.nz, most, count_ms, histogram_ms);
}

}  // namespace

int main() {
    const host::Volume head = host::make_phantom("phantom:head");
    bench_mesh("phantom:head skin", test::for_gps(head), 70.5);
    std::mt19937 random(1);
    const auto noise = [&](int n) {
        return test::random_volume({n, n, n}, Scalar::int16, 1000, random);
    };
    const test::Volume rough = noise(100);
    bench_mesh("noise", noise(116), 500);
    bench_components("phantom:head", head);
    bench_components("noise", test::for_host(rough));
    return 0;
}
