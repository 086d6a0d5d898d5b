// The text of `info` on built files that are odd in one way each, held as a golden: what a reader
// of the text is told about the file.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <limits>
#include <optional>

#include "tests/golden.hpp"
#include "tests/host/commands/info_text.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;

namespace fs = std::filesystem;

namespace {

Grid cube() {
    return {{4, 3, 2}, glm::dmat4(1.0), ramp<std::int16_t>(24)};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

/// The texts of files that a case builds, one after another.
class Texts {
  public:
    void add(const std::string& name, const std::string& bytes) {
        all_ += info(folder_.write(name, bytes), folder_.file(""));
    }
    void add_raw(const std::string& name, const std::string& bytes, const std::string& orientation,
                 std::optional<glm::dvec3> origin_mm) {
        io::ImportRequest request;
        request.path = folder_.write(name, bytes);
        request.raw = io::RawLayout{{4, 3, 2}, "int16"};
        request.spacing_mm = glm::dvec3(0.5, 1, 2);
        request.orientation = orientation;
        request.origin_mm = origin_mm;
        all_ += info(request, folder_.file(""));
    }
    /// Slices of a series in a folder of that name.
    void add_series(const std::string& name, const std::vector<std::string>& slices) {
        fs::create_directory(folder_.file(name));
        for (std::size_t i = 0; i < slices.size(); ++i) {
            folder_.write(fmt::format("{}/s{:02}", name, i), slices[i]);
        }
        all_ += info(folder_.file(name), folder_.file(""));
    }
    const TemporaryFolder& folder() const { return folder_; }
    const std::string& all() const { return all_; }

  private:
    TemporaryFolder folder_;
    std::string all_;
};

DicomSet slice_at(double z_mm, double thickness_mm = 1) {
    DicomSet set = dicom_image(4, 3, bytes_of(ramp<std::int16_t>(12)));
    dicom_place(set, {-10, 20, z_mm}, {1, 0, 0}, {0, 1, 0}, 0.5, 0.5);
    return set.text(0x18, 0x50, "DS", dicom_numbers({thickness_mm}));
}

DicomSet image() {
    return dicom_image(4, 4, std::string(32, '\1'));
}

DicomSet frames(std::uint16_t pointer) {
    DicomSet set = dicom_image(4, 4, std::string(96, '\1'));
    set.text(8, 0x60, "CS", "US").text(0x28, 8, "IS", "3").text(0x28, 0x30, "DS", "1\\1");
    return set.put(0x28, 9, "AT", bytes_of(std::uint16_t{0x18}) + bytes_of(pointer));
}

void add_dicom(Texts& texts) {
    texts.add_series("slices_of_two_thicknesses",
                     {slice_at(0, 1).file(), slice_at(1, 1).file(), slice_at(2, 1).file(),
                      slice_at(4.5, 4).file(), slice_at(8.5, 4).file(), slice_at(12.5, 4).file()});
    texts.add_series("a_slice_is_missing",
                     {slice_at(0).file(), slice_at(1).file(), slice_at(2).file(),
                      slice_at(4).file(), slice_at(5).file()});
    const std::string whole = slice_at(3).file();
    texts.add_series("a_file_is_cut", {slice_at(0).file(), slice_at(1).file(), slice_at(2).file(),
                                       whole.substr(0, whole.size() - 10)});
    std::vector<std::string> tilted;
    for (const double z : {0., 1., 2.}) {
        DicomSet set = slice_at(z);
        tilted.push_back(
            dicom_place(set, {-10, 20 + 0.1 * z, z}, {1, 0, 0}, {0, 1, 0}, 0.5, 0.5).file());
    }
    texts.add_series("tilted_ct", tilted);
    std::vector<std::string> sideways;
    for (const double x : {0., 0.2, -0.1}) {
        DicomSet set = slice_at(0);
        sideways.push_back(dicom_place(set, {x - 10, 20, static_cast<double>(sideways.size())},
                                       {1, 0, 0}, {0, 1, 0}, 0.5, 0.5)
                               .file());
    }
    texts.add_series("slices_step_sideways", sideways);
    texts.add_series(
        "two_series",
        {slice_at(0).text(0x20, 0x11, "IS", "3").file(),
         slice_at(1).text(0x20, 0x11, "IS", "3").file(),
         slice_at(0).text(0x20, 0xe, "UI", "1.2.9").text(0x20, 0x11, "IS", "7").file(),
         slice_at(1).text(0x20, 0xe, "UI", "1.2.9").text(0x20, 0x11, "IS", "7").file()});
    texts.add("mosaic.dcm", mosaic().file());
    texts.add("mosaic_without_csa.dcm",
              image().text(8, 8, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC").file());
    texts.add("cine.dcm", frames(0x1063).text(0x18, 0x1063, "DS", "33.3").file());
    texts.add("frames_without_places.dcm", frames(0x80).file());
    texts.add("segmentation.dcm", image()
                                      .text(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
                                      .text(8, 0x60, "CS", "SEG")
                                      .file());
    texts.add("float_map.dcm",
              image().remove(0x7fe0, 0x10).put(0x7fe0, 8, "OF", std::string(64, '\0')).file());
    texts.add("no_rows.dcm", image().number(0x28, 0x10, 0).file());
    texts.add("rgb.dcm", image()
                             .number(0x28, 2, 3)
                             .text(0x28, 4, "CS", "RGB")
                             .put(0x7fe0, 0x10, "OW", std::string(96, 'x'))
                             .file());
    texts.add("DICOMDIR", DicomSet().sequence(4, 0x1220, {}).file());
}

void add_stored(Texts& texts) {
    const std::string nrrd = nrrd_file(cube()), vtk = vtk_file(cube());
    const auto meta = [](const std::string& orientation) {
        return "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n" +
               orientation + "ElementDataFile = LOCAL\n" + std::string(24, 'x');
    };
    texts.add("unknown_orientation.mha", meta("AnatomicalOrientation = ???\n"));
    texts.add("stated_orientation.mha", meta("AnatomicalOrientation = RAI\n"));
    NiftiHeader unitless = nifti1_header(cube()), bits = nifti1_header(cube());
    unitless.put<char>(123, 0);
    texts.add("no_unit.nii", unitless.bytes() + bytes_of(cube().values));
    bits.put<std::int16_t>(72, 8);
    texts.add("wrong_bitpix.nii", bits.bytes() + bytes_of(cube().values));
    NiftiHeader no_slope = nifti1_header(cube());
    no_slope.put<float>(112, std::numeric_limits<float>::quiet_NaN());
    texts.add("slope_is_nan.nii", no_slope.bytes() + bytes_of(cube().values));
    const std::string packed = gzipped(texts.folder(), nifti1_file(cube()));
    texts.add("words_behind.nii.gz", packed + "trailing words");
    texts.add("broken.nii.gz", packed.substr(0, packed.size() - 12) + std::string(12, 'x'));
    texts.add("point_data.vtk", replaced(vtk, "POINT_DATA 24", "POINT_DATA 25"));
    texts.add("bits.vtk", replaced(vtk, "short", "bit"));
    texts.add("text.nrrd",
              "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nencoding: ascii\n\n"
              "1 2 3 4 5\n");
    texts.add("cube.nrrd", nrrd);
    texts.add("cube.raw.gz", gzipped(texts.folder(), bytes_of(cube().values)));
    texts.add("cube.xyz", "no volume");
    texts.add_raw("cube.bin", bytes_of(cube().values), "", {});
    texts.add_raw("cube.bin", bytes_of(cube().values), "RAI", glm::dvec3(10, -20.5, 30));
    texts.add_raw("cube.bin", bytes_of(cube().values), "PIL", {});
    texts.add_raw("cube.bin", bytes_of(cube().values), "RAX", {});
}

}  // namespace

TEST_SUITE("host/commands/info_golden") {
    TEST_CASE("info on built files, each odd in one way") {
        Texts texts;
        add_dicom(texts);
        add_stored(texts);
        check_golden("info_built.txt", texts.all(), "ctest --preset release -R host_info_golden");
    }
}
