// How the pixels of a DICOM file lie in their bits: what is read, and what is refused because GDCM
// would assert on it, which ends the process.
#include <doctest/doctest.h>

#include <array>
#include <cstring>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// Two columns and two rows.
template <typename T>
DicomSet image_of(const std::array<T, 4>& values, std::uint16_t stored, bool is_signed) {
    DicomSet set = dicom_image(2, 2, bytes_of(std::vector<T>(values.begin(), values.end())));
    set.number(0x28, 0x100, 8 * sizeof(T)).number(0x28, 0x101, stored);
    set.number(0x28, 0x102, static_cast<std::uint16_t>(stored - 1));
    set.number(0x28, 0x103, is_signed ? 1 : 0);
    return dicom_place(set, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
}

DicomSet plain() {
    return image_of<std::int16_t>({1, 2, 3, 4}, 16, true);
}

std::string complaint(const TemporaryFolder& folder, const DicomSet& set) {
    try {
        import_volume(folder.write("x.dcm", set.file()));
    } catch (const ImportError& error) {
        return std::string(error.what()).substr(folder.file("x.dcm: ").size());
    }
    return "";
}

std::array<double, 2> range_of(const TemporaryFolder& folder, const DicomSet& set) {
    const Volume volume = import_volume(folder.write("x.dcm", set.file()));
    return {volume.minimum, volume.maximum};
}

using Range = std::array<double, 2>;

/// A file of RLE (1.2.840.10008.1.2.5) with these fragments, after an empty table of offsets.
std::string rle_file(DicomSet set, const std::vector<std::string>& fragments) {
    const auto element = [](std::uint16_t number, const std::string& content) {
        return bytes_of<std::uint16_t>(0xfffe) + bytes_of(number) +
               bytes_of(static_cast<std::uint32_t>(content.size())) + content;
    };
    std::string pixels = element(0xe000, "");
    for (const std::string& fragment : fragments) {
        pixels += element(0xe000, fragment);
    }
    pixels += element(0xe0dd, "");
    std::string bytes = set.put(0x7fe0, 0x10, "OB", pixels).file();
    bytes.replace(bytes.size() - pixels.size() - 4, 4, "\xff\xff\xff\xff");  // Undefined length.
    const std::string raw("1.2.840.10008.1.2.1\0", 20), rle("1.2.840.10008.1.2.5\0", 20);
    return bytes.replace(bytes.find(raw), raw.size(), rle);
}

/// The values 1, 2, 3, 4: a segment of upper and one of lower bytes, behind their header.
std::string rle_fragment(std::uint32_t segments = 2, std::uint32_t first = 64,
                         std::uint32_t second = 70) {
    std::vector<std::uint32_t> header(16);
    header[0] = segments;
    header[1] = first;
    header[2] = second;
    return bytes_of(header) + std::string("\3\0\0\0\0\0", 6) + std::string("\3\1\2\3\4\0", 6);
}

}  // namespace

TEST_SUITE("host/io/dicom_layout") {
    TEST_CASE("numbers of samples and bits on which GDCM asserts are refused by name") {
        const TemporaryFolder folder;
        CHECK(complaint(folder, plain().number(0x28, 2, 0)) ==
              "samples per pixel (0028,0002) are 0, must be 1. The file is damaged");
        CHECK(complaint(folder, plain().number(0x28, 2, 2)) ==
              "pixel data (7fe0,0010) have 8 bytes, 2x2x1 of 2 bytes need 16");
        for (const int bits : {0, 1, 7, 12, 24, 64, 128, 255, 4095, 65535}) {
            CHECK(
                complaint(folder, plain().number(0x28, 0x100, static_cast<std::uint16_t>(bits))) ==
                "bits allocated (0028,0100) are " + std::to_string(bits) + ", must be 8, 16 or 32");
        }
        CHECK(complaint(folder, plain().remove(0x28, 0x100)) ==
              "bits allocated (0028,0100) are 0, must be 8, 16 or 32");
        for (const int stored : {0, 17, 255, 65535}) {
            CHECK(complaint(folder,
                            plain().number(0x28, 0x101, static_cast<std::uint16_t>(stored))) ==
                  "bits stored (0028,0101) are " + std::to_string(stored) +
                      ", must be 1 to the 16 bits allocated (0028,0100)");
        }
        for (const int representation : {2, 3, 65535}) {
            CHECK(complaint(folder, plain().number(0x28, 0x103,
                                                   static_cast<std::uint16_t>(representation))) ==
                  "pixel representation (0028,0103) is " + std::to_string(representation) +
                      ", must be 0 (unsigned) or 1 (signed)");
        }
    }

    TEST_CASE("values that do not begin at bit 0 are refused, because GDCM would misread them") {
        const TemporaryFolder folder;
        CHECK(complaint(folder, plain().number(0x28, 0x101, 12).number(0x28, 0x102, 15)) ==
              "high bit (0028,0102) is 15, must be 11, because bits stored (0028,0101) are 12: "
              "values that do not begin at bit 0 are not read");
        CHECK(complaint(folder, plain().number(0x28, 0x101, 12).number(0x28, 0x102, 5)) != "");
        CHECK(range_of(folder, plain().remove(0x28, 0x101).remove(0x28, 0x102)) == Range{1, 4});
        CHECK(range_of(folder, plain().number(0x28, 0x102, 11)) == Range{1, 4});
    }

    TEST_CASE("unused bits are no part of the value, whatever the number of bits") {
        const TemporaryFolder folder;
        CHECK(range_of(folder, image_of<std::uint8_t>({0x85, 0x86, 0x87, 0xff}, 7, false)) ==
              Range{5, 127});
        CHECK(range_of(folder, image_of<std::int8_t>({0x3f, 0x40, 1, 2}, 7, true)) ==
              Range{-64, 63});
        CHECK(range_of(folder, image_of<std::uint16_t>({0xf001, 0xf002, 0x0fff, 7}, 12, false)) ==
              Range{1, 4095});
        CHECK(range_of(folder, image_of<std::uint16_t>({0xf001, 0x0800, 0x0fff, 7}, 12, true)) ==
              Range{-2048, 7});
        CHECK(range_of(folder, image_of<std::uint32_t>({0xff000001, 2, 3, 4}, 24, false)) ==
              Range{1, 4});
        CHECK(range_of(folder, image_of<std::uint32_t>({0x00ffffff, 2, 3, 4}, 24, true)) ==
              Range{-1, 4});
        CHECK(range_of(folder, image_of<std::uint16_t>({1, 0, 3, 2}, 1, false)) == Range{0, 1});
    }

    TEST_CASE("a color space with one sample is refused before GDCM reads its tables") {
        const TemporaryFolder folder;
        DicomSet palette = plain().text(0x28, 4, "CS", "PALETTE COLOR");
        palette.put(0x28, 0x1101, "US", std::string(6, '\1'));
        CHECK(complaint(folder, palette) ==
              "photometric interpretation (0028,0004) is 'PALETTE COLOR', must be MONOCHROME1 or "
              "MONOCHROME2: color is not read");
        for (const char* space : {"RGB", "YBR_FULL_422", "YBR_PARTIAL_420", "UNKNOWN", "CMYK"}) {
            CHECK(complaint(folder, plain().text(0x28, 4, "CS", space)).find(space) !=
                  std::string::npos);
        }
        CHECK(range_of(folder, plain().remove(0x28, 4)) == Range{1, 4});
        CHECK(range_of(folder, plain().text(0x28, 4, "CS", "MONOCHROME1 ")) == Range{1, 4});
    }

    TEST_CASE("damage in what is not shown does not keep the pixels from being read") {
        const TemporaryFolder folder;
        DicomSet icon;
        icon.number(0x28, 2, 9).number(0x28, 0x10, 2).number(0x28, 0x11, 2);
        icon.number(0x28, 0x100, 8).text(0x28, 4, "CS", "PALETTE COLOR");
        DicomSet empty;
        const std::array broken = {
            plain().sequence(0x88, 0x200, {icon}),
            plain().sequence(0x88, 0x200, {empty}),
            plain().text(8, 0x10, "LO", "another code"),
            plain().number(0x28, 6, 7),
            plain().text(0x28, 0x120, "LO", "padding"),
            plain().put(0x28, 0x2110, "CS", ""),
            plain().number(0x6000, 0x10, 2).number(0x6000, 0x11, 2).text(0x6000, 0x40, "CS", "X"),
            plain().number(0x6000, 0x100, 1).put(0x6000, 0x3000, "OW", "ab"),
            plain().number(0x5000, 5, 7).put(0x5000, 0x3000, "OW", "ab"),
            plain().text(8, 0x16, "UI", "1.2.3").text(8, 0x60, "CS", "XX"),
            plain().text(0x18, 0x88, "DS", "0").text(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.4"),
            plain().sequence(0x28, 0x9145, {empty}).sequence(0x5200, 0x9229, {empty}),
        };
        for (std::size_t i = 0; i < broken.size(); ++i) {
            CAPTURE(i);
            CHECK(complaint(folder, broken[i]) == "");
        }
    }

    TEST_CASE("meta information of mixed types, and with a sequence, is refused before GDCM") {
        const TemporaryFolder folder;
        const auto refusal = [&folder](const std::string& from, const std::string& to) {
            std::string bytes = plain().file();
            bytes.replace(bytes.find(from), from.size(), to);
            CHECK_THROWS_AS(import_volume(folder.write("x.dcm", bytes)), ImportError);
            try {
                import_volume(folder.file("x.dcm"));
            } catch (const ImportError& error) {
                return std::string(error.what()).substr(folder.file("x.dcm: ").size());
            }
            return std::string();
        };
        const std::string length("\2\0\0\0", 4), version("\2\0\1\0", 4);
        CHECK(
            refusal(length + "UL" + std::string("\4\0", 2), length + std::string("\4\0\0\0", 4)) ==
            "element (0002,0001) at byte 144 states the type OB, but the first element states "
            "none");
        CHECK(refusal(version + "OB", version + "SQ") ==
              "element (0002,0001) at byte 144 is a sequence, which meta information cannot have");
    }

    TEST_CASE("a file that states a compression and has none is read as it is") {
        const TemporaryFolder folder;
        std::string bytes = plain().file();
        const std::string raw("1.2.840.10008.1.2.1\0", 20), rle("1.2.840.10008.1.2.5\0", 20);
        bytes.replace(bytes.find(raw), raw.size(), rle);
        CHECK(import_volume(folder.write("x.dcm", bytes)).maximum == 4);
    }

    TEST_CASE("fragments of RLE whose header GDCM would divide by are refused before") {
        const TemporaryFolder folder;
        const auto refusal = [&](const std::vector<std::string>& fragments) {
            try {
                import_volume(folder.write("x.dcm", rle_file(plain(), fragments)));
            } catch (const ImportError& error) {
                return std::string(error.what()).substr(folder.file("x.dcm: ").size());
            }
            return std::string();
        };
        const Volume whole =
            import_volume(folder.write("x.dcm", rle_file(plain(), {rle_fragment()})));
        CHECK(whole.minimum == 1);
        CHECK(whole.maximum == 4);
        const std::string damaged = ". The file is damaged";
        for (const std::uint32_t segments : {0U, 1U, 3U, 16U, 0xffffffffU}) {
            CHECK(refusal({rle_fragment(segments)}) ==
                  "frame 1 of its RLE pixels has " + std::to_string(segments) +
                      " segments, values of 2 bytes need 2" + damaged);
        }
        CHECK(refusal({rle_fragment(2, 63)}) ==
              "frame 1 of its RLE pixels has segment 1 at byte 63, allowed are 64 .. 75" + damaged);
        CHECK(refusal({rle_fragment(2, 64, 64)}) ==
              "frame 1 of its RLE pixels has segment 2 at byte 64, allowed are 65 .. 75" + damaged);
        CHECK(refusal({rle_fragment(2, 64, 76)}) ==
              "frame 1 of its RLE pixels has segment 2 at byte 76, allowed are 65 .. 75" + damaged);
        CHECK(refusal({rle_fragment().substr(0, 62)}) ==
              "frame 1 of its RLE pixels has 62 bytes, its header needs 64" + damaged);
        CHECK(refusal({}) ==
              "frame 1 of its RLE pixels has 0 bytes, its header needs 64" + damaged);
    }

    TEST_CASE("each frame of RLE is one fragment") {
        const TemporaryFolder folder;
        const auto file = [&](const std::vector<std::string>& fragments) {
            DicomSet set = plain().text(0x28, 8, "IS", "2").text(0x18, 0x88, "DS", "1");
            return folder.write("x.dcm", rle_file(set, fragments));
        };
        CHECK(import_volume(file({rle_fragment(), rle_fragment()})).nz == 2);
        const std::string name = folder.file("x.dcm");
        CHECK_THROWS_WITH_AS(
            import_volume(file({rle_fragment(), rle_fragment(0)})),
            (name + ": frame 2 of its RLE pixels has 0 segments, values of 2 bytes need 2. The "
                    "file is damaged")
                .c_str(),
            ImportError);
        CHECK_THROWS_WITH_AS(import_volume(file({rle_fragment()})),
                             (name + ": its RLE pixels have 1 fragments, 2 frames need 2. The file "
                                     "is damaged")
                                 .c_str(),
                             ImportError);
    }
}
