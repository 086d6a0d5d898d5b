// Archives that are damaged, cut, huge, or no archives: no value changes without a word.
#include <doctest/doctest.h>
#include <zstd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/io/packed/packed_files.hpp"
#include "tests/host/io/packed/packed_series.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;

namespace {

/// Compresses as the program `zstd`. libarchive leaves the checksum out.
std::string zstd_with_checksum(const std::string& bytes) {
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                       &ZSTD_freeCCtx);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    std::string all(ZSTD_compressBound(bytes.size()), '\0');
    all.resize(ZSTD_compress2(context.get(), all.data(), all.size(), bytes.data(), bytes.size()));
    return all;
}

}  // namespace

TEST_SUITE("host/io/packed") {
    TEST_CASE("what is no archive of a scan is refused with the reason and what to do") {
        const TemporaryFolder folder;
        const auto says = [](const std::string& text, const std::string& words) {
            CAPTURE(text);
            CHECK(text.find(words) != std::string::npos);
        };
        const std::string path = folder.file("scan.zip");
        folder.write("scan.zip", packed({{"a.nii", "text"}, {"b.txt", "text"}}));
        CHECK(refusal(path) ==
              path +
                  ": none of the 2 files in it is a DICOM image. Unpack it, and load the folder "
                  "or file that holds the volume");
        for (const int format : {ARCHIVE_FORMAT_ZIP, ARCHIVE_FORMAT_TAR_USTAR}) {
            folder.write("scan.zip", packed({}, format));
            says(refusal(path), path + ": there are no files in it. Unpack it");
        }
        folder.write("scan.zip", packed({{"a.nii", "text"}}));
        says(refusal(path), path + ": the only file in it is no DICOM image. Unpack it");
        folder.write("scan.zip", "no archive");
        says(refusal(path), path + ": is ");
        says(refusal(path), "or unpack it with another program");
        folder.write("scan.zip", "");
        says(refusal(path), path + ": ");
        const std::string whole =
            packed(series(), ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:compression=store");
        folder.write("scan.zip", whole.substr(0, whole.size() / 2));
        says(refusal(path), "damaged or cut");
        folder.write("scan.zip", packed(series(), ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE,
                                        "zip:encryption=aes256", "secret"));
        says(refusal(path), path + "/IM1: is protected by a password");
        folder.write("scan.zip", packed(series()));
        says(refusal(path, ReadBy::gps), "GPs cannot read the values");
        CHECK(refusal(path) == "");
    }

    TEST_CASE("no flipped bit of a compressed archive changes a value without a word") {
        const TemporaryFolder folder;
        for (const ArchiveKind& kind : kinds) {
            if (kind.format != ARCHIVE_FORMAT_ZIP && kind.compression == ARCHIVE_FILTER_NONE) {
                continue;  // Tar has no checksum of data.
            }
            CAPTURE(kind.name);
            CAPTURE(kind.compression);
            const fs::path own = folder.file(kind.name);
            const std::string whole =
                kind.compression == ARCHIVE_FILTER_ZSTD
                    ? zstd_with_checksum(packed(series(), kind.format))
                    : packed(series(), kind.format, kind.compression, kind.options);
            folder.write(kind.name, whole);
            const Volume expected = read(own);
            for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 5) {
                CAPTURE(bit);
                std::string flipped = whole;
                flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
                folder.write(kind.name, flipped);
                ImportRequest request;
                request.path = own;
                try {
                    const Volume volume = import_volume(request);
                    if (volume.values != expected.values) {
                        CHECK(volume.findings.size() > expected.findings.size());
                    }
                } catch (const ImportError& error) {
                    CHECK(std::string(error.what()).starts_with(own.string()));
                }
            }
        }
    }

    TEST_CASE("a tar archive that is cut, or goes on after its end, is refused") {
        const TemporaryFolder folder;
        const std::string whole = packed(series(), ARCHIVE_FORMAT_TAR_USTAR);
        constexpr std::size_t block = 512;
        std::size_t refused = 0;
        for (std::size_t bytes = 0; bytes < whole.size(); bytes += block) {
            CAPTURE(bytes);
            const std::string path = folder.write("scan.tar", whole.substr(0, bytes));
            const std::string text = refusal(path);
            if (whole.find_first_not_of('\0', bytes) != std::string::npos) {
                CHECK(text.find("cut") != std::string::npos);
                ++refused;
            }
        }
        CHECK(refused > 8);  // Two blocks or more of each file.
        CHECK(refusal(folder.write("scan.tar", whole + std::string(block, '\0'))) == "");
        CHECK(refusal(folder.write("scan.tar", whole + whole)).find("goes on after the end") !=
              std::string::npos);
        for (const int compression :
             {ARCHIVE_FILTER_GZIP, ARCHIVE_FILTER_BZIP2, ARCHIVE_FILTER_XZ, ARCHIVE_FILTER_ZSTD}) {
            CAPTURE(compression);
            const std::string small = packed(series(), ARCHIVE_FORMAT_TAR_USTAR, compression);
            for (const std::size_t lost : {std::size_t{1}, small.size() / 2}) {
                CAPTURE(lost);
                const std::string path =
                    folder.write("scan.tgz", small.substr(0, small.size() - lost));
                CHECK(refusal(path).find("cut") != std::string::npos);
            }
        }
    }

    TEST_CASE("a file that cannot be unpacked is left out by name") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files.emplace_back("notes.pdf", std::string(100, 'x'));
        std::string bytes =
            packed(files, ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:compression=store");
        // The method of the last file in the directory, and in front of its data: deflate64.
        constexpr char unsupported = 9;
        bytes[bytes.rfind("PK\1\2") + 10] = unsupported;
        bytes[bytes.rfind("PK\3\4") + 8] = unsupported;
        const std::string path = folder.write("scan.zip", bytes);
        const Volume volume = read(path);
        CHECK(volume.nz == 4);
        REQUIRE(!volume.findings.empty());
        const std::string text = volume.findings.front().text;
        CHECK(text.starts_with(path + "/notes.pdf: cannot be unpacked (Compression method not"));
        CHECK(text.ends_with(": this file is left out"));
    }

    TEST_CASE("zeros in place of the last files of an uncompressed tar archive are refused") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files.emplace_back("other", std::string(30'000, 'x'));
        const std::string whole = packed(files, ARCHIVE_FORMAT_TAR_USTAR);
        std::string hollow = whole;
        const std::size_t from = whole.find("IM3");
        std::fill(hollow.begin() + static_cast<std::ptrdiff_t>(from), hollow.end(), '\0');
        CHECK(refusal(folder.write("scan.tar", hollow)).find("may not have been copied") !=
              std::string::npos);
        CHECK(refusal(folder.write("scan.tar", whole)) == "");
    }

    TEST_CASE("zeros may follow the compressed data of an archive, other bytes may not") {
        const TemporaryFolder folder;
        for (const int compression :
             {ARCHIVE_FILTER_GZIP, ARCHIVE_FILTER_BZIP2, ARCHIVE_FILTER_XZ, ARCHIVE_FILTER_ZSTD}) {
            CAPTURE(compression);
            const std::string whole = packed(series(), ARCHIVE_FORMAT_TAR_USTAR, compression);
            std::string second = whole;
            second[1] = static_cast<char>(second[1] ^ 1);  // Its mark is damaged.
            CHECK(refusal(folder.write("scan.tgz", whole + second)) != "");
            for (const char* const more : {"x", "\n", "xx"}) {
                const std::string text = refusal(folder.write("scan.tgz", whole + more));
                const bool is_said = text.find("goes on after") != std::string::npos;
                CHECK(is_said ==
                      (compression == ARCHIVE_FILTER_GZIP || compression == ARCHIVE_FILTER_BZIP2));
                CHECK(text != "");  // xz and zstd call it broken.
            }
            const bool has_padding = compression != ARCHIVE_FILTER_ZSTD;
            if (has_padding) {
                CHECK(refusal(folder.write("scan.tgz", whole + std::string(4096, '\0'))) == "");
            }
        }
    }

    TEST_CASE("two ZIP archives in one file are refused") {
        const TemporaryFolder folder;
        const std::string first = packed(series()), second = packed(series("9.9.9"));
        CHECK(refusal(folder.write("scan.zip", first + second))
                  .find("is not one whole ZIP archive") != std::string::npos);
        CHECK(refusal(folder.write("scan.zip", first + "x")).find("is not one whole ZIP archive") !=
              std::string::npos);
    }

    TEST_CASE("an entry with data is a file, whatever its name and its type say") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files[3].first = "IM4_";
        std::string bytes = packed(files);
        for (std::size_t at = 0; (at = bytes.find("IM4_", at)) != std::string::npos; ++at) {
            bytes.replace(at, 4, "IM4/");
        }
        CHECK(read(folder.write("scan.zip", bytes)).nz == 4);
    }

    TEST_CASE("the first name of a tar archive does not say what the archive is") {
        const TemporaryFolder folder;
        for (const char* const name : {"PK\3\4", "PK_0001", "BZh9", "\x1f\x8b", "P*M\x18"}) {
            CAPTURE(name);
            NamedBytes files = series();
            files[0].first = name;
            CHECK(read(folder.write("scan.tar", packed(files, ARCHIVE_FORMAT_TAR_USTAR))).nz == 4);
        }
    }

    TEST_CASE("very long names, and later parts of a tar archive, are refused") {
        const TemporaryFolder folder;
        const NamedBytes files = {{std::string(5000, 'a'), series()[0].second}};
        CHECK(refusal(folder.write("scan.zip", packed(files)))
                  .find("a name of a file in it has 5000 bytes, must be at most 4096") !=
              std::string::npos);
        const auto labelled = [&](char type, const std::string& label) {
            NamedBytes all = series();
            all.insert(all.begin(), {label, ""});
            std::string part = packed(all, ARCHIVE_FORMAT_TAR_GNUTAR);
            constexpr std::size_t block = 512, checksum_at = 148, type_at = 156;
            part[type_at] = type;
            std::fill_n(part.begin() + checksum_at, 8, ' ');
            unsigned sum = 0;
            for (std::size_t i = 0; i < block; ++i) {
                sum += static_cast<unsigned char>(part[i]);
            }
            std::snprintf(&part[checksum_at], 7, "%06o", sum);
            return refusal(folder.write("scan.tar", part));
        };
        constexpr const char* later = "is a later part of a tar archive";
        CHECK(labelled('M', "IM0").find(later) != std::string::npos);
        CHECK(labelled('V', "scan Volume 2").find(later) != std::string::npos);
        for (const char* const label : {"scan Volume 1", "Brain Volume data", "scan"}) {
            CAPTURE(label);
            CHECK(labelled('V', label) == "");
        }
    }

    TEST_CASE("small archives of many bytes or files are refused") {
        const TemporaryFolder folder;
        const std::uint64_t most_bytes = 100'000;
        NamedBytes zeros = {{"zeros", std::string(3 * most_bytes, '\0')}};
        const std::string bomb =
            folder.write("scan.tar.xz", packed(zeros, ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_XZ));
        CHECK_THROWS_WITH_AS(unpack(bomb, most_bytes),
                             doctest::Contains("unpacks to more than 200000 bytes"), ImportError);
        CHECK(unpack(bomb).others == 1);
        const std::string twice = folder.write(
            "twice.tar.xz",
            packed(zeros, ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_XZ, nullptr, nullptr, 2));
        CHECK(refusal(twice).find("is no ZIP or tar archive") != std::string::npos);
        NamedBytes folders;
        for (std::size_t i = 0; i <= max_packed_entries; ++i) {
            folders.emplace_back(std::to_string(i) + "/", "");
        }
        const std::string many = folder.write(
            "many.tgz", packed(folders, ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_GZIP));
        CHECK(refusal(many).find("has more than 65536 files, folders and links") !=
              std::string::npos);
    }

    TEST_CASE("an archive that unpacks to too many bytes is refused before they are there") {
        const TemporaryFolder folder;
        const NamedBytes files = series();
        const std::string path = folder.write("scan.zip", packed(files));
        const std::uint64_t bytes = 4 * files[0].second.size();
        CHECK(unpack(path, bytes).dicom.size() == 4);
        CHECK_THROWS_WITH_AS(unpack(path, bytes - 1), doctest::Contains("have more than"),
                             ImportError);
    }
}
