#include <OpenImageIO/imageio.h>
#include <doctest/doctest.h>

#include <filesystem>

#include "host/io/picture.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int width = 5, height = 3;

/// A picture in which every byte differs from its neighbours.
std::vector<std::uint8_t> pattern(std::uint8_t alpha) {
    std::vector<std::uint8_t> rgba;
    for (int pixel = 0; pixel < width * height; ++pixel) {
        for (const int channel : {1, 80, 170}) {
            rgba.push_back(static_cast<std::uint8_t>(pixel * 5 + channel));
        }
        rgba.push_back(alpha);
    }
    return rgba;
}

struct ReadBack {
    std::vector<std::uint8_t> values;
    int channels = 0;
    std::string description;
};

ReadBack read_back(const std::string& path) {
    const auto input = OIIO::ImageInput::open(path);
    REQUIRE(input);
    ReadBack picture;
    picture.channels = input->spec().nchannels;
    REQUIRE(input->spec().width == width);
    REQUIRE(input->spec().height == height);
    picture.description = input->spec().get_string_attribute("ImageDescription");
    picture.values.resize(static_cast<std::size_t>(width * height * picture.channels));
    REQUIRE(
        input->read_image(0, 0, 0, picture.channels, OIIO::TypeDesc::UINT8, picture.values.data()));
    return picture;
}

std::vector<std::uint8_t> without_alpha(const std::vector<std::uint8_t>& rgba) {
    std::vector<std::uint8_t> rgb;
    for (std::size_t index = 0; index < rgba.size(); ++index) {
        if (index % 4 != 3) {
            rgb.push_back(rgba[index]);
        }
    }
    return rgb;
}

std::size_t files_in(const std::string& folder) {
    const std::filesystem::directory_iterator files(folder);
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

}  // namespace

TEST_SUITE("host/io/picture") {
    TEST_CASE("an opaque picture comes back bit for bit, top row first, without alpha") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        for (const char* suffix : {".png", ".tif", ".exr", ".PNG"}) {
            CAPTURE(suffix);
            const std::string path = folder.file(std::string("p") + suffix);
            write_picture(path, {width, height, rgba, "bone, iso 300.5"});
            const ReadBack got = read_back(path);
            CHECK(got.channels == 3);
            CHECK(got.values == without_alpha(rgba));
            CHECK(got.description == "bone, iso 300.5");
        }
        CHECK(files_in(folder.file("")) == 4);
    }

    TEST_CASE("the same picture gives the same file") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        const auto written = [&](const std::string& name) {
            write_picture(folder.file(name), {width, height, rgba, "d"});
            std::ifstream stream(folder.file(name), std::ios::binary);
            return std::string(std::istreambuf_iterator<char>(stream), {});
        };
        CHECK(written("a.png") == written("b.png"));
    }

    TEST_CASE("transparency is kept as it is, colours not multiplied") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(100);
        write_picture(folder.file("t.png"), {width, height, rgba, ""});
        const auto input = OIIO::ImageInput::create("png");
        OIIO::ImageSpec spec, config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        REQUIRE(input->open(folder.file("t.png"), spec, config));
        REQUIRE(spec.nchannels == 4);
        std::vector<std::uint8_t> got(rgba.size());
        REQUIRE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, got.data()));
        CHECK(got == rgba);
    }

    TEST_CASE("what cannot be written is refused by name, and leaves nothing behind") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        const std::string inside = folder.file("");
        CHECK_THROWS_WITH_AS(write_picture(inside + "p.bmpx", {width, height, rgba, ""}),
                             doctest::Contains("suffix is '.bmpx'"), PictureError);
        CHECK_THROWS_WITH_AS(write_picture(inside + "no/p.png", {width, height, rgba, ""}),
                             doctest::Contains("does not exist"), PictureError);
        CHECK_THROWS_WITH_AS(write_picture(inside + "p.png", {width, height + 1, rgba, ""}),
                             doctest::Contains("need 80 bytes, got 60"), PictureError);
        CHECK_THROWS_WITH_AS(write_picture(inside + "p.png", {0, height, {}, ""}),
                             doctest::Contains("0x3 pixels"), PictureError);
        std::filesystem::create_directory(folder.file("folder.png"));
        folder.write("folder.png/file", "");
        CHECK_THROWS_WITH_AS(write_picture(inside + "folder.png", {width, height, rgba, ""}),
                             doctest::Contains("cannot be written"), PictureError);
        CHECK(files_in(inside) == 1);
    }
}
