// Files of stereo pairs, taken apart as CIPA DC-007 describes them.
#include <OpenImageIO/imageio.h>
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "host/io/picture/multi_picture.hpp"
#include "host/io/picture/picture.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int width = 72, height = 40;

/// A smooth picture of one eye; `blue` tells the eyes apart.
Bytes eye(std::uint8_t blue) {
    Bytes rgba;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            rgba.insert(rgba.end(), {static_cast<std::uint8_t>(3 * x),
                                     static_cast<std::uint8_t>(5 * y), blue, 255});
        }
    }
    return rgba;
}

Bytes file_bytes(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// The greatest difference of a JPEG's bytes from the picture that was written.
int greatest_loss(const std::string& path, const Bytes& rgba, int expected_width) {
    const auto input = OIIO::ImageInput::open(path);
    REQUIRE(input);
    REQUIRE(input->spec().width == expected_width);
    REQUIRE(input->spec().height == height);
    REQUIRE(input->spec().nchannels == 3);
    Bytes rgb(static_cast<std::size_t>(expected_width) * height * 3);
    REQUIRE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, rgb.data()));
    int most = 0;
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        most = std::max(most, std::abs(int{rgb[i]} - int{rgba[i / 3 * 4 + i % 3]}));
    }
    return most;
}

std::uint32_t number(const Bytes& bytes, std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int i = count; i-- > 0;) {
        value = value << 8 | bytes.at(at + static_cast<std::size_t>(i));
    }
    return value;
}

/// Value, or place of the values, by tag of the directory at `at`. Also the place of the next one.
struct Directory {
    Directory(const Bytes& bytes, std::size_t at) {
        const std::uint32_t count = number(bytes, at, 2);
        std::uint32_t before = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::size_t field = at + 2 + std::size_t{12} * i;
            const std::uint32_t tag = number(bytes, field, 2);
            CHECK_MESSAGE(tag > before, "tags ascend");
            before = tag;
            values[tag] = number(bytes, field + 8, 4);
        }
        next = number(bytes, at + 2 + std::size_t{12} * count, 4);
    }
    std::map<std::uint32_t, std::uint32_t> values;
    std::uint32_t next = 0;
};

/// The place of the header in the segment "MPF" of the JPEG file that begins at `start`.
std::size_t header_of(const Bytes& bytes, std::size_t start) {
    REQUIRE(number(bytes, start, 2) == 0xd8ff);
    for (std::size_t at = start + 2; bytes.at(at) == 0xff && bytes.at(at + 1) != 0xda;
         at += 2 + (std::size_t{bytes.at(at + 2)} << 8 | bytes.at(at + 3))) {
        if (bytes[at + 1] == 0xe2 &&
            std::string(&bytes[at + 4], &bytes[at + 8]) == std::string("MPF\0", 4)) {
            REQUIRE(number(bytes, at + 8, 4) == 0x002a'4949);  // "II", 42.
            return at + 8;
        }
    }
    FAIL("no segment MPF");
    return 0;
}

/// The attributes of an image: its number, and the base line in millimeters.
std::pair<std::uint32_t, double> attributes_at(const Bytes& bytes, std::size_t header,
                                               std::size_t at) {
    const Directory fields(bytes, header + at);
    CHECK(fields.next == 0);
    CHECK(fields.values.at(0xb204) == 1);
    const std::size_t angle = header + fields.values.at(0xb205);
    CHECK(number(bytes, angle, 4) == 0);  // Parallel axes.
    CHECK(number(bytes, angle + 4, 4) == 1);
    const std::size_t length = header + fields.values.at(0xb206);
    return {fields.values.at(0xb101),
            1000.0 * number(bytes, length, 4) / number(bytes, length + 4, 4)};
}

}  // namespace

TEST_SUITE("host/io/picture") {
    TEST_CASE("an .mpo file has both eyes, each where its index says, within JPEG's loss") {
        const TemporaryFolder folder;
        const std::string path = folder.file("pair.mpo");
        Bytes both = eye(40);
        const Bytes left = both, right = eye(200);
        both.insert(both.end(), right.begin(), right.end());
        write_picture(path, {width, height, both, "bone", {{"separation_mm", "63.5"}}, {}, 2});

        const Bytes file = file_bytes(path);
        const std::size_t header = header_of(file, 0);
        const Directory index(file, header + number(file, header + 4, 4));
        CHECK(index.values.at(0xb000) == number({'0', '1', '0', '0'}, 0, 4));
        CHECK(index.values.at(0xb001) == 2);
        const std::size_t entries = header + index.values.at(0xb002);
        CHECK(number(file, entries, 4) == 0x2002'0002);  // Representative, disparity, JPEG.
        CHECK(number(file, entries + 16, 4) == 0x0002'0002);
        const std::size_t left_bytes = number(file, entries + 4, 4);
        const std::size_t second = header + number(file, entries + 24, 4);
        CHECK(number(file, entries + 8, 4) == 0);
        CHECK(second == left_bytes);
        CHECK(second + number(file, entries + 20, 4) == file.size());
        CHECK(number(file, left_bytes - 2, 2) == 0xd9ff);  // The end of the first image,
        CHECK(number(file, second, 2) == 0xd8ff);          // and the start of the second.

        CHECK(attributes_at(file, header, index.next) == std::pair{1U, 63.5});
        const std::size_t other = header_of(file, second);
        const std::size_t first_directory = number(file, other + 4, 4);
        CHECK(attributes_at(file, other, first_directory) == std::pair{2U, 63.5});
        CHECK(Directory(file, other + first_directory).values.contains(0xb000));

        const auto cut = static_cast<std::ptrdiff_t>(second);
        const std::string l = folder.file("l.jpg"), r = folder.file("r.jpg");
        std::ofstream(l, std::ios::binary).write(reinterpret_cast<const char*>(file.data()), cut);
        std::ofstream(r, std::ios::binary)
            .write(reinterpret_cast<const char*>(file.data()) + cut, std::ssize(file) - cut);
        CHECK(greatest_loss(l, left, width) < 12);
        CHECK(greatest_loss(r, right, width) < 12);
        CHECK(greatest_loss(l, right, width) > 100);
        const auto read = OIIO::ImageInput::open(r);
        CHECK(read->spec().get_string_attribute("ImageDescription") ==
              "bone\npxpl5:separation_mm=63.5");
    }

    TEST_CASE("a .jps file is one JPEG as wide as the picture, in small or large letters") {
        const TemporaryFolder folder;
        for (const char* name : {"pair.jps", "PAIR.JPS"}) {
            write_picture(folder.file(name), {width, height, eye(90), ""});
            std::filesystem::copy_file(folder.file(name), folder.file(std::string(name) + ".jpg"));
            CHECK(greatest_loss(folder.file(std::string(name) + ".jpg"), eye(90), width) < 12);
        }
    }

    TEST_CASE("a stereo file refuses other numbers of pictures, and texts that JPEG cannot hold") {
        const TemporaryFolder folder;
        const auto refusal = [&](const std::string& name, const Picture& picture) {
            try {
                write_picture(folder.file(name), picture);
            } catch (const PictureError& error) {
                return std::string(error.what()).substr(folder.file("").size());
            }
            return std::string("no error");
        };
        Bytes three = eye(1);
        const Bytes one = three;
        CHECK(refusal("a.mpo", {width, height, one, ""}) ==
              "a.mpo: 1 pictures, but .mpo holds 2, one for each eye");
        three.insert(three.end(), one.begin(), one.end());
        CHECK(refusal("a.jps", {width, height, three, "", {}, {}, 2}) ==
              "a.jps: 2 pictures need an animation, which is .gif; '.jps' holds one");
        three.insert(three.end(), one.begin(), one.end());
        CHECK(refusal("a.mpo", {width, height, three, "", {}, {}, 3}) ==
              "a.mpo: 3 pictures, but .mpo holds 2, one for each eye");
        CHECK(refusal("a.jps", {width, height, one, std::string(30'001, 'x')}) ==
              "a.jps: description and attributes have 30001 bytes, but JPEG has room for 30000. "
              "Write a .png");
        CHECK(refusal("a.jps", {width, height, one, std::string(30'000, 'x')}) == "no error");
    }

    TEST_CASE("bytes that are no JPEG file are refused") {
        const Bytes png = {0x89, 'P', 'N', 'G'}, jpeg = {0xff, 0xd8, 0xff, 0xd9};
        CHECK_THROWS_AS(multi_picture({png, jpeg}, 1), PictureError);
        CHECK_THROWS_AS(multi_picture({jpeg, png}, 1), PictureError);
        const Bytes both = multi_picture({jpeg, jpeg}, 1);
        CHECK(header_of(both, 0) == 2 + 8);  // Without APP0, right behind the start.
    }
}
