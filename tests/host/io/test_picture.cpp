#include <OpenImageIO/imageio.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>

#include <sys/resource.h>

#include "host/io/picture/picture.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int width = 5, height = 3;

/// A picture in which every byte differs from its neighbors.
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

    TEST_CASE("transparency is kept as it is, colors not multiplied") {
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

    TEST_CASE("attributes come back by their names, and mean nothing to the writers") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        Picture picture{width, height, rgba, "bone"};
        picture.attributes = {{"spacing_mm", "0.5x0.5x2"}, {"compression", "none"}};
        for (const char* suffix : {".png", ".exr", ".tif"}) {
            CAPTURE(suffix);
            const std::string path = folder.file(std::string("a") + suffix);
            write_picture(path, picture);
            const auto input = OIIO::ImageInput::open(path);
            REQUIRE(input);
            const auto text = [&](const char* name) {
                return std::string(input->spec().get_string_attribute(name));
            };
            if (std::string(suffix) == ".tif") {
                CHECK(text("ImageDescription") ==
                      "bone\npxpl5:spacing_mm=0.5x0.5x2\npxpl5:compression=none");
                CHECK(text("compression") != "none");
            } else {
                CHECK(text("ImageDescription") == "bone");
                CHECK(text("pxpl5:spacing_mm") == "0.5x0.5x2");
                CHECK(text("pxpl5:compression") == "none");
            }
            CHECK(read_back(path).values == without_alpha(rgba));
        }
        for (const char* name : {"", "a b", "\xc3\xa4"}) {
            picture.attributes = {{name, "v"}};
            CHECK_THROWS_WITH_AS(write_picture(folder.file("n.png"), picture),
                                 doctest::Contains("must be named in"), PictureError);
        }
        picture.attributes = {{"twin", "v"}, {"twin", "w"}};
        CHECK_THROWS_WITH_AS(write_picture(folder.file("n.png"), picture),
                             doctest::Contains("'twin' is there twice"), PictureError);
    }

    TEST_CASE("several pictures are an animation that repeats, with its delay") {
        const TemporaryFolder folder;
        constexpr int side = 64, count = 4;
        const std::array<std::array<std::uint8_t, 3>, count> colors = {
            {{200, 30, 30}, {30, 200, 30}, {30, 30, 200}, {220, 220, 220}}};
        std::vector<std::uint8_t> rgba;
        for (const auto& color : colors) {
            for (int pixel = 0; pixel < side * side; ++pixel) {
                rgba.insert(rgba.end(), {color[0], color[1], color[2], 255});
            }
        }
        Picture picture{side, side, rgba, ""};
        picture.count = count;
        picture.delay_ms = 70;
        const std::string path = folder.file("a.gif");
        write_picture(path, picture);
        const auto input = OIIO::ImageInput::open(path);
        REQUIRE(input);
        for (int index = 0; index < count; ++index) {
            CAPTURE(index);
            REQUIRE(input->seek_subimage(index, 0));
            CHECK(input->spec().get_float_attribute("FramesPerSecond") ==
                  doctest::Approx(1000.0 / 70));
            std::vector<std::uint8_t> got(std::size_t{3} * side * side);
            REQUIRE(input->read_image(index, 0, 0, 3, OIIO::TypeDesc::UINT8, got.data()));
            const auto& color = colors[static_cast<std::size_t>(index)];
            for (const std::size_t at : {std::size_t{0}, got.size() / 2, got.size() - 3}) {
                for (std::size_t channel = 0; channel < 3; ++channel) {
                    CHECK(std::abs(got[at + channel] - color[channel]) <= 2);
                }
            }
        }
        CHECK(!input->seek_subimage(count, 0));
        std::ifstream stream(path, std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(stream), {});
        CHECK(bytes.find(std::string("NETSCAPE2.0\x03\x01\0\0\0", 16)) != std::string::npos);
        CHECK(bytes.back() == ';');
    }

    TEST_CASE("a shaded surface has no bands in an animation") {
        const TemporaryFolder folder;
        constexpr int side = 256, block = 16;
        // A ramp of bone from dark to light: 256 shades of each of three rows of hues.
        const auto shade = [](int x, int y, int channel) {
            const double full = channel == 0 ? 236 : channel == 1 ? 226 - y / 4.0 : 200 - y / 3.0;
            return full * (0.15 + 0.85 * x / (side - 1.0));
        };
        std::vector<std::uint8_t> rgba;
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                for (int channel = 0; channel < 3; ++channel) {
                    rgba.push_back(static_cast<std::uint8_t>(std::lround(shade(x, y, channel))));
                }
                rgba.push_back(255);
            }
        }
        write_picture(folder.file("r.gif"), {side, side, rgba, ""});
        const auto input = OIIO::ImageInput::open(folder.file("r.gif"));
        REQUIRE(input);
        std::vector<std::uint8_t> got(std::size_t{3} * side * side);
        REQUIRE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, got.data()));
        // Where 256 colors would make bands, the mean over a few pixels is still the shade.
        for (int y = 0; y < side; y += block) {
            for (int x = 0; x < side; x += block) {
                for (int channel = 0; channel < 3; ++channel) {
                    double error = 0;
                    for (int pixel = 0; pixel < block * block; ++pixel) {
                        const int px = x + pixel % block, py = y + pixel / block;
                        const auto at = static_cast<std::size_t>((py * side + px) * 3 + channel);
                        error += got[at] - shade(px, py, channel);
                    }
                    CHECK(std::abs(error / (block * block)) < 3);  // Of 200 shades.
                }
            }
        }
    }

    TEST_CASE("an animation that its format does not hold is refused by name") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        Picture picture{width, height, rgba, ""};
        picture.count = 2;
        CHECK_THROWS_WITH_AS(write_picture(folder.file("p.png"), picture),
                             doctest::Contains("2 pictures need an animation, which is .gif"),
                             PictureError);
        CHECK_THROWS_WITH_AS(write_picture(folder.file("p.gif"), picture),
                             doctest::Contains("2 of 5x3 pixels of RGBA need 120 bytes, got 60"),
                             PictureError);
        picture.count = 1;
        picture.delay_ms = 10;
        CHECK_THROWS_WITH_AS(write_picture(folder.file("p.gif"), picture),
                             doctest::Contains("10 ms between pictures, must be 20"), PictureError);
    }

    TEST_CASE("marks are drawn over the file's picture alone") {
        const TemporaryFolder folder;
        const std::vector<std::uint8_t> rgba = pattern(255);
        Picture picture{width, height, rgba, ""};
        // The second column from the left, and the row below the first.
        picture.marks = {pxpl5::host::area_mark({{1, 0}, {2, 0}, {2, 3}, {1, 3}}, {9, 8, 7, 255}),
                         pxpl5::host::line_mark({{0, 1.5F}, {5, 1.5F}}, {1, 2, 3, 255}, 1)};
        write_picture(folder.file("m.png"), picture);
        std::vector<std::uint8_t> expected = without_alpha(rgba);
        for (std::size_t y = 0; y < height; ++y) {
            for (std::size_t x = 0; x < width; ++x) {
                std::uint8_t* pixel = &expected[(y * width + x) * 3];
                if (y == 1) {
                    std::copy_n(std::array<std::uint8_t, 3>{1, 2, 3}.begin(), 3, pixel);
                } else if (x == 1) {
                    std::copy_n(std::array<std::uint8_t, 3>{9, 8, 7}.begin(), 3, pixel);
                }
            }
        }
        CHECK(read_back(folder.file("m.png")).values == expected);
        picture.marks[1].points.pop_back();
        CHECK_THROWS_WITH_AS(write_picture(folder.file("m.png"), picture),
                             doctest::Contains("mark 1 (line) has 1 points, needs 2"),
                             PictureError);
        CHECK(files_in(folder.file("")) == 1);
    }

    TEST_CASE("a disk without room is an error, whatever the format, and leaves nothing behind") {
        const TemporaryFolder folder;
        constexpr int side = 256;
        std::vector<std::uint8_t> noise(std::size_t{4} * side * side, 255);
        std::uint32_t state = 1;
        for (std::size_t index = 0; index < noise.size(); ++index) {
            state = state * 1664525 + 1013904223;
            noise[index] =
                index % 4 == 3 ? std::uint8_t{255} : static_cast<std::uint8_t>(state >> 24);
        }
        rlimit before{};
        getrlimit(RLIMIT_FSIZE, &before);
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit small{10'000, before.rlim_max};
        for (const char* suffix : {".png", ".tif", ".exr", ".gif", ".svg", ".pdf"}) {
            CAPTURE(suffix);
            setrlimit(RLIMIT_FSIZE, &small);
            std::string error;
            try {
                write_picture(folder.file(std::string("p") + suffix), {side, side, noise, ""});
            } catch (const PictureError& failure) {
                error = failure.what();
            }
            setrlimit(RLIMIT_FSIZE, &before);
            CHECK(error ==
                  folder.file(std::string("p") + suffix) + ": cannot be written: File too large");
            CHECK(files_in(folder.file("")) == 0);
        }
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
                             doctest::Contains("folder.png: is a folder, not a file: give the name "
                                               "of a file in it"),
                             PictureError);
        CHECK(files_in(inside) == 1);
    }
}
