// Real volumes: triangle counts beside those of VTK 9.1's vtkFlyingEdges3D (shared/data/README).
#include <doctest/doctest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Certificate;
using pxpl5::test::certify;
using pxpl5::test::extract_all;
using pxpl5::test::Volume;

namespace {

struct Known {
    std::string file;
    pxpl5::test::Size size;
    Scalar type;
    double isovalue;
    std::size_t vtk_triangles;
};

const Known known[] = {
    {"ct/knee_128x128x56.nrrd", {128, 128, 56}, Scalar::int16, -519.5, 42416},
    {"ct/knee_128x128x56.nrrd", {128, 128, 56}, Scalar::int16, 76.5, 111436},
    {"ct/knee_128x128x56.nrrd", {128, 128, 56}, Scalar::int16, 180.5, 49908},
    {"ct/pelvis_128x128x56.nrrd", {128, 128, 56}, Scalar::int16, 300.5, 79104},
    {"mr/head_96x96x109.mha", {96, 96, 109}, Scalar::int16, 70.5, 269544},
    {"mr/head_unc_128x128x84.raw", {128, 128, 84}, Scalar::uint8, 25.5, 191256},
    {"mr/head_unc_128x128x84.raw", {128, 128, 84}, Scalar::uint8, 60.5, 263296},
    {"us/spine_phantom_128x64x96.nrrd", {128, 64, 96}, Scalar::uint8, 13.5, 70232},
    {"us/spine_phantom_128x64x96.nrrd", {128, 64, 96}, Scalar::uint8, 120.5, 50080},
};

std::filesystem::path data_folder() {
    return std::filesystem::path(PXPL5_SOURCE_DIR) / ".." / "shared" / "data";
}

/// Inflates gzip or zlib data; returns `size_bytes` bytes, or fewer if there are not as many.
std::vector<std::byte> inflated(std::string_view packed, std::size_t size_bytes) {
    std::vector<std::byte> out(size_bytes);
    z_stream stream{};
    REQUIRE(inflateInit2(&stream, 15 + 32) == Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(size_bytes);
    inflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    inflateEnd(&stream);
    return out;
}

/// The voxels after a file's text header.
std::vector<std::byte> read_voxels(const Known& k, std::size_t size_bytes) {
    std::ifstream file(data_folder() / k.file, std::ios::binary);
    REQUIRE_MESSAGE(file, k.file);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::size_t start = 0;
    if (text.starts_with("NRRD")) start = text.find("\n\n") + 2;
    if (text.starts_with("ObjectType")) start = text.find("LOCAL\n") + 6;
    const std::string_view data = std::string_view(text).substr(start);
    if (data.size() < size_bytes) return inflated(data, size_bytes);
    const auto bytes = std::as_bytes(std::span(data)).first(size_bytes);
    return {bytes.begin(), bytes.end()};
}

Volume read(const Known& k) {
    Volume volume;
    volume.shape = {k.size.nx, k.size.ny, k.size.nz, k.type, glm::dmat4(1.0), 0, 0};
    const std::size_t bytes =
        volume.shape.slice_voxels() * static_cast<std::size_t>(k.size.nz) * size_bytes(k.type);
    volume.values = read_voxels(k, bytes);
    REQUIRE(volume.values.size() == bytes);
    with_scalar(k.type, [&]<class T>(T) {
        const std::span values(typed<T>(volume.values), bytes / sizeof(T));
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        volume.shape.minimum = *low;
        volume.shape.maximum = *high;
    });
    return volume;
}

bool data_is_there() {
    const bool there = std::filesystem::exists(data_folder());
    if (!there) MESSAGE("skipped: no folder ", data_folder().string());
    return there;
}

}  // namespace

TEST_SUITE("gp/vtk_counts") {
    TEST_CASE("watertight has exactly VTK's triangles") {
        if (!data_is_there()) return;
        for (const Known& k : known) {
            const Volume volume = read(k);
            const auto meshes = extract_all(volume, k.isovalue, CaseRule::watertight);
            const Certificate certificate = certify(meshes, volume.shape);
            INFO(k.file, " at ", k.isovalue);
            CHECK(certificate.triangles == k.vtk_triangles);
            CHECK_MESSAGE(certificate.good(), certificate);
        }
    }

    TEST_CASE("asymptotic differs from VTK by no more than its ambiguous cells can") {
        if (!data_is_there()) return;
        for (const Known& k : known) {
            const Volume volume = read(k);
            const auto meshes = extract_all(volume, k.isovalue, CaseRule::asymptotic);
            const auto apart = extract_all(volume, k.isovalue, CaseRule::watertight);
            const Certificate certificate = certify(meshes, volume.shape);
            std::size_t ambiguous = 0;
            for (const SlabMesh& mesh : meshes) ambiguous += mesh.counts.cells_ambiguous;
            const double difference = double(certificate.triangles) - double(k.vtk_triangles);
            MESSAGE(k.file, " at ", k.isovalue, ": ", certificate.triangles, " triangles, VTK ",
                    k.vtk_triangles, " (", 100 * difference / double(k.vtk_triangles), " %), ",
                    ambiguous, " ambiguous cells");
            // A cell with f ambiguous faces has 2 f triangles more or less, 2 more by a center
            // vertex; nearly all ambiguous cells have one ambiguous face.
            CHECK(std::abs(difference) <= 2 * double(ambiguous));
            CHECK(std::abs(difference) <= 0.02 * double(k.vtk_triangles));
            CHECK_MESSAGE(certificate.good(), certificate);
            for (std::size_t i = 0; i < meshes.size(); ++i)
                if (meshes[i].counts.cells_ambiguous == 0)
                    CHECK(meshes[i].counts.triangles == apart[i].counts.triangles);
        }
    }
}
