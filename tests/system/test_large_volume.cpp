// A volume that is larger than the memory of the host and of all GPs together.
#include <doctest/doctest.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "host/machine/machine.hpp"
#include "host/scene/slice.hpp"
#include "host/session/session.hpp"
#include "host/surface/certificate.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t host_mib = 400;
constexpr std::int64_t gp_program_mib = 32;  ///< A GP needs this beside its local memory.
constexpr std::int16_t inside = 1;

/// PXPL5_LARGE="1024 1024 2048 4 384" sets the voxels, the number of GPs and the MiB of each.
struct Plan {
    std::int64_t nx = 512, ny = 512, nz = 1024;
    int gps = 3, gp_memory_mib = 128;

    std::size_t bytes() const { return static_cast<std::size_t>(nx * ny * nz) * 2; }
};

Plan wanted_plan() {
    Plan plan;
    if (const char* text = std::getenv("PXPL5_LARGE")) {
        std::istringstream(text) >> plan.nx >> plan.ny >> plan.nz >> plan.gps >> plan.gp_memory_mib;
    }
    return plan;
}

/// Voxels of value 1; all others are 0. At isovalue 0.5, the surface runs half a voxel outside.
struct Box {
    std::array<std::int64_t, 3> first, size;

    /// Sum over the three pairs of axes.
    std::int64_t faces(std::int64_t less) const {
        const auto [a, b, c] = std::array{size[0] - less, size[1] - less, size[2] - less};
        return a * b + b * c + c * a;
    }
    std::int64_t lengths() const { return size[0] + size[1] + size[2] - 3; }
    /// A cell has 2 triangles at a face and at an edge, and 1 at a corner.
    std::int64_t triangles() const { return 4 * faces(1) + 8 * lengths() + 8; }
    std::int64_t vertices() const { return 2 * faces(0); }
    double area() const {
        return 2.0 * static_cast<double>(faces(1)) +
               4.0 * static_cast<double>(lengths()) * std::sqrt(0.5) + std::sqrt(3.0);
    }
    double volume() const {
        return static_cast<double>((size[0] - 1) * (size[1] - 1) * (size[2] - 1) + faces(1)) +
               static_cast<double>(lengths()) / 2 + 1.0 / 6;
    }
};

/// Along z they cross many slabs of all GPs.
const std::vector<Box> boxes = {{{10, 20, 3}, {60, 50, 120}},    {{200, 300, 100}, {40, 70, 90}},
                                {{400, 5, 300}, {100, 90, 31}},  {{1, 1, 400}, {2, 2, 500}},
                                {{300, 300, 700}, {33, 44, 55}}, {{100, 450, 900}, {80, 60, 120}}};

/// Writes the values of the boxes; the rest of the file has no blocks on the disk.
void write_volume(const fs::path& path, const Plan& plan) {
    const std::string head = fmt::format(
        "NRRD0005\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
        "endian: little\nencoding: raw\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
        "space origin: (0,0,0)\n\n",
        plan.nx, plan.ny, plan.nz);
    std::ofstream(path, std::ios::binary) << head;
    fs::resize_file(path, head.size() + plan.bytes());
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    for (const Box& box : boxes) {
        const std::vector<std::int16_t> row(static_cast<std::size_t>(box.size[0]), inside);
        for (std::int64_t z = box.first[2]; z < box.first[2] + box.size[2]; ++z) {
            for (std::int64_t y = box.first[1]; y < box.first[1] + box.size[1]; ++y) {
                file.seekp(static_cast<std::streamoff>(head.size()) +
                           2 * ((z * plan.ny + y) * plan.nx + box.first[0]));
                file.write(reinterpret_cast<const char*>(row.data()),
                           static_cast<std::streamsize>(row.size() * 2));
            }
        }
    }
    REQUIRE(file.good());
}

/// A slice has the voxels of all boxes that it cuts, and no others.
void check_slice(Session& session, int axis, std::int64_t index) {
    CAPTURE(axis);
    CAPTURE(index);
    std::int64_t wanted = 0;
    for (const Box& box : boxes) {
        const auto a = static_cast<std::size_t>(axis);
        if (index >= box.first[a] && index < box.first[a] + box.size[a]) {
            wanted += box.size[0] * box.size[1] * box.size[2] / box.size[a];
        }
    }
    const std::vector<double> values =
        numbers_of(session.voxels.slice(axis, static_cast<int>(index)));
    CHECK(std::ranges::count(values, double{inside}) == wanted);
    CHECK(std::ranges::count(values, 0.0) == static_cast<std::int64_t>(values.size()) - wanted);
}

/// The most memory that a process has used so far.
std::int64_t peak_mib(int pid) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    for (std::string word; status >> word;) {
        if (word == "VmHWM:") {
            std::int64_t kib = 0;
            status >> kib;
            return kib >> 10;
        }
    }
    return -1;
}

}  // namespace

TEST_CASE("a volume larger than the memory of all nodes gives the surface that arithmetic gives") {
    std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    const fs::path folder = pattern;
    const Plan plan = wanted_plan();
    write_volume(folder / "boxes.nrrd", plan);
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base = folder / "run";
    Topology topology;
    topology.gp.count = plan.gps;
    topology.gp_memory_mib = plan.gp_memory_mib;
    topology.renderer.count = 1;
    topology.frame_buffer.count = 1;
    {
        const std::int64_t all_bytes = std::int64_t{plan.gps} * plan.gp_memory_mib << 20;
        REQUIRE(all_bytes < static_cast<std::int64_t>(plan.bytes()));
        Machine machine(topology, options);
        Session session(machine);
        ImportOptions load;
        load.read = ReadBy::gps;
        const LoadReport loaded = session.volumes.load(folder / "boxes.nrrd", load);
        CHECK(loaded.memory_bytes < all_bytes);
        MESSAGE("read in " << loaded.read_ms << " ms, then " << loaded.distribute_ms
                           << " ms; GPs use " << (loaded.memory_bytes >> 20) << " MiB");
        CHECK(session.volumes.volume().reduction >= 2);
        session.surfaces.set("boxes", 0.5, CaseRule::watertight, {200, 200, 200});
        const Certificate proof =
            certify(session.meshes.fetch("boxes", true), session.meshes.grid());
        std::int64_t triangles = 0, vertices = 0;
        double area = 0, volume = 0;
        for (const Box& box : boxes) {
            triangles += box.triangles();
            vertices += box.vertices();
            area += box.area();
            volume += box.volume();
        }
        CHECK(proof.triangles == triangles);
        CHECK(proof.vertices == vertices);
        CHECK(proof.components == static_cast<std::int64_t>(boxes.size()));
        CHECK(proof.border_edges == 0);
        CHECK(proof.holes == 0);
        CHECK(proof.area_mm2 == doctest::Approx(area).epsilon(1e-6));
        CHECK(proof.volume_mm3 == doctest::Approx(volume).epsilon(1e-6));
        CHECK(session.frames.draw().rgba.size() > 1000);
        for (const Box& box : boxes) {  // From compressed slices, whole ones and those of all GPs.
            for (const int axis : {0, 1, 2}) {
                check_slice(session, axis, box.first[static_cast<std::size_t>(axis)]);
            }
        }
        check_slice(session, 2, plan.nz - 1);
        for (const Machine::Process& process : machine.processes()) {
            CAPTURE(process.name);
            const std::int64_t peak = peak_mib(process.pid);
            MESSAGE(process.name << ": " << peak << " MiB");
            CHECK(peak > 0);
            const bool is_gp = process.name.starts_with("gp-");
            CHECK(peak < (is_gp ? plan.gp_memory_mib + gp_program_mib : host_mib));
        }
        machine.shutdown();
    }
    fs::remove_all(folder);
}
