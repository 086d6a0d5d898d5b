#include <OpenImageIO/imageio.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

#include "host/io/formats/picture_stack.hpp"
#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr int width = 5, height = 4;

std::vector<std::uint16_t> page(int index) {
    std::vector<std::uint16_t> values(width * height);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = static_cast<std::uint16_t>(1000 * index + static_cast<int>(i));
    }
    return values;
}

void write_page(const std::string& path, const std::vector<std::uint16_t>& values, int columns,
                int channels = 1, bool append = false) {
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output);
    const OIIO::ImageSpec spec(columns, height, channels, OIIO::TypeDesc::UINT16);
    REQUIRE(output->open(path, spec,
                         append ? OIIO::ImageOutput::AppendSubimage : OIIO::ImageOutput::Create));
    REQUIRE(output->write_image(OIIO::TypeDesc::UINT16, values.data()));
    output->close();
}

ImportRequest request_of(const std::string& path) {
    ImportRequest request;
    request.path = path;
    request.spacing_mm = glm::dvec3(0.5, 0.5, 2);
    return request;
}

void check_pages(const Volume& volume, int count) {
    CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{width, height, count});
    REQUIRE(volume.type == Scalar::uint16);
    std::vector<std::uint16_t> want;
    for (int z = 0; z < count; ++z) {
        const std::vector<std::uint16_t> next = page(z);
        want.insert(want.end(), next.begin(), next.end());
    }
    CHECK(std::memcmp(volume.values.data(), want.data(), volume.values.size()) == 0);
    CHECK(volume.voxel_to_patient[2].z == 2);
}

}  // namespace

TEST_SUITE("host/io/picture_stack") {
    TEST_CASE("numbers in names count as numbers") {
        CHECK(is_naturally_before("s2.png", "s10.png"));
        CHECK(!is_naturally_before("s10.png", "s2.png"));
        CHECK(is_naturally_before("s002.png", "s10.png"));
        CHECK(is_naturally_before("a1b2", "a1b11"));
        CHECK(is_naturally_before("a", "a1"));
        CHECK(!is_naturally_before("a1", "a1"));
        CHECK((is_naturally_before("a01", "a1") || is_naturally_before("a1", "a01")));
    }

    TEST_CASE("a folder of numbered pictures is a volume in the order of their numbers") {
        for (const char* suffix : {".png", ".tif"}) {
            const TemporaryFolder folder;
            for (int z = 0; z < 11; ++z) {
                write_page(folder.file("s" + std::to_string(z) + suffix), page(z), width);
            }
            folder.write("readme.txt", "words");
            const Volume volume = import_volume(request_of(folder.file("")));
            check_pages(volume, 11);
            CHECK(std::any_of(volume.findings.begin(), volume.findings.end(), [](const Finding& f) {
                return f.text == "1 file is not a picture and is left out";
            }));
        }
    }

    TEST_CASE("a TIFF of many pages is a volume") {
        const TemporaryFolder folder;
        const std::string path = folder.file("stack.tif");
        const auto output = OIIO::ImageOutput::create(path);
        const OIIO::ImageSpec spec(width, height, 1, OIIO::TypeDesc::UINT16);
        const std::vector<OIIO::ImageSpec> specs(3, spec);
        REQUIRE(output->open(path, 3, specs.data()));
        for (int z = 0; z < 3; ++z) {
            if (z > 0) {
                REQUIRE(output->open(path, spec, OIIO::ImageOutput::AppendSubimage));
            }
            REQUIRE(output->write_image(OIIO::TypeDesc::UINT16, page(z).data()));
        }
        output->close();
        check_pages(import_volume(request_of(path)), 3);
    }

    TEST_CASE("a folder of BMP pictures is exact, one of JPEG pictures is nearly, and says so") {
        const auto read = [](const char* suffix) {
            const TemporaryFolder folder;
            for (int z = 0; z < 3; ++z) {
                const std::vector<std::uint8_t> level(width * height,
                                                      static_cast<std::uint8_t>(50 * z));
                const std::string path = folder.file("s" + std::to_string(z) + suffix);
                const auto output = OIIO::ImageOutput::create(path);
                REQUIRE(output);
                REQUIRE(
                    output->open(path, OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::UINT8)));
                REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, level.data()));
                output->close();
            }
            // A preview beside the slices is of another kind.
            if (suffix == std::string(".bmp")) {
                folder.write("preview.jpg", "not read");
            }
            folder.write("readme.txt", "words");
            return import_volume(request_of(folder.file("")));
        };
        const auto is_lossy = [](const Finding& finding) {
            return finding.text ==
                   "3 of 3 pictures were compressed with loss (JPEG): their values are not exact";
        };
        for (const char* suffix : {".bmp", ".jpg", ".JPEG"}) {
            CAPTURE(suffix);
            const Volume volume = read(suffix);
            CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{width, height, 3});
            REQUIRE(volume.type == Scalar::uint8);
            for (std::size_t i = 0; i < volume.values.size(); ++i) {
                const int level = 50 * static_cast<int>(i / (width * height));
                CHECK(std::abs(std::to_integer<int>(volume.values[i]) - level) <=
                      (suffix == std::string(".bmp") ? 0 : 2));
            }
            CHECK(std::ranges::count_if(volume.findings, is_lossy) ==
                  (suffix == std::string(".bmp") ? 0 : 1));
            CHECK(std::ranges::any_of(volume.findings, [](const Finding& finding) {
                return finding.text == "1 file is not a picture and is left out";
            }));
            CHECK(std::ranges::count(volume.findings,
                                     "1 of 4 pictures are of another kind and left out",
                                     &Finding::text) == (suffix == std::string(".bmp") ? 1 : 0));
        }
    }

    TEST_CASE("without spacing, in color, of two sizes or broken, pictures are refused by name") {
        const TemporaryFolder folder;
        write_page(folder.file("a.png"), page(0), width);
        ImportRequest request = request_of(folder.file(""));
        request.spacing_mm.reset();
        CHECK_THROWS_WITH_AS(import_volume(request),
                             doctest::Contains("give spacing=x,y,z in millimeters"), ImportError);
        std::vector<std::uint16_t> wide(2 * width * height, 7);
        write_page(folder.file("b.png"), wide, 2 * width);
        CHECK_THROWS_WITH_AS(
            import_volume(request_of(folder.file(""))),
            doctest::Contains("b.png: page 1 is 10x4 of uint16, those before are 5x4 of uint16"),
            ImportError);
        std::filesystem::remove(folder.file("b.png"));
        write_page(folder.file("c.png"), std::vector<std::uint16_t>(3 * width * height, 7), width,
                   3);
        CHECK_THROWS_WITH_AS(import_volume(request_of(folder.file("c.png"))),
                             doctest::Contains("c.png: has 3 channels"), ImportError);
        CHECK_THROWS_WITH_AS(import_volume(request_of(folder.write("d.png", "no picture"))),
                             doctest::Contains("d.png: "), ImportError);
    }

    TEST_CASE("a file that changes after its pages were counted is refused") {
        const TemporaryFolder folder;
        const std::string first = folder.file("s0.tif"), second = folder.file("s1.tif");
        const auto write_both = [&] {
            for (const std::string& path : {first, second}) {
                write_page(path, page(0), width);
                write_page(path, page(1), width, 1, true);
            }
        };
        const auto refusal = [&](const std::function<void()>& change) {
            write_both();
            const PicturePages pages("stack", {first, second});
            CHECK(pages.count() == 4);
            change();
            const std::size_t counted = std::size_t{width} * height * pages.count();
            ValueSink sink(counted);
            try {
                pages.read(sink);
            } catch (const ImportError& refused) {
                CHECK(sink.count() <= counted);
                return std::string(refused.what());
            }
            return std::string("nothing");
        };
        const std::string end =
            ": the file has changed while it was read. Read the file again when it is complete";
        CHECK(refusal([&] { write_page(second, std::vector<std::uint16_t>(4000), 1000); }) ==
              second + ": page 1 is 1000x4 of uint16, was 5x4 of uint16" + end);
        CHECK(refusal([&] { write_page(first, std::vector<std::uint16_t>(16), 4); }) ==
              first + ": page 1 is 4x4 of uint16, was 5x4 of uint16" + end);
        CHECK(refusal([&] { write_page(first, page(2), width, 1, true); }) ==
              first + ": has more pages than before, 2" + end);
        CHECK(refusal([&] { write_page(second, page(0), width); }) ==
              second + ": has fewer pages than before, 1 of 2" + end);
        CHECK(refusal([] {}) == "nothing");
    }
}
