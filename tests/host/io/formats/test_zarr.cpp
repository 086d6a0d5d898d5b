// OME-Zarr images. The files in zarr/ were written by zarr-python 2.13.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "host/io/import.hpp"
#include "tests/file_bytes.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;

namespace {

const fs::path shipped = PXPL5_ZARR_FOLDER;

/// A copy of a shipped image, to be changed.
struct Copy {
    explicit Copy(const std::string& name) : root(folder.file("v.ome.zarr")) {
        fs::copy(shipped / name, root, fs::copy_options::recursive);
    }
    std::string text(const std::string& name) const { return file_bytes(root / name); }
    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(root / name, std::ios::binary) << bytes;
    }
    void change(const std::string& name, const std::string& from, const std::string& to) const {
        std::string bytes = text(name);
        const std::size_t at = bytes.find(from);
        REQUIRE(at != std::string::npos);
        write(name, bytes.replace(at, from.size(), to));
    }
    Volume read(std::uint32_t frame = 0) const {
        ImportRequest request;
        request.path = root.string();
        request.frame = frame;
        return import_volume(request);
    }
    /// The error, without the folder before it.
    std::string refusal() const {
        try {
            read();
            return "none";
        } catch (const ImportError& error) {
            const std::string text = error.what();
            return text.starts_with(root.string()) ? text.substr(root.string().size()) : text;
        }
    }

    TemporaryFolder folder;
    fs::path root;
};

std::string refusal_if(const std::string& name, const std::string& file, const std::string& from,
                       const std::string& to) {
    const Copy copy(name);
    copy.change(file, from, to);
    return copy.refusal();
}

bool has_finding(const Volume& volume, const std::string& text) {
    return std::ranges::any_of(volume.findings, [&](const Finding& finding) {
        return finding.text.find(text) != std::string::npos;
    });
}

void check_values(const Volume& volume, const std::vector<std::int16_t>& values) {
    REQUIRE(volume.type == Scalar::int16);
    REQUIRE(volume.values.size() == values.size() * 2);
    CHECK(std::memcmp(volume.values.data(), values.data(), volume.values.size()) == 0);
}

void check_place(const Volume& volume) {
    CHECK(glm::length(volume.voxel_to_patient[0] - glm::dvec4(0.5, 0, 0, 0)) < 1e-12);
    CHECK(glm::length(volume.voxel_to_patient[1] - glm::dvec4(0, 1.5, 0, 0)) < 1e-12);
    CHECK(glm::length(volume.voxel_to_patient[2] - glm::dvec4(0, 0, 2, 0)) < 1e-12);
    CHECK(glm::length(volume.voxel_to_patient[3] - glm::dvec4(10, -20, 30, 1)) < 1e-12);
}

}  // namespace

TEST_SUITE("host/io/zarr") {
    TEST_CASE("each compression, both byte orders, both orders of axes, and chunks at the ends") {
        for (const char* name : {"blosc", "zstd", "zlib", "plain"}) {
            CAPTURE(name);
            const Volume volume = import_volume((shipped / name).string() + ".zarr");
            CHECK(volume.name == name);
            CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{6, 5, 4});
            check_values(volume, ramp<std::int16_t>(120));
            check_place(volume);
            CHECK(has_finding(volume, "OME-Zarr states no patient space"));
        }
    }

    TEST_CASE("a level is read if it is the path, else the finest level") {
        const Volume coarse = import_volume(shipped / "blosc.zarr/1");
        CHECK(coarse.name == "blosc");
        CHECK(std::array{coarse.nx, coarse.ny, coarse.nz} == std::array{3, 3, 4});
        const std::vector<std::int16_t> fine = ramp<std::int16_t>(120);
        CHECK(coarse.voxel_to_patient[0].x == 1);
        CHECK(coarse.voxel_to_patient[1].y == 3);
        std::int16_t value = 0;
        std::memcpy(&value, coarse.values.data() + 2 * (9 + 3 + 2), 2);  // x 2, y 1, z 1.
        CHECK(value == fine[30 + 2 * 6 + 4]);
        CHECK(has_finding(coarse, "level 2 of 2 (1)"));
        CHECK(has_finding(import_volume(shipped / "blosc.zarr"), "level 1 of 2 (0)"));
        CHECK(import_volume(shipped / "blosc.zarr/").name == "blosc");
        const Copy copy("blosc.zarr");
        fs::copy(copy.root / "1", copy.root / "2", fs::copy_options::recursive);
        CHECK_THROWS_WITH_AS(import_volume(copy.root / "2"),
                             doctest::Contains("is none of the 2 levels that"), ImportError);
    }

    TEST_CASE("the volumes of a time series, with their distance in time") {
        const Copy copy("series.zarr");
        const std::vector<std::int16_t> first = ramp<std::int16_t>(120);
        check_values(copy.read(), first);
        const Volume second = copy.read(2);
        std::vector<std::int16_t> turned;
        for (int z = 3; z >= 0; --z) {
            turned.insert(turned.end(), first.begin() + 30 * z, first.begin() + 30 * (z + 1));
        }
        check_values(second, turned);
        CHECK(second.frame == 2);
        CHECK(second.frames == 2);
        CHECK(second.frame_ms == 100);
        CHECK_THROWS_WITH_AS(copy.read(3), doctest::Contains("frame is 3"), ImportError);
    }

    TEST_CASE("a chunk without a file has the fill value, and is reported") {
        const Copy copy("blosc.zarr");
        fs::remove(copy.root / "0/0/0/1");  // x 4 to 5, y 0 to 1, z 0 to 2.
        copy.change("0/.zarray", "\"fill_value\": 0", "\"fill_value\": -7");
        std::vector<std::int16_t> values = ramp<std::int16_t>(120);
        for (const std::size_t at : {4, 5, 10, 11}) {
            for (const std::size_t z : {0, 1, 2}) {
                values[z * 30 + at] = -7;
            }
        }
        const Volume volume = copy.read();
        check_values(volume, values);
        CHECK(has_finding(volume, "1 of 12 chunks have no file: their voxels are -7"));
        for (const char* folder : {"0/0", "0/1"}) {
            fs::remove_all(copy.root / folder);
        }
        CHECK(copy.refusal() == ": none of its 12 chunks has a file, for example " +
                                    (copy.root / "0/0/0/0").string());
    }

    TEST_CASE("damaged, cut, longer and foreign chunks are refused, with the file") {
        for (const char* name : {"blosc.zarr", "zstd.zarr", "zlib.zarr", "plain.zarr"}) {
            CAPTURE(name);
            const Copy copy(name);
            const std::string file = std::string(name) == "zstd.zarr" ? "0/0.0.0" : "0/0/0/0";
            const std::string bytes = copy.text(file);
            copy.write(file, bytes.substr(0, bytes.size() / 2));
            CHECK(copy.refusal().starts_with("/" + file + ": "));
            copy.write(file, std::string(bytes.size(), '\x5a') + "more");
            CHECK(copy.refusal().starts_with("/" + file + ": "));
            copy.write(file, std::string(std::size_t{1} << 17, 'x'));
            CHECK(copy.refusal().starts_with("/" + file + ": has 131072 bytes, a chunk of "));
            fs::remove(copy.root / file);
            fs::create_symlink("/etc/passwd", copy.root / file);
            CHECK(copy.refusal().find("lies outside of the header's folder") != std::string::npos);
        }
        const Copy copy("plain.zarr");
        copy.write("0/0/0/0", std::string(100, 'x'));
        CHECK(copy.refusal() == "/0/0/0/0: has 100 bytes of values, a chunk has 144");
    }

    TEST_CASE("descriptions that are not read are refused, with the field and its value") {
        const auto array = [](const std::string& from, const std::string& to) {
            return refusal_if("zstd.zarr", "0/.zarray", from, to);
        };
        CHECK(array("\"zarr_format\": 2", "\"zarr_format\": 3") ==
              "/0/.zarray: zarr_format is 3, must be 2");
        CHECK(array("\"<i2\"", "\"<c8\"") ==
              "/0/.zarray: dtype is \"<c8\", must be a byte order and a type, as <u1, <i2, >u2, "
              "<f4 or <f8");
        CHECK(array("\"id\": \"zstd\"", "\"id\": \"lzma\"") ==
              "/0/.zarray: compressor is {\"id\":\"lzma\",\"level\":1}, must be null, zlib, gzip, "
              "zstd or blosc");
        CHECK(array("\"filters\": null", "\"filters\": [{\"id\": \"delta\"}]") ==
              "/0/.zarray: filters is [{\"id\":\"delta\"}], must be null");
        CHECK(array("\"fill_value\": 0", "\"fill_value\": 40000") ==
              "/0/.zarray: fill_value is 40000, must be null or a value of int16");
        CHECK(array("\"order\": \"C\"", "\"order\": 1") ==
              "/0/.zarray: order is 1, must be \"C\" or \"F\"");
        CHECK(array("\"chunks\": [\n        4,", "\"chunks\": [\n        0,") ==
              "/0/.zarray: chunks is [0,5,6], must be 3 whole numbers above 0, as of shape");
        CHECK(array("\"chunks\": [\n        4,", "\"chunks\": [\n        400000000,") ==
              "/0/.zarray: chunks is [400000000,5,6], must be chunks of at most 1073741824 bytes");
        CHECK(array("\"shape\": [\n        4,", "\"shape\": [\n        5000,") ==
              ": its coarsest level has 6x5x5000 voxels, must be at most 4096 along an axis and "
              "8589934592 bytes in all");
        CHECK(array("{", "[") == "/0/.zarray: is no JSON object");
    }

    TEST_CASE("images that are not read are refused, with the field and its value") {
        const auto image = [](const std::string& from, const std::string& to) {
            return refusal_if("zstd.zarr", ".zattrs", from, to);
        };
        CHECK(image("\"multiscales\"", "\"multi\"") ==
              ": is no image of OME-Zarr: its .zattrs has no multiscales");
        CHECK(image("\"path\": \"0\"", "\"path\": \"../0\"") ==
              "/.zattrs: the path of a level is \"../0\", must be a folder inside");
        CHECK(image("\"millimeter\"", "\"parsec\"") ==
              "/.zattrs: the unit of axis \"z\" is \"parsec\", must be a length, as micrometer or "
              "millimeter");
        CHECK(image("\"name\": \"y\"", "\"name\": \"q\"").find("the axes must be t, c, z, y, x") !=
              std::string::npos);
        CHECK(image("\"type\": \"scale\"", "\"type\": \"affine\"").find("must be a scale") !=
              std::string::npos);
        const Copy channels("series.zarr");
        channels.change("0/.zarray", "\"shape\": [\n        2,\n        1,",
                        "\"shape\": [\n        2,\n        3,");
        CHECK(channels.refusal() ==
              ": has 3 channels, a volume has 1: write the wanted one to an image of its own");
        const Copy newer("zstd.zarr");
        newer.write("zarr.json", "{}");
        fs::remove(newer.root / ".zattrs");
        CHECK(newer.refusal() ==
              ": is of Zarr 3 (zarr.json); OME-Zarr 0.1 to 0.4, of Zarr 2, is read");
        ImportRequest request;
        request.path = (shipped / "zstd.zarr").string();
        request.read = ReadBy::gps;
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("its values lie in chunks"),
                             ImportError);
    }

    TEST_CASE("images of versions before 0.4 state no distances") {
        const Copy copy("blosc.zarr");
        std::string text = copy.text(".zattrs");
        for (std::size_t at; (at = text.find("coordinateTransformations")) != std::string::npos;) {
            text.replace(at, 25, "none");
        }
        copy.write(".zattrs", text);
        CHECK(has_finding(copy.read(), "spacing"));
        ImportRequest request;
        request.path = copy.root.string();
        request.spacing_mm = glm::dvec3(0.5, 1.5, 2);
        const Volume volume = import_volume(request);
        CHECK(volume.voxel_to_patient[0] == glm::dvec4(0.5, 0, 0, 0));
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 2, 0));
    }

    TEST_CASE("the image's own transformations follow those of the level") {
        const Copy copy("zstd.zarr");
        copy.change(".zattrs", "\"datasets\"",
                    "\"coordinateTransformations\": [{\"type\": \"scale\", \"scale\": [1, 1, 2]}, "
                    "{\"type\": \"translation\", \"translation\": [0, 0, 1]}], \"datasets\"");
        const Volume volume = copy.read();
        CHECK(volume.voxel_to_patient[0].x == 1);
        CHECK(volume.voxel_to_patient[3].x == 21);
    }

    TEST_CASE("a level needs no other level, and no level may be a link out of the image") {
        const Copy copy("blosc.zarr");
        fs::remove_all(copy.root / "0");
        CHECK(import_volume(copy.root / "1").nx == 3);
        fs::create_directory_symlink(shipped / "blosc.zarr/0", copy.root / "0");
        CHECK(copy.refusal().find("lies outside of the header's folder") != std::string::npos);
    }

    TEST_CASE("a chunk that cannot be looked for is an error, not a missing chunk") {
        const Copy copy("blosc.zarr");
        fs::remove_all(copy.root / "0/0");
        fs::create_symlink("0", copy.root / "0/0");  // A link to itself.
        CHECK(copy.refusal().starts_with("/0/0/0/0: "));
    }

    TEST_CASE("deep JSON, many levels and much to decompress are refused") {
        const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
        CHECK(refusal_if("zstd.zarr", ".zattrs", "{", "{\"deep\": " + deep + ",") ==
              "/.zattrs: nests deeper than 32 levels");
        std::string sets = "\"datasets\": [";
        for (int i = 0; i < 64; ++i) {
            sets += "{\"path\": \"0\"},";
        }
        CHECK(refusal_if("zstd.zarr", ".zattrs", "\"datasets\": [", sets) ==
              "/.zattrs: names 65 datasets, must name 1 to 64");
        const Copy copy("plain.zarr");
        copy.change("0/.zarray", "\"shape\": [\n        4,\n        5,\n        6",
                    "\"shape\": [\n        4000,\n        5,\n        6");
        copy.change("0/.zarray", "\"chunks\": [\n        4,\n        3,\n        6",
                    "\"chunks\": [\n        1,\n        10000,\n        10000");
        CHECK(
            copy.refusal().starts_with(": has 4000 chunks of 200000000 bytes, must have at most"));
    }

    TEST_CASE("the chunks of an image are not searched for DICOM slices") {
        const Copy copy("zstd.zarr");
        copy.write("0/slice.dcm", dicom_image(2, 2, std::string(8, 'x')).file());
        CHECK(find_slices((copy.root / "0/slice.dcm").string(), {}).size() == 1);
        CHECK(find_slices(copy.root.string(), {}).empty());
    }

    TEST_CASE("without units, millimeters are assumed, and said") {
        const Copy copy("zstd.zarr");
        std::string text = copy.text(".zattrs");
        for (std::size_t at; (at = text.find("\"unit\"")) != std::string::npos;) {
            text.replace(at, 6, "\"u\"");
        }
        copy.write(".zattrs", text);
        const Volume volume = copy.read();
        check_place(volume);
        CHECK(has_finding(volume, "v.ome.zarr states no unit of z, y, x: millimeters are assumed"));
        CHECK(volume.name == "v");
    }
}
