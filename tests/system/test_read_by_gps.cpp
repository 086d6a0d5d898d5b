// Volumes that GPs read from a file themselves: the same bits as the values that the host sends.
#include <doctest/doctest.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/machine.hpp"
#include "host/scene/pick.hpp"
#include "host/scene/slice.hpp"
#include "host/session/session.hpp"
#include "host/surface/certificate.hpp"
#include "host/volume/identity.hpp"
#include "host/volume/reduced.hpp"
#include "tests/host/io/dicom_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

constexpr int nx = 40, ny = 36, nz = 30;
constexpr std::size_t voxels = std::size_t{nx} * ny * nz;
constexpr Color gray{160, 160, 160};

/// A ball with waves, about -900 to 900, and its surface at 100.5.
double density(int x, int y, int z) {
    const double dx = x - 19.3, dy = y - 17.1, dz = z - 14.6;
    return 900 - 90 * std::sqrt(dx * dx + dy * dy + dz * dz) + 40 * std::sin(x * 0.9) +
           25 * std::cos(y * 1.3 + z * 0.7);
}

template <class T>
std::string bytes_of(bool big_endian, double slope = 1, double intercept = 0) {
    std::string bytes;
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) {
                bytes += test::bytes_of(static_cast<T>((density(x, y, z) - intercept) / slope),
                                        big_endian);
            }
        }
    }
    return bytes;
}

std::string nrrd(const std::string& type, const std::string& endian, const std::string& more) {
    return "NRRD0005\ntype: " + type +
           "\ndimension: 3\nspace: RAS\nsizes: 40 36 30\nendian: " + endian +
           "\nencoding: raw\nspace directions: (1,0,0) (0,1.5,0) (0,0,2)\n" +
           "space origin: (3,-4,5)\n" + more;
}

std::string nifti(float slope, float intercept) {
    return test::NiftiHeader()
        .put_dims({3, nx, ny, nz, 1, 1, 1, 1})
        .put(112, slope)
        .put(116, intercept)
        .put_sform({{{1, 0, 0, 3}, {0, 1.5F, 0, -4}, {0, 0, 2, 5}}})
        .bytes();
}

/// Slice z of a series, 1.5 mm high pixels, 2 mm apart, each with a scale of its own.
test::DicomSet slice_at(int z) {
    const int intercept = z % 3 - 1;
    std::string values;
    for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
            values +=
                test::bytes_of(static_cast<std::int16_t>(std::floor(density(x, y, z)) - intercept));
        }
    }
    test::DicomSet set = test::dicom_image(nx, ny, values);
    set.text(0x28, 0x1052, "DS", std::to_string(intercept)).text(0x28, 0x1053, "DS", "1");
    return test::dicom_place(set, {3, -4, 5 + 2.0 * z}, {1, 0, 0}, {0, 1, 0}, 1, 1.5);
}

/// Files of one shape in all layouts.
struct Bench {
    Bench() {
        std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        folder = pattern;
        write("attached.nrrd", nrrd("short", "little", "\n") + bytes_of<std::int16_t>(false));
        write("detached.nhdr", nrrd("float", "big", "byte skip: 9\ndata file: values.bin\n\n"));
        write("values.bin", "a header " + bytes_of<float>(true));
        write("image.mhd",
              "ObjectType = Image\nNDims = 3\nDimSize = 40 36 30\nElementType = MET_INT\n"
              "ElementSpacing = 1 1.5 2\nElementByteOrderMSB = False\nHeaderSize = -1\n"
              "ElementDataFile = image.raw\n");
        write("image.raw", "??" + bytes_of<std::int32_t>(false));
        write("local.mha",
              "ObjectType = Image\nNDims = 3\nDimSize = 40 36 30\nElementType = MET_DOUBLE\n"
              "ElementSpacing = 1 1.5 2\nElementDataFile = LOCAL\n" +
                  bytes_of<double>(false));
        write("scaled.nii", nifti(0.5F, -3) + bytes_of<std::int16_t>(false, 0.5, -3));
        fs::create_directory(folder / "series");
        for (int z = 0; z < nz; ++z) {  // Names run against the places.
            write(fmt::format("series/{:02}.dcm", nz - z), slice_at(z).file());
        }
        options.binaries = PXPL5_BIN_DIR;
        options.run_base = folder / "run";
    }
    ~Bench() { fs::remove_all(folder); }

    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder / name, std::ios::binary) << bytes;
    }

    fs::path folder;
    MachineOptions options;
};

const std::vector<std::string> files = {"attached.nrrd", "detached.nhdr", "image.mhd",
                                        "local.mha",     "scaled.nii",    "series"};

Topology machine_of(int gps, int renderers, Transport transport = Transport::ipc) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.ring.transport = transport;
    return topology;
}

ImportOptions by(ReadBy read, std::uint64_t reduced_bytes = 8192) {
    ImportOptions options;
    options.read = read;
    options.reduced_bytes = reduced_bytes;
    return options;
}

/// All that does not depend on who reads.
struct Result {
    std::string identity;
    Scalar type{};
    double minimum = 0, maximum = 0;
    std::uint64_t mesh = 0;
    std::int64_t triangles = 0;
    std::string certificate;
    std::vector<std::uint32_t> picture;
    bool operator==(const Result&) const = default;
};

Result result_of(Session& session) {
    session.scene.size = {180, 150};
    const Volume& volume = session.volumes.volume();
    const SurfaceReport report = session.surfaces.set("s", 100.5, CaseRule::watertight, gray);
    const Certificate proof = certify(session.meshes.fetch("s", true), session.meshes.grid());
    return {identity_of(volume),
            volume.type,
            volume.minimum,
            volume.maximum,
            session.meshes.digest("s"),
            report.triangles,
            fmt::format("{} {} {} {} {} {} {}", proof.vertices, proof.edges, proof.components,
                        proof.border_edges, proof.holes, proof.area_mm2, proof.volume_mm3),
            session.frames.draw().rgba.copy()};
}

std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const RequestError& error) {
        return error.what();
    }
    return "none";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("meshes, certificates and pictures are the same whoever reads, for any machine") {
    const Bench bench;
    std::vector<Result> first;
    for (const Transport transport : {Transport::ipc, Transport::tcp}) {
        for (const auto& [gps, renderers] : {std::pair{1, 1}, {3, 2}, {8, 4}}) {
            Machine machine(machine_of(gps, renderers, transport), bench.options);
            Session session(machine);
            for (std::size_t i = 0; i < files.size(); ++i) {
                for (const ReadBy read : {ReadBy::host, ReadBy::gps}) {
                    CAPTURE(gps);
                    CAPTURE(files[i]);
                    session.volumes.load(bench.folder / files[i], by(read));
                    CHECK(session.volumes.volume().stored.has_value() == (read == ReadBy::gps));
                    const Result result = result_of(session);
                    CHECK(result.triangles > 1000);
                    if (first.size() == i) {
                        first.push_back(result);
                    }
                    CHECK(result == first[i]);
                }
            }
            machine.shutdown();
        }
    }
}

TEST_CASE("GPs without slabs read nothing") {
    const Bench bench;
    Machine machine(machine_of(8, 1), bench.options);
    Session session(machine);
    for (const int slices : {2, 3}) {
        CAPTURE(slices);
        std::string bytes;
        for (int i = 0; i < 4 * 4 * slices; ++i) {
            bytes += static_cast<char>(i / 16 == 0 ? 0 : 200);
        }
        bench.write("thin.nrrd", fmt::format("NRRD0005\ntype: uchar\ndimension: 3\nspace: RAS\n"
                                             "sizes: 4 4 {}\nencoding: raw\n"
                                             "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n{}",
                                             slices, bytes));
        session.volumes.load(bench.folder / "thin.nrrd", by(ReadBy::host));
        const Result sent = result_of(session);
        session.volumes.load(bench.folder / "thin.nrrd", by(ReadBy::gps));
        CHECK(session.volumes.volume().stored);
        CHECK(result_of(session) == sent);
        CHECK(sent.triangles > 0);
    }
    machine.shutdown();
}

TEST_CASE("the host sends no voxels, and keeps every n-th one") {
    const Bench bench;
    Machine machine(machine_of(2, 1), bench.options);
    Session session(machine);
    session.volumes.load(bench.folder / "attached.nrrd", by(ReadBy::host));
    const Volume whole = session.volumes.volume();
    const auto sent = [&] {
        std::uint64_t bytes = 0;
        for (const bus::SentCount& each : machine.traffic().sent) {
            bytes += each.bytes;
        }
        return bytes;
    };
    const std::uint64_t before = sent();
    session.volumes.load(bench.folder / "attached.nrrd", by(ReadBy::gps));
    CHECK(sent() - before < 10'000);
    const Volume& volume = session.volumes.volume();
    REQUIRE(volume.reduced);
    CHECK(volume.values.empty());
    CHECK(volume.reduction == 3);
    const Volume& copy = *volume.reduced;
    CHECK(copy.values.size() <= 8192);
    for (int z = 0; z < copy.nz; ++z) {
        for (int y = 0; y < copy.ny; ++y) {
            for (int x = 0; x < copy.nx; ++x) {
                CHECK(voxel_value(copy, x, y, z) == voxel_value(whole, 3 * x, 3 * y, 3 * z));
            }
        }
    }
    CHECK(copy.voxel_to_patient * glm::dvec4(2, 3, 4, 1) ==
          volume.voxel_to_patient * glm::dvec4(6, 9, 12, 1));
    CHECK(error_of([&] { require_all_voxels(volume, "a question"); }) ==
          "a question needs all voxels of attached, but the host keeps one in 3 along each axis, "
          "because the GPs read the file. Load with read=host, or a part with crop=");
    CHECK(has(volume.findings.back().text, "reduced by 3"));

    session.scene.size = {180, 150};
    session.surfaces.set("s", 100.5, CaseRule::watertight, gray);
    session.frames.draw();
    const auto picked = session.frames.pick(90, 75, "");
    REQUIRE(picked);
    CHECK(!picked->pick.value);
    CHECK(!picked->pick.value_between);

    session.volumes.load(bench.folder / "attached.nrrd", by(ReadBy::gps, 2 * voxels));
    CHECK(session.volumes.volume().reduction == 1);
    CHECK(session.volumes.volume().values == whole.values);
}

TEST_CASE("the GPs read large values of their own accord if their file has them as they are") {
    const Bench bench;
    Machine machine(machine_of(1, 1), bench.options);
    Session session(machine);
    ImportOptions options = by(ReadBy::automatic);
    options.host_bytes = 2 * voxels;
    session.volumes.load(bench.folder / "attached.nrrd", options);
    CHECK(!session.volumes.volume().stored);
    --options.host_bytes;
    session.volumes.load(bench.folder / "attached.nrrd", options);
    CHECK(session.volumes.volume().stored);
    options.crop_first = {0, 0, 0};
    options.crop_size = {10, 10, 10};
    session.volumes.load(bench.folder / "attached.nrrd", options);
    CHECK(!session.volumes.volume().stored);

    options.read = ReadBy::gps;
    CHECK(has(error_of([&] { session.volumes.load(bench.folder / "attached.nrrd", options); }),
              "attached.nrrd: GPs cannot read the values from this file: crop="));
    CHECK(has(error_of([&] { session.volumes.load("phantom:sphere", by(ReadBy::gps)); }),
              "a phantom has no file that GPs could read"));
    CHECK(has(error_of([&] { session.volumes.load(bench.folder / "series", options); }),
              "series: GPs cannot read the values from this folder: crop="));
}

TEST_CASE("GPs read the file again after a change of the machine, if it is still the same") {
    const Bench bench;
    Machine machine(machine_of(2, 1), bench.options);
    Session session(machine);
    const std::string file = bench.folder / "attached.nrrd";
    session.volumes.load(file, by(ReadBy::gps));
    const Result before = result_of(session);
    session.scale({1, 0});
    CHECK(session.conversation.gps().size() == 3);
    CHECK(result_of(session) == before);

    const auto time = fs::last_write_time(file);
    fs::last_write_time(file, time + std::chrono::seconds(7));
    CHECK(has(error_of([&] { session.scale({1, 0}); }), ". Load it again when it is complete"));
    CHECK(session.conversation.gps().size() == 3);
    CHECK(result_of(session) == before);

    const Scene scene = session.scene;
    machine.start_again({});
    const std::string error = error_of([&] { session.begin_again_or_drop(scene); });
    char name[256] = {};
    REQUIRE(gethostname(name, sizeof name - 1) == 0);
    CHECK(has(error, "gp-"));
    CHECK(has(error, std::string(" on ") + name + ": " + file +
                         ": the time of its last change in ns is "));
    CHECK(has(error,
              "when the host loaded the volume. All computers must see the same unchanged file"));
    CHECK(!session.volumes.has_volume());
    session.volumes.load(file, by(ReadBy::gps));
    CHECK(result_of(session) == before);
}

TEST_CASE("GPs read a series again, and name the file of it that has changed") {
    const Bench bench;
    Machine machine(machine_of(2, 1), bench.options);
    Session session(machine);
    const std::string folder = bench.folder / "series";
    session.volumes.load(folder, by(ReadBy::gps));
    CHECK(session.volumes.volume().stored.value().files.size() == nz);
    const Result before = result_of(session);
    session.scale({1, 0});
    CHECK(result_of(session) == before);
    std::ofstream(folder + "/17.dcm", std::ios::app) << "more";
    CHECK(has(error_of([&] {
                  session.scale({1, 0});
              }),
              folder + ": its data file " + folder + "/17.dcm has "));
    CHECK(result_of(session) == before);
}

TEST_CASE("slices and picked values are those of all voxels, for any machine") {
    const Bench bench;
    std::vector<Slice> exact;
    std::optional<Pick> picked;
    for (const Transport transport : {Transport::ipc, Transport::tcp}) {
        for (const int gps : {1, 3, 8}) {
            CAPTURE(gps);
            Machine machine(machine_of(gps, 1, transport), bench.options);
            Session session(machine);
            for (const ReadBy read : {ReadBy::host, ReadBy::gps}) {
                session.volumes.load(bench.folder / "scaled.nii", by(read));
                REQUIRE((session.volumes.volume().reduced != nullptr) == (read == ReadBy::gps));
                std::size_t at = 0;
                for (const auto& [axis, count] : {std::pair{0, nx}, {1, ny}, {2, nz}}) {
                    for (int i = 0; i < count; ++i) {
                        const Slice slice = session.voxels.slice(axis, i);
                        if (exact.size() == at) {
                            exact.push_back(slice);
                        }
                        CHECK(slice.values == exact[at].values);
                        CHECK(slice.frame.across.count == exact[at].frame.across.count);
                        CHECK(slice.frame.down.spacing_mm == exact[at].frame.down.spacing_mm);
                        ++at;
                    }
                }
                session.scene.size = {180, 150};
                session.surfaces.set("s", 100.5, CaseRule::watertight, gray);
                auto found = session.frames.pick(90, 75, "");
                REQUIRE(found);
                const std::uint64_t key = session.frames.key();
                session.voxels.add_values(found->pick);
                CHECK(session.frames.key() == key);
                picked = picked.value_or(found->pick);
                REQUIRE(found->pick.value);
                CHECK(found->pick.value == picked->value);
                CHECK(found->pick.value_between == picked->value_between);
            }
            machine.shutdown();
        }
    }
    CHECK(exact.front().values != exact[nx / 2].values);
    CHECK(picked->value_between.value() == doctest::Approx(100.5).epsilon(0.1));
}
