// A GP's stages: rows into masks, gradients, cells into triangles, vertices onto the screen; and
// the node's way from a message to a surface, and to a frame's streams.
#include <benchmark/benchmark.h>

#include <vector>

#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/surface/classify.hpp"
#include "gp_firmware/volume/gradient.hpp"
#include "host/scene/camera.hpp"
#include "tests/bench/parts.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;

namespace {

/// Which built-in volume, by the benchmark's argument.
host::PhantomInfo phantom_of(const benchmark::State& state) {
    constexpr const char* names[] = {"phantom:pelvis", "phantom:fetus", "phantom:head"};
    return test::info_of(names[state.range(0)]);
}

void name_phantoms(benchmark::internal::Benchmark* bench) {
    bench->ArgName("volume")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
}

/// One GP that holds a whole volume.
struct Loaded {
    explicit Loaded(const benchmark::State& state)
        : info(phantom_of(state)),
          volume(test::for_gps(host::make_phantom(info.name))),
          gp(volume, {0, 1}) {}

    double isovalue() const { return info.surfaces.front().isovalue; }

    host::PhantomInfo info;
    test::Volume volume;
    test::Gp gp;
};

void count_rate(benchmark::State& state, const char* name, double per_iteration) {
    state.counters[name] = benchmark::Counter(
        per_iteration, benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}

void classify(benchmark::State& state) {
    const Loaded loaded(state);
    const gp::VolumeShape& shape = loaded.volume.shape;
    std::vector<std::uint64_t> mask(gp::mask_words(shape.nx));
    for (auto _ : state) {
        for (int z = 0; z < shape.nz; ++z) {
            for (int y = 0; y < shape.ny; ++y) {
                benchmark::DoNotOptimize(
                    gp::classify_row(shape, loaded.gp.store.slice(z), y, loaded.isovalue(), mask));
            }
        }
        benchmark::ClobberMemory();
    }
    count_rate(state, "voxels", static_cast<double>(shape.slice_voxels()) * shape.nz);
}

void march(benchmark::State& state) {
    const Loaded loaded(state);
    gp::SlabMesh mesh;
    std::uint32_t triangles = 0;
    for (auto _ : state) {
        triangles = 0;
        for (const int slab : loaded.gp.store.slabs()) {
            gp::extract_slab(loaded.gp.store, slab, loaded.isovalue(),
                             gp::case_table(CaseRule::watertight), mesh);
            triangles += mesh.counts.triangles;
        }
    }
    count_rate(state, "triangles", triangles);
}

void measure_gradients(benchmark::State& state, GradientKernel kernel) {
    const Loaded loaded(state);
    gp::VolumeShape shape = loaded.volume.shape;
    shape.gradient = kernel;
    const int z = shape.nz / 2;
    const gp::SliceNeighbors slices{loaded.volume.slice(z - 1), loaded.volume.slice(z),
                                    loaded.volume.slice(z + 1)};
    for (auto _ : state) {
        benchmark::DoNotOptimize(gp::estimate_gradients(shape, slices));
    }
    count_rate(state, "voxels", static_cast<double>(shape.slice_voxels()));
}

void gradients(benchmark::State& state) {
    measure_gradients(state, GradientKernel::central);
}

void smooth_gradients(benchmark::State& state) {
    measure_gradients(state, GradientKernel::smooth);
}

/// Measures a GP's load: slices, gradients, runs and ranges of rows.
void take_slices(benchmark::State& state) {
    const test::Volume volume = test::for_gps(host::make_phantom(phantom_of(state).name));
    for (auto _ : state) {
        const test::Gp gp(volume, {0, 1});
        benchmark::DoNotOptimize(gp.store.complete());
    }
    count_rate(state, "voxels", static_cast<double>(volume.shape.slice_voxels()) * volume.shape.nz);
}

void transform(benchmark::State& state) {
    const Loaded loaded(state);
    const gp::VolumeShape& shape = loaded.volume.shape;
    const std::vector<gp::SlabMesh> meshes = test::extract_all(loaded.volume, loaded.isovalue());
    const host::CameraMatrices matrices = host::camera_matrices(
        {}, host::subject_of(shape.nx, shape.ny, shape.nz, shape.voxel_to_patient), 1);
    gp::Camera camera;
    camera.voxel_to_eye = matrices.patient_to_eye * shape.voxel_to_patient;
    camera.projection = matrices.projection;
    camera.voxel_to_patient = shape.voxel_to_patient;
    camera.width_px = camera.height_px = 512;
    const gp::Projection projection = gp::prepare(camera);
    std::vector<gp::GridVertex> screen;
    std::vector<std::uint32_t> outside;
    std::size_t vertices = 0;
    for (const gp::SlabMesh& mesh : meshes) {
        vertices += mesh.vertices.size();
        screen.resize(std::max(screen.size(), mesh.vertices.size()));
        outside.resize(screen.size());
    }
    for (auto _ : state) {
        for (const gp::SlabMesh& mesh : meshes) {
            const std::size_t count = mesh.vertices.size();
            gp::transform(mesh.vertices, projection, std::span(screen).first(count),
                          std::span(outside).first(count));
            benchmark::ClobberMemory();
        }
    }
    count_rate(state, "vertices", static_cast<double>(vertices));
}

/// SetSurface to SurfaceBuilt: all of an isovalue's change but the ring.
void gp_surface(benchmark::State& state) {
    bench::Parts parts(phantom_of(state).name, {512, 512});
    std::uint32_t triangles = 0;
    for (auto _ : state) {
        triangles = parts.extract();
    }
    count_rate(state, "triangles", triangles);
}

/// DrawFrame to RegionPrograms: transform, culling, set-up, encoding, the message.
void gp_frame(benchmark::State& state) {
    bench::Parts parts(phantom_of(state).name, {512, 512});
    const std::uint32_t triangles = parts.extract();
    std::uint32_t frame = 0;
    for (auto _ : state) {
        parts.draw(++frame);
    }
    count_rate(state, "triangles", triangles);
}

BENCHMARK(classify)->Apply(name_phantoms);
BENCHMARK(gradients)->Apply(name_phantoms);
BENCHMARK(smooth_gradients)->Apply(name_phantoms);
BENCHMARK(take_slices)->Apply(name_phantoms);
BENCHMARK(march)->Apply(name_phantoms);
BENCHMARK(transform)->Apply(name_phantoms);
BENCHMARK(gp_surface)->Apply(name_phantoms);
BENCHMARK(gp_frame)->Apply(name_phantoms);

}  // namespace
