// Tests attributes of DICOM files as texts, and thumbnails of slices.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/dicom/thumbnail.hpp"
#include "tests/host/io/dicom_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// A slice whose left half is 0, and whose right half is 100, with two bright voxels.
DicomSet halves(int columns, int rows, double x_mm, double y_mm) {
    std::vector<std::int16_t> values;
    for (int at = 0; at < columns * rows; ++at) {
        values.push_back(at % columns < columns / 2 ? 0 : 100);
    }
    DicomSet set = dicom_image(columns, rows, bytes_of(values));
    dicom_place(set, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, x_mm, y_mm);
    return set;
}

Thumbnail thumbnail(const TemporaryFolder& folder, const DicomSet& set,
                    std::optional<std::pair<double, double>> window) {
    return thumbnail_of(read_dicom_slices(folder.write("slice.dcm", set.file())).at(0), window);
}

}  // namespace

TEST_CASE("attributes have keywords, representations, values and depths") {
    const TemporaryFolder folder;
    DicomSet item;
    item.text(8, 0x104, "LO", "inner");
    DicomSet set = halves(4, 2, 1, 1);
    set.text(8, 5, "CS", "ISO_IR 100").text(0x10, 0x10, "PN", "M\xfcller^Eva");
    set.sequence(8, 0x1140, {item, item}).text(0x10, 0x4000, "LT", std::string(300, 'x'));
    const DicomAttributes found = read_attributes(folder.write("a.dcm", set.file()));
    CHECK(found.is_whole);
    CHECK(found.value(0x10, 0x10) == "M\xc3\xbcller^Eva");
    CHECK(found.value(0x28, 0x10) == "2");
    CHECK(found.value(2, 0x10) == "1.2.840.10008.1.2.1");
    CHECK(found.value(8, 0x104) == "");
    CHECK(found.value(0x7fe0, 0x10) == "");
    std::vector<DicomAttribute> inner;
    for (const DicomAttribute& each : found.all) {
        if (each.keyword == "PatientName") {
            CHECK(each.vr == "PN");
            CHECK(each.depth == 0);
        }
        if (each.group == 0x10 && each.element == 0x4000) {
            CHECK(each.value == std::string(max_value_chars, 'x'));
            CHECK(each.is_cut);
        }
        if (each.depth == 1) {
            inner.push_back(each);
        }
    }
    REQUIRE(inner.size() == 2);
    CHECK(inner[0].value == "inner");
    CHECK(inner[0].keyword == "CodeMeaning");
    CHECK(found.value(8, 0x1140) == "2 items");
}

TEST_CASE("texts of unknown character sets keep what is ASCII, and nothing controls a terminal") {
    CHECK(utf8_of("a\xe9z", "ISO_IR 100") == "a\xc3\xa9z");
    CHECK(utf8_of("a\xe9z", "ISO_IR 144") == "a?z");
    CHECK(utf8_of("a\xc3\xa9z", "ISO_IR 192") == "a\xc3\xa9z");
    CHECK(utf8_of("\x1b[2Jx\n\x07", "") == "???????");
    CHECK(utf8_of("\x08x\n\x7f", "") == " x  ");
    CHECK(utf8_of("\xed\xa0\x80", "") == "???");  // A surrogate.
    CHECK(utf8_of("\xc0\x80\xf5", "") == "???");
    CHECK(utf8_of("a\xc2\x9b\x33mz", "ISO_IR 192") == "a 3mz");  // U+009B: control sequence.
    CHECK(utf8_of("a\x9bz\xa0", "ISO_IR 100") == "a z\xc2\xa0");
    CHECK(utf8_of("Yamada^Tarou=\x1b$B;3ED\x1b(B", "\\ISO 2022 IR 87") ==
          "Yamada^Tarou=??????????");
}

TEST_CASE("numbers of binary elements are texts, and the dictionary knows those without a type") {
    const TemporaryFolder folder;
    const auto value = [&folder](const DicomSet& set, std::uint16_t group, std::uint16_t element) {
        return read_attributes(folder.write("a.dcm", set.file())).value(group, element);
    };
    const std::string minus_2000 = bytes_of(static_cast<std::int16_t>(-2000));
    DicomSet set = halves(4, 2, 1, 1);
    set.put(0x28, 0x120, "UN", minus_2000);
    CHECK(value(set, 0x28, 0x120) == "-2000");
    set.number(0x28, 0x103, 0);
    CHECK(value(set, 0x28, 0x120) == "63536");
    set.put(0x28, 9, "AT", bytes_of(std::uint16_t{0x18}) + bytes_of(std::uint16_t{0x1063}));
    CHECK(value(set, 0x28, 9) == "(0018,1063)");
    set.put(0x18, 0x9087, "FD", bytes_of(0.5) + bytes_of(-3.0));
    CHECK(value(set, 0x18, 0x9087) == "0.5\\-3");
    set.put(0x29, 0x1010, "OB", "12345678");
    CHECK(value(set, 0x29, 0x1010) == "8 bytes");
}

TEST_CASE("a file of very many, long or deep attributes is cut, and says so") {
    const TemporaryFolder folder;
    const auto read = [&folder](const DicomSet& set) {
        return read_attributes(folder.write("a.dcm", set.file()));
    };
    DicomSet many = halves(4, 2, 1, 1), wide = many.text(8, 5, "CS", "ISO_IR 192"), deep = many;
    const auto private_element = [](int at) { return static_cast<std::uint16_t>(0x1000 + at); };
    for (int at = 0; at < 2500; ++at) {
        many.text(0x29, private_element(at), "SH", "x");
    }
    CHECK(read(many).all.size() == max_dicom_attributes);
    CHECK(!read(many).is_whole);
    std::string letters;
    for (std::size_t at = 0; at < max_value_chars; ++at) {
        letters += "\xe2\x82\xac";
    }
    for (int at = 0; at < 1500; ++at) {
        wide.text(0x29, private_element(at), "LT", letters);
    }
    const DicomAttributes cut = read(wide);
    std::size_t bytes = 0;
    for (const DicomAttribute& each : cut.all) {
        bytes += each.value.size();
    }
    CHECK(bytes > 500'000);
    CHECK(bytes < 530'000);
    CHECK(!cut.is_whole);
    for (int depth = 1; depth <= 6; ++depth) {
        deep = DicomSet(depth < 6 ? DicomSet() : halves(4, 2, 1, 1)).sequence(8, 0x1140, {deep});
    }
    const DicomAttributes flat = read(deep);
    CHECK(!flat.is_whole);
    CHECK(std::ranges::max(flat.all, {}, &DicomAttribute::depth).depth == max_attribute_depth);
}

TEST_CASE("a file of broken elements is refused by name") {
    const TemporaryFolder folder;
    std::string bytes = halves(4, 2, 1, 1).file();
    bytes.resize(bytes.size() - 30);
    CHECK_THROWS_AS((void)read_attributes(folder.write("cut.dcm", bytes + "\x10")), ImportError);
}

TEST_CASE("a thumbnail has the shape of the slice, and the gray of its window") {
    const TemporaryFolder folder;
    const Thumbnail wide = thumbnail(folder, halves(200, 100, 1, 1), std::pair(50.0, 100.0));
    CHECK(wide.width == thumbnail_side);
    CHECK(wide.height == thumbnail_side / 2);
    CHECK(wide.pixels.size() == static_cast<std::size_t>(wide.width * wide.height));
    CHECK(wide.pixels.front() == 0);
    CHECK(wide.pixels.back() == 255);
    const Thumbnail pale = thumbnail(folder, halves(200, 100, 1, 1), std::pair(100.0, 400.0));
    CHECK(pale.pixels.front() == 64);  // 0 is a quarter of -100 to 300.
    CHECK(pale.pixels.back() == 128);  // 100 is the middle.
    const Thumbnail square = thumbnail(folder, halves(200, 100, 0.5, 1), std::nullopt);
    CHECK(square.width == square.height);
    CHECK(square.pixels.front() == 0);
    CHECK(square.pixels.back() == 255);
    for (const auto& [center, width] :
         {std::pair(std::nan(""), 100.0), std::pair(50.0, std::numeric_limits<double>::infinity()),
          std::pair(50.0, 0.0), std::pair(0.0, -5.0)}) {
        CAPTURE(width);
        const Thumbnail own = thumbnail(folder, halves(8, 8, 1, 1), std::pair(center, width));
        CHECK(own.pixels.front() == 0);
        CHECK(own.pixels.back() == 255);
    }
    const Thumbnail small = thumbnail(folder, halves(4, 2, 1, 1), std::nullopt);
    CHECK(small.width == 4);
    CHECK(small.height == 2);
}

TEST_CASE("a window is of rescaled values, and pixels may be compressed") {
    const TemporaryFolder folder;
    DicomSet set = dicom_image(2, 2, bytes_of(std::vector<std::int16_t>{-50, 50, -50, 50}));
    dicom_place(set, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    set.text(0x28, 0x1052, "DS", "100").text(0x28, 0x1053, "DS", "2");
    const std::vector<std::uint8_t> gray{64, 191, 64, 191};  // 0 and 200, from -100 to 300.
    CHECK(thumbnail(folder, set, std::pair(100.0, 400.0)).pixels == gray);
    std::vector<std::uint32_t> header(16);
    header[0] = 2;   // Segments: upper bytes, lower bytes.
    header[1] = 64;  // Places.
    header[2] = 70;
    set.compressed_pixels(bytes_of(header) + std::string("\3\xff\0\xff\0\x80", 6) +
                          std::string("\3\xce\x32\xce\x32\x80", 6));
    const std::string rle = set.file("1.2.840.10008.1.2.5");
    const DicomSlice slice = read_dicom_slices(folder.write("rle.dcm", rle)).at(0);
    CHECK(thumbnail_of(slice, std::pair(100.0, 400.0)).pixels == gray);
}

TEST_CASE("a slice of which small values look bright is inverted") {
    const TemporaryFolder folder;
    DicomSet set = halves(8, 8, 1, 1);
    set.text(0x28, 4, "CS", "MONOCHROME1");
    const Thumbnail picture = thumbnail(folder, set, std::nullopt);
    CHECK(picture.pixels.front() == 255);
    CHECK(picture.pixels.back() == 0);
}

TEST_CASE("the middle slice is that of the positions, not of the names") {
    std::vector<DicomSlice> series(5);
    for (std::size_t i = 0; i < series.size(); ++i) {
        series[i].columns = series[i].rows = 2;
        series[i].origin_mm = {0, 0, static_cast<double>(i * 7 % 5)};
        series[i].path = std::to_string(i);
    }
    CHECK(middle_of(series).origin_mm.z == 2);
}
