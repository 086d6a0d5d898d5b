#include <doctest/doctest.h>
#include <fmt/format.h>
#include <zlib.h>

#include <string>

#include "host/io/formats/byte_source.hpp"
#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int gzip_bits = 15 + 16, zlib_bits = 15;

std::string deflated(const std::string& bytes, int window_bits) {
    z_stream stream{};
    REQUIRE(deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    std::string in = bytes, out(bytes.size() + 1000, '\0');
    stream.next_in = reinterpret_cast<unsigned char*>(in.data());
    stream.avail_in = static_cast<unsigned>(in.size());
    stream.next_out = reinterpret_cast<unsigned char*>(out.data());
    stream.avail_out = static_cast<unsigned>(out.size());
    REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

/// 16x16x16 int16 voxels that compress to about half.
std::string voxel_bytes() {
    std::vector<std::int16_t> values;
    for (unsigned index = 0; index < 4096; ++index) {
        values.push_back(static_cast<std::int16_t>((index * 2654435761U >> 20U) % 200));
    }
    return bytes_of(values);
}

std::string nifti_bytes() {
    return NiftiHeader().put_dims({3, 16, 16, 16, 1, 1, 1, 1}).bytes() + voxel_bytes();
}

std::string meta_image(const std::string& data) {
    return "ObjectType = Image\nNDims = 3\nCompressedData = True\nCompressedDataSize = " +
           std::to_string(data.size()) +
           "\nElementSpacing = 1 1 1\nDimSize = 16 16 16\nElementType = MET_SHORT\n"
           "ElementDataFile = LOCAL\n" +
           data;
}

bool holds_voxels(const Volume& volume) {
    const std::string want = voxel_bytes();
    return volume.values.size() == want.size() &&
           std::memcmp(volume.values.data(), want.data(), want.size()) == 0;
}

}  // namespace

TEST_SUITE("host/io/compressed") {
    TEST_CASE("gzip NIfTI and zlib MetaImage give the voxels that went in") {
        const TemporaryFolder folder;
        CHECK(holds_voxels(
            import_volume(folder.write("v.nii.gz", deflated(nifti_bytes(), gzip_bits)))));
        CHECK(holds_voxels(
            import_volume(folder.write("v.mha", meta_image(deflated(voxel_bytes(), zlib_bits))))));
    }

    TEST_CASE("a NIfTI of several gzip streams is whole") {
        const TemporaryFolder folder;
        const std::string bytes = nifti_bytes();
        const std::string path =
            folder.write("v.nii.gz", deflated(bytes.substr(0, 3000), gzip_bits) +
                                         deflated(bytes.substr(3000), gzip_bits));
        CHECK(ByteSource(path, Encoding::gzip, 0).skip(UINT64_MAX) == bytes.size());
        CHECK(holds_voxels(import_volume(path)));
    }

    TEST_CASE("a stream that is cut anywhere is refused with both sizes") {
        const TemporaryFolder folder;
        const std::string gzip = deflated(nifti_bytes(), gzip_bits);
        const std::string zlib = deflated(voxel_bytes(), zlib_bits);
        for (const std::size_t eighths : {1, 4, 7}) {
            CAPTURE(eighths);
            const std::string cut = fmt::format(
                "; its compressed data are cut: the file ends at byte {}, before "
                "their end",
                gzip.size() * eighths / 8);
            std::string text;
            try {
                import_volume(folder.write("c.nii.gz", gzip.substr(0, gzip.size() * eighths / 8)));
            } catch (const ImportError& error) {
                text = error.what();
            }
            CHECK_MESSAGE(text.find("16x16x16 of int16 need 8192 bytes when decompressed") !=
                              std::string::npos,
                          text);
            CHECK_MESSAGE(text.ends_with(cut), text);
            CHECK_THROWS_WITH_AS(
                import_volume(
                    folder.write("c.mha", meta_image(zlib.substr(0, zlib.size() * eighths / 8)))),
                doctest::Contains("16x16x16 of MET_SHORT need 8192 bytes when decompressed"),
                ImportError);
        }
    }

    TEST_CASE("a stream that is damaged in its middle is refused") {
        const TemporaryFolder folder;
        std::string zlib = deflated(voxel_bytes(), zlib_bits);
        const std::size_t damage = meta_image(zlib).size() - zlib.size() / 2;
        zlib.replace(zlib.size() / 2, 16, 16, '\xff');
        std::string text;
        try {
            import_volume(folder.write("d.mha", meta_image(zlib)));
        } catch (const ImportError& error) {
            text = error.what();
        }
        const std::string words = "; its compressed data are broken at byte ";
        REQUIRE_MESSAGE(text.find(words) != std::string::npos, text);
        const std::size_t at = std::stoul(text.substr(text.find(words) + words.size()));
        CHECK(at >= damage - 1);
        CHECK(at <= damage + zlib.size() / 2);
    }

    TEST_CASE("a wrong checksum is damage, though every value came out") {
        const TemporaryFolder folder;
        std::string gzip = deflated(nifti_bytes(), gzip_bits);
        gzip[gzip.size() - 8] = static_cast<char>(gzip[gzip.size() - 8] ^ 1);
        CHECK_THROWS_WITH_AS(import_volume(folder.write("d.nii.gz", gzip)),
                             doctest::Contains("checksum"), ImportError);
    }

    TEST_CASE("what follows the last stream of a gzip file is no damage") {
        const TemporaryFolder folder;
        CHECK(holds_voxels(import_volume(
            folder.write("t.nii.gz", deflated(nifti_bytes(), gzip_bits) + "trailing words"))));
    }
}
