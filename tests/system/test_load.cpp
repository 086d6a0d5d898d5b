// Loading: in sets of any size, with progress, and given up in the middle; exports given up, too.
#include <doctest/doctest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/io/sandbox/sanitizer.hpp"
#include "host/machine/machine.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/session.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

constexpr Color gray{160, 160, 160};
constexpr double isovalue = 118.5;

Topology machine_of(int gps, int gp_memory_mib = 256) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = gp_memory_mib;
    topology.seed = 5;
    return topology;
}

/// A machine of real processes, and a file of 40 slices of 1 MiB, four to a message.
struct Bench {
    Bench() {
        std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        folder = pattern;
        file = folder / "waves.nrrd";
        write([](int x, int y, int z) { return (x * y + 64 * z) >> 9; });
        options.binaries = PXPL5_BIN_DIR;
        options.run_base = folder / "run";
    }
    ~Bench() { fs::remove_all(folder); }

    /// Writes the file with the low byte of each value.
    void write(const std::function<int(int x, int y, int z)>& value) const {
        std::ofstream out(file, std::ios::binary);
        out << "NRRD0005\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\n"
            << "sizes: " << nx << ' ' << nx << ' ' << nz << "\nencoding: raw\n"
            << "space directions: (1,0,0) (0,1,0) (0,0,7)\nspace origin: (0,0,0)\n\n";
        std::string slice(std::size_t{nx} * nx, '\0');
        for (int z = 0; z < nz; ++z) {
            for (int y = 0; y < nx; ++y) {
                for (int x = 0; x < nx; ++x) {
                    slice[static_cast<std::size_t>(y) * nx + static_cast<std::size_t>(x)] =
                        static_cast<char>(value(x, y, z) & 0xFF);
                }
            }
            out << slice;
        }
    }

    static constexpr int nx = 1024, nz = 40;
    fs::path folder, file;
    MachineOptions options;
};

struct Result {
    std::uint64_t mesh = 0, volume = 0;
    std::int64_t triangles = 0;
    double area_mm2 = 0, volume_mm3 = 0;
    std::vector<std::uint32_t> picture;
    bool operator==(const Result&) const = default;
};

Result result_of(Session& session) {
    session.scene.size = {140, 130};
    const SurfaceReport report = session.surfaces.set("s", isovalue, CaseRule::watertight, gray);
    return {session.meshes.digest("s"), session.volumes.volume().digest,
            report.triangles,           report.area_mm2,
            report.volume_mm3,          session.frames.draw().rgba.copy()};
}

/// The error that `act` ends with, which is of type E.
template <typename E>
std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const E& error) {
        return error.what();
    }
    return "none";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("meshes, measures and pictures are the same in sets of any size, for any machine") {
    std::optional<Result> first;
    for (const int gps : {1, 2, 3, 7}) {
        for (const int slabs_per_set : {0, 1, 2, 3, 5, 100}) {
            test::SimulatedMachine machine(machine_of(gps));
            Session session(machine);
            session.load_settings.slabs_per_set = slabs_per_set;
            session.volumes.load("phantom:letters");
            CHECK(session.volumes.volume().slabs_per_set == std::max(slabs_per_set, 1));
            const Result result = result_of(session);
            CHECK(result.triangles > 1000);
            first = first ? first : result;
            CHECK(result == *first);
        }
    }
}

TEST_CASE("smooth gradients change normals alone, by the same bits in any machine") {
    ImportOptions smooth;
    smooth.gradient = GradientKernel::smooth;
    std::optional<Result> first;
    for (const int gps : {1, 3}) {
        for (const int slabs_per_set : {1, 2, 100}) {
            test::SimulatedMachine machine(machine_of(gps));
            Session session(machine);
            session.load_settings.slabs_per_set = slabs_per_set;
            session.volumes.load("phantom:letters");
            const Result central = result_of(session);
            session.volumes.load("phantom:letters", smooth);
            const Result result = result_of(session);
            first = first ? first : result;
            CHECK(result == *first);
            CHECK(result.volume == central.volume);
            CHECK(result.triangles == central.triangles);
            CHECK(result.area_mm2 == central.area_mm2);
            CHECK(result.volume_mm3 == central.volume_mm3);
            CHECK(result.picture != central.picture);
            session.volumes.give_again();
            CHECK(result_of(session) == result);
        }
    }
}

TEST_CASE("larger sets need less memory, as GPs hold no gradients and share fewer slices") {
    std::vector<std::int64_t> bytes;
    for (const int slabs_per_set : {1, 8}) {
        test::SimulatedMachine machine(machine_of(2));
        Session session(machine);
        session.load_settings.slabs_per_set = slabs_per_set;
        bytes.push_back(session.volumes.load("phantom:letters").memory_bytes);
    }
    CHECK(bytes[1] * 4 < bytes[0]);
}

TEST_CASE("slices go on to the GPs while they are read, and progress is told in order") {
    Bench bench;
    Machine machine(machine_of(2), bench.options);
    Session session(machine);
    std::vector<LoadProgress> told;
    session.load_settings.progress = [&](const LoadProgress& now) { told.push_back(now); };
    session.volumes.load(bench.file);
    const Volume& volume = session.volumes.volume();
    CHECK(volume.nz == Bench::nz);
    CHECK(volume.slabs_per_set == slabs_per_set_for(volume, 2));
    CHECK(volume.slabs_per_set > 1);
    CHECK(volume.source == bench.file);
    REQUIRE(told.size() > 4);
    CHECK(told.front() == LoadProgress{LoadProgress::Phase::reading, 0, 0});
    CHECK(told.back().phase == LoadProgress::Phase::distributing);
    CHECK(told.back().done == told.back().total);
    for (std::size_t i = 2; i < told.size(); ++i) {
        CHECK(told[i].phase >= told[i - 1].phase);
        CHECK((told[i].phase != told[i - 1].phase || told[i].done > told[i - 1].done));
    }
    const Result whole = result_of(session);

    session.load_settings.slabs_per_set = 3;
    session.volumes.load(bench.file);
    CHECK(result_of(session) == whole);
    machine.shutdown();
}

TEST_CASE("Ctrl-C while a volume is read or handed out gives up the volume alone") {
    Bench bench;
    Machine machine(machine_of(2), bench.options);
    Session session(machine);
    session.volumes.load("phantom:sphere");
    const auto cancel_at = [&](const std::function<bool(const LoadProgress&)>& here) {
        bool pressed = false;
        session.load_settings.progress = [&](const LoadProgress& now) {
            if (!pressed && here(now)) {
                pressed = true;
                std::raise(SIGINT);
            }
        };
        const std::string error = error_of<Canceled>([&] { session.volumes.load(bench.file); });
        session.load_settings.progress = nullptr;
        CHECK(pressed);
        return error;
    };
    // Before anything of it has come, what was loaded stays.
    CHECK(cancel_at([](const LoadProgress& now) { return now.total == 0; }) == "canceled");
    CHECK(session.volumes.volume().name == "phantom:sphere");
    CHECK(session.surfaces.set("s", 100, CaseRule::watertight, gray).triangles > 0);

    using Phase = LoadProgress::Phase;
    const std::vector<std::function<bool(const LoadProgress&)>> later = {
        [](const LoadProgress& now) { return now.phase == Phase::reading && now.done > 0; },
        [](const LoadProgress& now) { return now.phase == Phase::reading && now.done > 20; },
        [](const LoadProgress& now) { return now.phase == Phase::distributing; }};
    for (const auto& here : later) {
        CHECK(cancel_at(here) == "canceled");
        CHECK_FALSE(session.volumes.has_volume());
        CHECK(has(error_of<RequestError>([&] { session.frames.draw(); }), "no volume is loaded"));
    }
    // The next load is as if nothing had been.
    const std::int64_t bytes = session.volumes.load(bench.file).memory_bytes;
    const Result after = result_of(session);
    CHECK(session.volumes.load(bench.file).memory_bytes == bytes);
    CHECK(result_of(session) == after);
    machine.shutdown();
}

TEST_CASE("a machine whose last load was given up ends in order") {
    Bench bench;
    Machine machine(machine_of(2), bench.options);
    Session session(machine);
    bool pressed = false;
    session.load_settings.progress = [&](const LoadProgress& now) {
        if (!pressed && now.phase == LoadProgress::Phase::reading && now.done > 0) {
            pressed = true;
            std::raise(SIGINT);
        }
    };
    CHECK(error_of<Canceled>([&] { session.volumes.load(bench.file); }) == "canceled");
    // The io process dies of SIGKILL meanwhile, which was the machine's own doing.
    CHECK(error_of<MachineError>([&] { machine.shutdown(); }) == "none");
}

TEST_CASE("a second Ctrl-C, and one outside of loading, ends the machine") {
    Bench bench;
    for (const bool outside : {false, true}) {
        Machine machine(machine_of(2), bench.options);
        Session session(machine);
        session.load_settings.progress = [&](const LoadProgress& now) {
            for (int presses = now.total == 0 && !outside ? 2 : 0; presses > 0; --presses) {
                std::raise(SIGINT);
            }
        };
        if (outside) {
            session.volumes.load(bench.file);
            std::raise(SIGINT);
        } else {
            CHECK(error_of<Canceled>([&] { session.volumes.load(bench.file); }) == "canceled");
        }
        CHECK(has(error_of<MachineError>([&] { session.volumes.load("phantom:sphere"); }),
                  "interrupted by SIGINT"));  // The press came before, and is not this load's.
    }
}

TEST_CASE("a volume that no GP can hold is refused before all of it is read, and leaves nothing") {
    Bench bench;
    std::minstd_rand noise(1);  // Compression does not make room for it.
    bench.write([&noise](int, int, int) { return static_cast<int>(noise() >> 8); });
    Machine machine(machine_of(1, 32), bench.options);
    Session session(machine);
    session.volumes.load("phantom:sphere");
    const std::string error = error_of<RequestError>([&] { session.volumes.load(bench.file); });
    CHECK_MESSAGE(has(error, "bytes of local memory"), error);
    CHECK_MESSAGE(has(error, "GPs with 33554432 bytes each would do"), error);
    CHECK_FALSE(session.volumes.has_volume());
    session.volumes.load("phantom:sphere");
    CHECK(session.surfaces.set("s", 100, CaseRule::watertight, gray).triangles > 0);
    machine.shutdown();
}

TEST_CASE("an archive is read under the limits of the io process, and fails alone") {
    if (host::io::has_sanitizer) {
        MESSAGE("SKIPPED: builds with a sanitizer have no limit of memory");
        return;
    }
    Bench bench;
    bench.options.io_memory_mib = 1024;
    const fs::path small = bench.folder / "small.phigs", large = bench.folder / "large.phigs";
    std::ofstream(small) << "structure s posted { sphere 0 0 0 1; }";
    std::ofstream out(large);  // 1.9 million triangles.
    out << "structure s posted { ";
    for (int i = 0; i < 1900; ++i) {
        out << "execute t; ";
    }
    out << "}\nstructure t { ";
    for (int i = 0; i < 1000; ++i) {
        out << "polygon 3 { 0 0 0; 1 0 0; 0 1 " << i << "; }; ";
    }
    out << "}\n";
    out.close();
    Machine machine(machine_of(2), bench.options);
    Session session(machine);
    session.volumes.load(small.string());
    CHECK(error_of<RequestError>([&] { session.volumes.load(large.string()); }) ==
          large.string() + ": does not fit in the memory that the io process may use");
    REQUIRE(session.volumes.archive() != nullptr);
    CHECK(session.volumes.archive()->file == small.string());
    CHECK(session.volumes.read_archive(small.string()).spheres == 1);
    machine.shutdown();
}

TEST_CASE("an export that is canceled while it writes leaves no file, and the next one is whole") {
    const Bench bench;
    Machine machine(machine_of(2), bench.options);
    Session session(machine);
    session.volumes.load(bench.file.string());
    session.surfaces.set("s", isovalue, CaseRule::watertight, gray);
    const fs::path out = bench.folder / "out";
    fs::create_directory(out);
    // It stays readable, so that the machine asks until the file of the io process is there.
    const int asked = eventfd(1, EFD_CLOEXEC);
    bool has_begun = false;
    machine.watch(asked, [&] { return has_begun = has_begun || !fs::is_empty(out); });
    const fs::path path = out / "s.stl";
    CHECK(error_of<Canceled>([&] { session.exports.mesh(path, {}); }) == "canceled");
    CHECK(has_begun);
    CHECK(fs::is_empty(out));
    machine.watch(-1, {});
    const MeshExportReport report = session.exports.mesh(path, {});
    CHECK(fs::file_size(path) == 84 + 50 * static_cast<std::uintmax_t>(report.triangles));
    close(asked);
}
