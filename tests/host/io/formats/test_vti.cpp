// VTK XML image data.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "host/io/import.hpp"
#include "tests/host/io/formats/vti_writer.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// Turned by a quarter about z, with three spacings.
Grid turned_grid() {
    Grid grid{{6, 5, 4}, glm::dmat4(1.0), ramp<std::int16_t>(120)};
    grid.affine[0] = {0, 0.5, 0, 0};
    grid.affine[1] = {-1.5, 0, 0, 0};
    grid.affine[2] = {0, 0, 2, 0};
    grid.affine[3] = {10, -20, 30, 1};
    return grid;
}

std::string changed(std::string file, const std::string& from, const std::string& to) {
    const std::size_t at = file.find(from);
    REQUIRE(at != std::string::npos);
    return file.replace(at, from.size(), to);
}

std::string refusal(const std::string& bytes) {
    const TemporaryFolder folder;
    try {
        import_volume(folder.write("v.vti", bytes));
        return "none";
    } catch (const ImportError& error) {
        const std::string text = error.what();
        return text.substr(text.find(": ") + 2);
    }
}

void check_is_grid(const Volume& volume) {
    CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{6, 5, 4});
    REQUIRE(volume.type == Scalar::int16);
    CHECK(std::memcmp(volume.values.data(), turned_grid().values.data(), 240) == 0);
    for (int column = 0; column < 4; ++column) {
        CHECK(glm::length(volume.voxel_to_patient[column] - turned_grid().affine[column]) < 1e-12);
    }
}

}  // namespace

TEST_SUITE("host/io/vti") {
    TEST_CASE("text, base64 and appended bytes, in zlib or not, of both byte orders") {
        for (const auto& [name, form] : vti_forms()) {
            CAPTURE(name);
            const TemporaryFolder folder;
            const Volume volume =
                import_volume(folder.write("v.vti", vti_file(turned_grid(), form)));
            check_is_grid(volume);
            REQUIRE(volume.findings.size() == 1);
            CHECK(volume.findings[0].text.starts_with("VTK files state no patient space"));
        }
    }

    TEST_CASE("GPs read appended raw bytes themselves, and nothing else") {
        for (const auto& [name, form] : vti_forms()) {
            CAPTURE(name);
            const TemporaryFolder folder;
            ImportRequest request;
            request.path = folder.write("v.vti", vti_file(turned_grid(), form));
            request.read = ReadBy::gps;
            if (name.starts_with("raw-plain")) {
                const Volume volume = import_volume(request);
                check_is_grid(volume);
                CHECK(volume.stored.has_value());
            } else {
                CHECK_THROWS_WITH_AS(import_volume(request),
                                     doctest::Contains("GPs cannot read the values"), ImportError);
            }
        }
    }

    TEST_CASE("blocks that divide the values, of one byte, and larger than all values") {
        for (const std::size_t block_bytes : {1, 60, 240, 1000}) {
            for (const char* encoding : {"raw", "base64"}) {
                CAPTURE(block_bytes);
                const TemporaryFolder folder;
                const VtiForm form{"appended", encoding, true, true, false, block_bytes};
                check_is_grid(import_volume(folder.write("v.vti", vti_file(turned_grid(), form))));
            }
        }
    }

    TEST_CASE("a file without its suffix, and orientation= needs axes that are not turned") {
        const TemporaryFolder folder;
        ImportRequest request;
        request.path = folder.write("volume", vti_file(turned_grid()));
        request.orientation = "RAS";
        CHECK_THROWS_WITH_AS(
            import_volume(request),
            doctest::Contains("Direction is ' 0 -1 0 1 0 0 0 0 1', so its axes are not x, y, z"),
            ImportError);
        Grid grid = turned_grid();
        grid.affine = glm::dmat4(1.0);
        folder.write("volume", vti_file(grid));
        CHECK(import_volume(request).voxel_to_patient[0] == glm::dvec4(-1, 0, 0, 0));
    }

    TEST_CASE("files that VTK 9.1 wrote, in each of its forms") {
        for (const char* name : {"ascii", "ascii-zlib", "binary", "binary-zlib", "appended",
                                 "appended-zlib", "appended-base64", "appended-zlib-base64"}) {
            CAPTURE(name);
            check_is_grid(import_volume(fmt::format("{}/{}.vti", PXPL5_VTI_FOLDER, name)));
        }
    }

    TEST_CASE("without a name of the scalars, the first array is taken") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(
            folder.write("v.vti", changed(vti_file(turned_grid()), " Scalars=\"density\"", "")));
        const std::vector<std::int16_t> values = turned_grid().values;
        const std::vector<std::int16_t> others(values.rbegin(), values.rend());
        CHECK(std::memcmp(volume.values.data(), others.data(), 240) == 0);
    }

    TEST_CASE("what is not a volume is refused, with the attribute and its value") {
        const std::string file = vti_file(turned_grid());
        const auto with = [&](const std::string& from, const std::string& to) {
            return refusal(changed(file, from, to));
        };
        CHECK(with("type=\"ImageData\"", "type=\"PolyData\"") ==
              "is VTK's 'PolyData', must be ImageData");
        CHECK(with("\"density\"", "\"T2\"") ==
              "Scalars is 'T2', but the arrays of PointData are before, density, after");
        CHECK(with("WholeExtent=\" 2", "WholeExtent=\" 1") ==
              "its first piece is  2 7 -1 3 3 6, must be the WholeExtent,  1 7 -1 3 3 6");
        CHECK(with("UInt64", "Int7") == "header_type is 'Int7', must be one of: UInt32, UInt64");
        CHECK(with("Name=\"density\"", "Name=\"density\" NumberOfComponents=\"3\"") ==
              "its array has 3 components, a volume has 1");
        CHECK(with("type=\"Int16\" Name=\"density\"", "type=\"String\" Name=\"density\"") ==
              "the type of its array is 'String', must be Int8, UInt8, ..., Int64, UInt64, "
              "Float32 or Float64");
        CHECK(with("header_type", "compressor=\"vtkLZ4DataCompressor\" header_type") ==
              "compressor is 'vtkLZ4DataCompressor', must be one of: , vtkZLibDataCompressor");
        CHECK(with("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>") ==
              "has a document type, which is not read");
        CHECK(with("</PointData>", "</Points>") == "is no XML at line 9: mismatched tag");
        CHECK(refusal(changed(changed(file, "<PointData", "<CellData"), "</PointData",
                              "</CellData")) == "has no array of PointData; CellData are not read");
        CHECK(refusal(file.substr(0, file.find("<AppendedData")) + "</VTKFile>") ==
              "its array is 'appended', but it has no AppendedData");
    }

    TEST_CASE("blocks that zlib makes larger than their values") {
        const Grid small{{2, 2, 1}, glm::dmat4(1.0), ramp<std::int16_t>(4)};
        for (const char* encoding : {"raw", "base64"}) {
            const TemporaryFolder folder;
            const VtiForm form{"appended", encoding, true, true, false, 8};
            const Volume volume = import_volume(folder.write("v.vti", vti_file(small, form)));
            REQUIRE(volume.values.size() == 8);
            CHECK(std::memcmp(volume.values.data(), small.values.data(), 8) == 0);
        }
    }

    TEST_CASE("only in XML, a '<' ends the values") {
        const TemporaryFolder folder;
        CHECK_THROWS_WITH_AS(
            import_volume(folder.write("v.nrrd",
                                       "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\n"
                                       "encoding: ascii\n\n1 2 3 12<5\n")),
            doctest::Contains("value 3 is '12<5', must be a number"), ImportError);
    }

    TEST_CASE("spacing= is refused if the index does not begin at 0: the origin would move") {
        const TemporaryFolder folder;
        ImportRequest request;
        request.path = folder.write("v.vti", changed(vti_file(turned_grid()), "Spacing", "Other"));
        request.spacing_mm = glm::dvec3(1, 2, 3);
        CHECK_THROWS_AS(import_volume(request), ImportError);
    }

    TEST_CASE("values that are too few, too many or damaged are refused, with both numbers") {
        const std::string file = vti_file(turned_grid());
        const auto with = [&](const std::string& text, const std::string& from,
                              const std::string& to) { return refusal(changed(text, from, to)); };
        CHECK(with(changed(file, " 2 7 ", " 2 8 "), " 2 7 ", " 2 8 ") ==
              "7x5x4 of Int16 need 280 bytes, its array has 240");
        CHECK(with(file, "offset=\"248\"", "offset=\"99999\"") ==
              "its values begin 99999 bytes behind the '_' of AppendedData, which is behind the "
              "end of the file");
        const std::size_t begin = file.find('_', file.find("<AppendedData"));
        CHECK(refusal(file.substr(0, begin + 300)) ==
              "6x5x4 of Int16 need 240 bytes, v.vti has 43");
        const VtiForm zlib{"appended", "raw", true, true, false, 100};
        std::string packed = vti_file(turned_grid(), zlib);
        const std::size_t second = packed.find("offset=\"", packed.find("Name=\"density\"")) + 8;
        const std::size_t at = packed.find('_', packed.find("<AppendedData")) + 1 +
                               std::stoul(packed.substr(second)) + 6 * 8 + 20;
        packed[at] = static_cast<char>(~packed[at]);
        CHECK(refusal(packed).starts_with(
            "6x5x4 of Int16 need 240 bytes when decompressed, v.vti has "));
        CHECK(refusal(packed).find("; its compressed data are broken at byte ") !=
              std::string::npos);
        const VtiForm blocks{"appended", "raw", true, true, false, 240};
        std::string larger = vti_file(turned_grid(), blocks);
        for (const char* extent : {" 2 7 ", " 2 7 "}) {
            larger = changed(larger, extent, " 2 6 ");
        }
        CHECK(refusal(larger) == "5x5x4 of Int16 need 200 bytes, its array has 240");
        std::string longer = vti_file(turned_grid(), {"ascii", ""});
        for (const char* extent : {" 2 7 ", " 2 7 "}) {
            longer = changed(longer, extent, " 2 6 ");
        }
        CHECK(refusal(longer) == "has more than the 100 values that its header states");
        CHECK(with(file, " offset=\"248\"", "") ==
              "the offset of its array is '', must be a number");
        const VtiForm text{"ascii", ""};
        CHECK(with(vti_file(turned_grid(), text), "Name=\"density\" format=\"ascii\">",
                   "Name=\"density\" format=\"ascii\">1 2</DataArray><DataArray>") ==
              "has 2 values, its header states 120");
    }
}
