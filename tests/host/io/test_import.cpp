#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr std::size_t voxels = 4 * 3 * 2;

template <typename T>
std::vector<T> values_of(const Volume& volume) {
    REQUIRE(volume.values.size() % sizeof(T) == 0);
    std::vector<T> values(volume.values.size() / sizeof(T));
    std::memcpy(values.data(), volume.values.data(), volume.values.size());
    return values;
}

/// A 4x3x2 MetaImage with `lines` more in its header, values in the same file.
std::string meta_image(const std::string& type, const std::string& lines, const std::string& data) {
    return "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n" + lines + "ElementType = " + type +
           "\nElementDataFile = LOCAL\n" + data;
}

bool notes_say(const Volume& volume, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(),
                       [&](const Finding& f) { return f.text.find(words) != std::string::npos; });
}

void check_column(const Volume& volume, int column, double x, double y, double z) {
    CAPTURE(column);
    CHECK(volume.voxel_to_patient[column][0] == doctest::Approx(x).epsilon(1e-6));
    CHECK(volume.voxel_to_patient[column][1] == doctest::Approx(y).epsilon(1e-6));
    CHECK(volume.voxel_to_patient[column][2] == doctest::Approx(z).epsilon(1e-6));
}

/// A type that is kept: same values, range, no note of a conversion, in both byte orders.
template <typename T>
void check_kept(const std::string& meta_type, Scalar type) {
    const TemporaryFolder folder;
    const std::vector<T> values = ramp<T>(voxels);
    for (const bool big_endian : {false, true}) {
        CAPTURE(meta_type);
        CAPTURE(big_endian);
        const std::string order = std::string("BinaryDataByteOrderMSB = ") +
                                  (big_endian ? "True\n" : "False\n") +
                                  "ElementSpacing = 1 1 1\nAnatomicalOrientation = RAI\n";
        const Volume volume = import_volume(
            folder.write("kept.mha", meta_image(meta_type, order, bytes_of(values, big_endian))));
        CHECK(volume.type == type);
        CHECK(values_of<T>(volume) == values);
        CHECK(volume.minimum == static_cast<double>(std::numeric_limits<T>::lowest()));
        CHECK(volume.maximum == static_cast<double>(std::numeric_limits<T>::max()));
        CHECK(volume.findings.empty());
    }
}

/// `values` as an NRRD of `nrrd_type`.
template <typename T>
Volume import_nrrd(const std::string& nrrd_type, const std::vector<T>& values) {
    const TemporaryFolder folder;
    return import_volume(folder.write(
        "typed.nrrd", "NRRD0004\ntype: " + nrrd_type +
                          "\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n"
                          "space directions: (1,0,0) (0,1,0) (0,0,1)\nendian: little\n"
                          "encoding: raw\n\n" +
                          bytes_of(values)));
}

}  // namespace

TEST_SUITE("host/io/import") {
    TEST_CASE("uint8, int16, uint16 and float32 are kept, in either byte order") {
        check_kept<std::uint8_t>("MET_UCHAR", Scalar::uint8);
        check_kept<std::int16_t>("MET_SHORT", Scalar::int16);
        check_kept<std::uint16_t>("MET_USHORT", Scalar::uint16);
        check_kept<float>("MET_FLOAT", Scalar::float32);
    }

    TEST_CASE("int8 becomes int16 with the same values and a note") {
        const std::vector<std::int8_t> values = ramp<std::int8_t>(voxels);
        const Volume volume = import_nrrd("int8", values);
        CHECK(volume.type == Scalar::int16);
        CHECK(values_of<std::int16_t>(volume) ==
              std::vector<std::int16_t>(values.begin(), values.end()));
        CHECK(volume.minimum == -128);
        CHECK(volume.maximum == 127);
        CHECK(notes_say(volume, "int8 values are held as int16, without loss"));
    }

    TEST_CASE("wide integers become the narrowest type that holds them all") {
        std::vector<std::int32_t> values(voxels, 5);
        values[3] = -32768;
        values[4] = 32767;
        CHECK(import_nrrd("int32", values).type == Scalar::int16);
        values[3] = 0;
        values[4] = 65535;
        CHECK(import_nrrd("int32", values).type == Scalar::uint16);
        values[4] = 65536;
        CHECK(import_nrrd("int32", values).type == Scalar::float32);
        values = std::vector<std::int32_t>(voxels, 5);
        values[3] = -1;
        values[4] = 32768;
        const Volume mixed = import_nrrd("int32", values);
        CHECK(mixed.type == Scalar::float32);
        CHECK(mixed.maximum == 32768);
        CHECK(import_nrrd("uint32", std::vector<std::uint32_t>(voxels, 65535)).type ==
              Scalar::uint16);
        CHECK(import_nrrd("int64", std::vector<std::int64_t>(voxels, -7)).type == Scalar::int16);
    }

    TEST_CASE("integers beyond 24 bits are rounded to float32, and the note counts them") {
        std::vector<std::int32_t> values(voxels, 5);
        values[0] = (1 << 24) + 1;
        values[1] = 1 << 25;
        const Volume volume = import_nrrd("int32", values);
        CHECK(volume.type == Scalar::float32);
        CHECK(notes_say(volume, "1 of 24 are rounded"));
        CHECK(volume.maximum == 1 << 25);
    }

    TEST_CASE("float64 becomes float32, with a note that says whether it lost something") {
        CHECK(notes_say(import_nrrd("double", std::vector<double>(voxels, 0.5)), "without loss"));
        const Volume tenth = import_nrrd("double", std::vector<double>(voxels, 0.1));
        CHECK(tenth.type == Scalar::float32);
        CHECK(notes_say(tenth, "24 of 24 are rounded"));
        CHECK(tenth.minimum == static_cast<double>(0.1F));
    }

    TEST_CASE("the range leaves out what is not finite, and a note counts it") {
        std::vector<float> values(voxels, 2.5F);
        values[0] = std::numeric_limits<float>::quiet_NaN();
        values[1] = -std::numeric_limits<float>::infinity();
        values[2] = -4;
        const Volume volume = import_nrrd("float", values);
        CHECK(volume.minimum == -4);
        CHECK(volume.maximum == 2.5);
        CHECK(notes_say(volume, "2 of 24 values are not finite"));
    }

    TEST_CASE("a MetaImage's spacing, direction and origin are its place in the patient") {
        const TemporaryFolder folder;
        // Columns: x along +posterior, y along -left, z up, rotated in plane by 90 degrees.
        const Volume volume = import_volume(folder.write(
            "place.mha", meta_image("MET_UCHAR",
                                    "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 -20 30.5\n"
                                    "ElementSpacing = 0.5 2 3.25\n",
                                    std::string(voxels, 'x'))));
        check_column(volume, 0, 0, 0.5, 0);
        check_column(volume, 1, -2, 0, 0);
        check_column(volume, 2, 0, 0, 3.25);
        check_column(volume, 3, 10, -20, 30.5);
        CHECK(volume.nx == 4);
        CHECK(volume.ny == 3);
        CHECK(volume.nz == 2);
        CHECK(volume.name == "place");
        CHECK(volume.findings.size() == 1);
        CHECK(notes_say(volume, "no AnatomicalOrientation"));
    }

    TEST_CASE("an oblique RAS NRRD is turned to LPS, in ascii too") {
        const TemporaryFolder folder;
        std::string text =
            "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 4 3 2\n"
            "space directions: (1.6,1.2,0) (-0.6,0.8,0) (0,0,5)\nspace origin: (7,8,9)\n"
            "encoding: ascii\n\n";
        for (std::size_t index = 0; index < voxels; ++index) {
            text += std::to_string(static_cast<int>(index) - 10) + (index % 4 == 3 ? "\n" : " ");
        }
        const Volume volume = import_volume(folder.write("ras.nrrd", text));
        check_column(volume, 0, -1.6, -1.2, 0);
        check_column(volume, 1, 0.6, -0.8, 0);
        check_column(volume, 2, 0, 0, 5);
        check_column(volume, 3, -7, -8, 9);
        CHECK(values_of<std::int16_t>(volume)[23] == 13);
        CHECK(volume.minimum == -10);
    }

    TEST_CASE("a sheared NRRD keeps its shear and says so") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write(
            "sheared.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n"
            "space directions: (1,0,0) (0,1,0) (0,3,4)\nencoding: raw\n\n" +
                std::string(voxels, 'x')));
        check_column(volume, 2, 0, 3, 4);
        // cos = 3/5 between y and z.
        CHECK(notes_say(volume, "the y and z axes meet at 53.13 degrees"));
    }

    TEST_CASE("a reflection is kept and noted") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write(
            "mirror.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n"
            "space directions: (1,0,0) (0,1,0) (0,0,-2)\nencoding: raw\n\n" +
                std::string(voxels, 'x')));
        check_column(volume, 2, 0, 0, -2);
        CHECK(notes_say(volume, "left-handed"));
    }

    TEST_CASE("a file that states no spacing is read with a note, never in silence") {
        const TemporaryFolder folder;
        CHECK(notes_say(import_volume(folder.write(
                            "bare.mha", meta_image("MET_UCHAR", "", std::string(voxels, 'x')))),
                        "does not state its spacing"));
        CHECK(notes_say(
            import_volume(folder.write("bare.nrrd",
                                       "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\n"
                                       "encoding: raw\n\n" +
                                           std::string(voxels, 'x'))),
            "does not state its spacing"));
    }

    TEST_CASE("a NIfTI sform in RAS becomes LPS, in either byte order") {
        const TemporaryFolder folder;
        const std::vector<std::int16_t> values = ramp<std::int16_t>(voxels);
        for (const bool big_endian : {false, true}) {
            CAPTURE(big_endian);
            NiftiHeader header(big_endian);
            header.put<float>(80, 2.0F).put<float>(84, 3.0F).put<float>(88, 4.0F);
            header.put_sform({{{-2, 0, 0, 50}, {0, 0, -4, 60}, {0, 3, 0, 70}}});
            const Volume volume = import_volume(
                folder.write("order.nii", header.bytes() + bytes_of(values, big_endian)));
            check_column(volume, 0, 2, 0, 0);
            check_column(volume, 1, 0, 0, 3);
            check_column(volume, 2, 0, 4, 0);
            check_column(volume, 3, -50, -60, 70);
            CHECK(values_of<std::int16_t>(volume) == values);
        }
    }

    TEST_CASE("NIfTI slope and intercept are applied, and whole results stay integers") {
        const TemporaryFolder folder;
        std::vector<std::int16_t> values(voxels, 100);
        values[0] = 0;
        NiftiHeader shifted;
        shifted.put<float>(112, 1.0F).put<float>(116, -1024.0F);
        const Volume hounsfield =
            import_volume(folder.write("ct.nii", shifted.bytes() + bytes_of(values)));
        CHECK(hounsfield.type == Scalar::int16);
        CHECK(hounsfield.minimum == -1024);
        CHECK(hounsfield.maximum == -924);
        NiftiHeader scaled;
        scaled.put<float>(112, 0.125F).put<float>(116, 1.0F);
        const Volume fractions =
            import_volume(folder.write("scaled.nii", scaled.bytes() + bytes_of(values)));
        CHECK(fractions.type == Scalar::float32);
        CHECK(fractions.maximum == 13.5);
        CHECK(notes_say(fractions, "scaled by 0.125 and shifted by 1"));
    }

    TEST_CASE("a structured-points VTK file in big-endian binary is read") {
        const TemporaryFolder folder;
        const std::vector<float> values = {1.5F, -2.5F, 3, 4, 5, 6, 7, 8};
        const Volume volume = import_volume(folder.write(
            "cube.vtk",
            "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\n"
            "DIMENSIONS 2 2 2\nSPACING 1 2 3\nORIGIN 4 5 6\nPOINT_DATA 8\nSCALARS s float 1\n"
            "LOOKUP_TABLE default\n" +
                bytes_of(values, true)));
        CHECK(values_of<float>(volume) == values);
        check_column(volume, 1, 0, 2, 0);
        check_column(volume, 3, 4, 5, 6);
    }

    TEST_CASE("slices in numbered files are read in their order") {
        const TemporaryFolder folder;
        folder.write("s01.raw", std::string(12, 'a'));
        folder.write("s02.raw", std::string(12, 'b'));
        const std::string values = std::string(12, 'a') + std::string(12, 'b');
        const Volume meta = import_volume(
            folder.write("s.mhd",
                         "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\n"
                         "ElementType = MET_UCHAR\nElementDataFile = s%02d.raw 1 2 1\n"));
        CHECK(std::memcmp(meta.values.data(), values.data(), values.size()) == 0);
        const Volume nrrd = import_volume(
            folder.write("s.nhdr",
                         "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\n"
                         "encoding: raw\ndata file: s%02d.raw 1 2 1\n"));
        CHECK(nrrd.values == meta.values);
    }

    TEST_CASE("the suffix may be missing if the first bytes say the format") {
        const TemporaryFolder folder;
        const Volume volume =
            import_volume(folder.write("no_suffix",
                                       "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\n"
                                       "spacings: 1 1 2\nencoding: raw\n\n" +
                                           std::string(voxels, 'x')));
        CHECK(volume.nx == 4);
        CHECK(volume.name == "no_suffix");
    }
}
