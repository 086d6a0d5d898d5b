// Every file of the data folder, held against its README.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "host/io/import.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

const std::string data_folder = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/";

/// A row of the data folder's README. `axes`: where x, y and z point to in the patient.
struct Row {
    const char* path;
    int nx, ny, nz;
    glm::dvec3 spacing_mm;
    Scalar type;
    double minimum, maximum;
    const char* axes;
};

using enum Scalar;

const Row volumes[] = {
    {"ct/torso_3mm.nii.gz", 122, 101, 112, {3, 3, 3}, int16, -1207, 3382, "RAS"},
    {"ct/pelvis_128x128x56.nrrd", 128, 128, 56, {2.859, 2.367, 3}, int16, -1207, 3382, "LPS"},
    {"ct/knee_dicom", 134, 162, 49, {0.977, 0.977, 3.27}, int16, -1000, 1494, "LPS"},
    {"ct/knee_128x128x56.nrrd", 128, 128, 56, {1.022, 1.236, 2.861}, int16, -1000, 1494, "LPS"},
    {"ct/abdomen_j2k_dicom", 512, 512, 20, {0.977, 0.977, 2}, int16, -1024, 1839, "LPS"},
    {"ct/phantom_head_tilt_dicom", 128, 128, 58, {1.625, 1.625, 2.5}, int16, -1024, 771, "LPS"},
    {"ct/phantom_head_oblique.nii.gz", 175, 248, 58, {0.813, 0.813, 2.397}, uint8, 0, 255, "RAS"},
    {"ct/headsq.nhdr", 64, 64, 93, {3.2, 3.2, 1.5}, int16, 0, 3926, "LPS"},
    {"ct/headsq_msb.mhd", 64, 64, 93, {3.2, 3.2, 1.5}, int16, 0, 3926, "LPS"},
    {"mr/head_t1.nii.gz", 160, 232, 160, {1, 0.898, 0.898}, float32, 0, 512, "RAS"},
    {"mr/head_96x96x109.mha", 96, 96, 109, {1.667, 2.171, 1.319}, int16, 0, 512, "LPS"},
    {"mr/head_unc_128x128x84.mhd", 128, 128, 84, {1.8, 1.8, 1.8}, uint8, 0, 202, "LPS"},
    {"mr/head_unc_64_analyze.hdr", 64, 64, 42, {3.6, 3.6, 3.6}, int16, 0, 15100, "LPS"},
    {"mr/head_unc_32_ascii.vtk", 32, 32, 21, {7.2, 7.2, 7.2}, uint8, 0, 154, "LPS"},
    {"mr/carotid.vtk", 76, 49, 45, {1, 1, 1}, float32, 0, 580, "LPS"},
    {"us/spine_phantom.mha", 147, 106, 104, {0.5, 0.5, 0.5}, uint8, 0, 251, "LPS"},
    {"us/spine_phantom_128x64x96.nrrd", 128, 64, 96, {0.574, 0.828, 0.542}, uint8, 0, 251, "LPS"},
    {"us/ball_phantom.nii.gz", 78, 79, 95, {0.5, 0.5, 0.5}, uint8, 0, 255, "RAS"},
};

// Ranges of the NIfTI files are those that their test suite's own reader finds, or are not known.
const Row variants[] = {
    {"dicom_multiframe/emri_small.dcm", 64, 64, 10, {1, 1, 1.2}, uint16, 0, 467, "LPS"},
    {"dicom_multiframe/emri_small_RLE.dcm", 64, 64, 10, {1, 1, 1.2}, uint16, 0, 467, "LPS"},
    {"dicom_multiframe/emri_small_jpeg_2k_lossless.dcm",
     64,
     64,
     10,
     {1, 1, 1.2},
     uint16,
     0,
     467,
     "LPS"},
    {"nifti_variants/avg152T1_LR_nifti.nii.gz", 91, 109, 91, {2, 2, 2}, uint8, 0, 255, "LAS"},
    {"nifti_variants/avg152T1_LR_nifti2.nii.gz", 91, 109, 91, {2, 2, 2}, float32, 0, 255, "LAS"},
    {"nifti_variants/big.nii.gz", 64, 64, 21, {4, 4, 6}, float32, NAN, NAN, "LAS"},
    {"nifti_variants/little.nii.gz", 64, 64, 21, {4, 4, 6}, float32, NAN, NAN, "LAS"},
    // Its name says where its axes point to.
    {"nifti_variants/air.hdr.gz", 79, 67, 64, {2.39, 2.366, 2.385}, float32, NAN, NAN, "AIR"},
    {"nifti_variants/air.img.gz", 79, 67, 64, {2.39, 2.366, 2.385}, float32, NAN, NAN, "AIR"},
    {"nifti_variants/with_extension.nii.gz", 161, 191, 151, {1, 1, 1}, uint8, 0, 1, "LPI"},
    {"nrrd_variants/test2d_ascii.nrrd", 3, 9, 1, {1.046, 2, 1}, uint16, 1, 27, "LPS"},
};

struct Refused {
    const char* path;
    const char* words;  ///< Field and value, or both sizes.
};

const Refused refused_variants[] = {
    {"nifti_variants/5D_small.nii", "has 5 axes (1x2x3x1x3), a volume has 3"},
    {"nrrd_variants/test1d_ascii.nrrd", "has 1 axes (27), a volume has 3"},
    {"nrrd_variants/test_customFields.nrrd", "has 1 axes (27), a volume has 3"},
    {"nrrd_variants/test_simple4d_raw.nrrd", "1 voxels along x, must be 2 to 4096"},
    {"nrrd_variants/BallBinary30x30x30_byteskip_minus_five.nhdr", "byte skip is -5"},
};

const Refused malformed[] = {
    {"dcm_MR_truncated.dcm",
     "pixel data (7fe0,0010) have 8130 bytes, 64x64x1 of 2 bytes need 8192"},
    {"dcm_badVR.dcm", "(0028,0008) is '1A', must be a number"},
    {"dcm_no_meta.dcm", "'DICM' and an element must follow byte 128"},
    {"dcm_preamble_only.dcm", "'DICM' and an element must follow byte 128"},
    {"dcm_text_not_dicom.dcm", "'DICM' and an element must follow byte 128"},
    {"mhd_missing_raw.mhd", "not_here.raw cannot be read: No such file or directory"},
    {"mhd_no_element_type.mhd", "its header has no 'ElementType'"},
    {"mhd_short_raw.mhd", "16x16x16 of MET_SHORT need 8192 bytes, short.raw has 100"},
    {"nii_bad_magic.nii", "magic is 'abc', must be 'n+1' or 'n+2'"},
    {"nii_data_cut.nii", "16x16x16 of int16 need 8192 bytes, nii_data_cut.nii has 3000"},
    {"nii_dim_huge.nii", "32767 voxels along x, must be 2 to 4096"},
    {"nii_dim_negative.nii", "dim[2] is -16, must be 1 or more"},
    {"nii_dim_zero.nii", "dim[2] is 0, must be 1 or more"},
    {"nii_empty.nii", "its header needs 348 bytes, 0 could be read"},
    {"nii_gzip_cut.nii.gz", "need 8192 bytes when decompressed, nii_gzip_cut.nii.gz has "},
    {"nii_header_cut.nii", "its header needs 348 bytes, 200 could be read"},
    {"nii_not_nifti.nii", "sizeof_hdr is -1428999419, must be 348 (NIfTI-1, Analyze) or 540"},
    {"nii_pixdim_nan.nii", "pixdim[1] is nan, must be the distance"},
    {"nii_pixdim_zero.nii", "pixdim[1] is 0, must be the distance"},
    {"nii_unknown_datatype.nii", "datatype is 9999, must be one of"},
    {"nii_vox_offset_past_end.nii", "need 8192 bytes, nii_vox_offset_past_end.nii has 0"},
    {"nrrd_bad_gzip.nrrd", "need 8192 bytes when decompressed, nrrd_bad_gzip.nrrd has 0"},
    {"nrrd_missing_data_file.nhdr", "not_here.raw cannot be read: No such file or directory"},
    {"nrrd_no_sizes.nrrd", "its header has no 'sizes'"},
    {"nrrd_short_data.nrrd", "16x16x16 of short need 8192 bytes, nrrd_short_data.nrrd has 1000"},
    {"nrrd_sizes_overflow.nrrd", "4294967296 voxels along x, must be 2 to 4096"},
    {"nrrd_unknown_encoding.nrrd", "encoding is 'lz77', must be raw, ascii, hex, gzip or bzip2"},
    {"vtk_not_numbers.vtk",
     "64 values of float as text need 127 bytes or more, vtk_not_numbers.vtk has 14"},
    {"vtk_short_ascii.vtk",
     "64 values of float as text need 127 bytes or more, vtk_short_ascii.vtk has 8"},
    {"vtk_wrong_dataset.vtk", "DATASET is 'POLYDATA', must be STRUCTURED_POINTS"},
};

bool has_data() {
    if (std::filesystem::is_directory(data_folder)) {
        return true;
    }
    std::printf("SKIPPED: %s is absent\n", data_folder.c_str());
    return false;
}

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

/// Where an axis points to, mostly.
char letter_of(glm::dvec4 axis) {
    const glm::dvec3 size(std::abs(axis.x), std::abs(axis.y), std::abs(axis.z));
    if (size.x >= size.y && size.x >= size.z) {
        return axis.x > 0 ? 'L' : 'R';
    }
    if (size.y >= size.z) {
        return axis.y > 0 ? 'P' : 'A';
    }
    return axis.z > 0 ? 'S' : 'I';
}

void check_row(const Row& row) {
    CAPTURE(row.path);
    const Volume volume = import_volume(data_folder + row.path);
    CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{row.nx, row.ny, row.nz});
    std::string axes;
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing_mm = glm::length(glm::dvec3(volume.voxel_to_patient[axis]));
        CHECK(std::abs(spacing_mm - row.spacing_mm[axis]) < 1e-3);
        axes.push_back(letter_of(volume.voxel_to_patient[axis]));
    }
    CHECK(axes == row.axes);
    CHECK(volume.type == row.type);
    CHECK(volume.slice_places.empty());
    if (!std::isnan(row.minimum)) {
        CHECK(volume.minimum == row.minimum);
        CHECK(std::abs(volume.maximum - row.maximum) < 1e-3);
    }
    const bool mirrored = glm::determinant(glm::dmat3(volume.voxel_to_patient)) < 0;
    CHECK(reports(volume, FindingKind::reflection, "left-handed") == mirrored);
}

void check_refused(const std::string& folder, const Refused& file) {
    CAPTURE(file.path);
    const std::string path = folder + file.path;
    std::string complaint = "none: it was read";
    try {
        import_volume(path);
    } catch (const ImportError& error) {
        complaint = error.what();
        CHECK(complaint.find(path) == 0);
    }
    CAPTURE(complaint);
    CHECK(complaint.find(file.words) != std::string::npos);
}

}  // namespace

TEST_SUITE("host/io/data") {
    TEST_CASE("the real volumes have shape, spacing, type, range and axes of their README") {
        if (!has_data()) {
            return;
        }
        for (const Row& row : volumes) {
            check_row(row);
        }
    }

    TEST_CASE("the variants of formats are read as their README says, or refused by name") {
        if (!has_data()) {
            return;
        }
        for (const Row& row : variants) {
            check_row(row);
        }
        for (const Refused& file : refused_variants) {
            check_refused(data_folder, file);
        }
    }

    TEST_CASE("all thirty broken files are refused with field and values") {
        if (!has_data()) {
            return;
        }
        CHECK(std::size(malformed) == 30);
        for (const Refused& file : malformed) {
            check_refused(data_folder + "malformed/", file);
        }
        const Volume good = import_volume(data_folder + "malformed/00_good_sphere16.nii");
        CHECK(std::array{good.nx, good.ny, good.nz} == std::array{16, 16, 16});
    }

    TEST_CASE("one head in two formats and byte orders has the same voxels in the same place") {
        if (!has_data()) {
            return;
        }
        const auto check_same = [](const char* a, const char* b) {
            const Volume left = import_volume(data_folder + a);
            const Volume right = import_volume(data_folder + b);
            CHECK(left.values == right.values);
            CHECK(left.voxel_to_patient == right.voxel_to_patient);
        };
        check_same("ct/headsq.nhdr", "ct/headsq_msb.mhd");
        check_same("nifti_variants/big.nii.gz", "nifti_variants/little.nii.gz");
        check_same("nifti_variants/air.hdr.gz", "nifti_variants/air.img.gz");
        check_same("dicom_multiframe/emri_small.dcm", "dicom_multiframe/emri_small_RLE.dcm");
        check_same("dicom_multiframe/emri_small.dcm",
                   "dicom_multiframe/emri_small_jpeg_2k_lossless.dcm");
    }

    TEST_CASE("series have the same voxels if the GPs read them") {
        if (!has_data()) {
            return;
        }
        for (const char* folder : {"ct/knee_dicom", "ct/phantom_head_tilt_dicom"}) {
            CAPTURE(folder);
            ImportRequest request;
            request.path = data_folder + folder;
            const Volume whole = import_volume(request);
            request.read = ReadBy::gps;
            const Volume scanned = import_volume(request);
            REQUIRE(scanned.stored);
            CHECK(scanned.stored->files.size() == static_cast<std::size_t>(whole.nz));
            CHECK(scanned.values == whole.values);
            CHECK(scanned.voxel_to_patient == whole.voxel_to_patient);
        }
    }

    TEST_CASE("a NIfTI-1 and a NIfTI-2 of one head have the same voxels in the same place") {
        if (!has_data()) {
            return;
        }
        const Volume first = import_volume(data_folder + "nifti_variants/avg152T1_LR_nifti.nii.gz");
        const Volume second =
            import_volume(data_folder + "nifti_variants/avg152T1_LR_nifti2.nii.gz");
        CHECK(first.voxel_to_patient == second.voxel_to_patient);
        std::vector<float> wide(second.values.size() / 4);
        std::memcpy(wide.data(), second.values.data(), second.values.size());
        REQUIRE(wide.size() == first.values.size());
        CHECK(std::equal(wide.begin(), wide.end(), first.values.begin(), [](float a, std::byte b) {
            return a == static_cast<float>(std::to_integer<int>(b));
        }));
    }

    TEST_CASE("a tilted gantry is read with its shear, which is reported") {
        if (!has_data()) {
            return;
        }
        const Volume volume = import_volume(data_folder + "ct/phantom_head_tilt_dicom");
        CHECK(volume.nz == 58);
        const glm::dvec3 x(volume.voxel_to_patient[0]), y(volume.voxel_to_patient[1]),
            z(volume.voxel_to_patient[2]);
        CHECK(glm::length(z) == doctest::Approx(2.5).epsilon(1e-4));
        const glm::dvec3 normal = glm::normalize(glm::cross(x, y));
        CHECK(glm::dot(z, normal) == doctest::Approx(2.397).epsilon(1e-3));
        CHECK(reports(volume, FindingKind::gantry_tilt, "sheared: the y and z axes meet at 73.5"));
        CHECK(volume.modality == "CT");
    }

    TEST_CASE("one ball in nine NRRD encodings has the same voxels") {
        if (!has_data()) {
            return;
        }
        const std::string folder = data_folder + "nrrd_variants/BallBinary30x30x30";
        const Volume ball = import_volume(folder + ".nrrd");
        CHECK(ball.maximum == 257);
        for (const char* variant :
             {".nhdr", "_gz.nrrd", "_bz2.nrrd", "_gz_lineskip.nrrd", ".nii.gz",
              "_byteskip_minus_one.nhdr", "_gz_byteskip_minus_one.nrrd",
              "_byteskip_minus_one_nifti.nhdr"}) {
            CAPTURE(variant);
            CHECK(import_volume(folder + variant).values == ball.values);
        }
        // This one skips nothing of the NIfTI file: its header is values, too, and much is left.
        const Volume shifted = import_volume(folder + "_nifti.nhdr");
        CHECK(
            std::equal(ball.values.begin(), ball.values.end() - 352, shifted.values.begin() + 352));
        CHECK(reports(shifted, FindingKind::note, "holds more bytes than the header states"));
    }

    TEST_CASE("one CT slice in fourteen DICOM syntaxes: exact, or as lossy as it was written") {
        if (!has_data()) {
            return;
        }
        const std::string folder = data_folder + "dicom_syntaxes/ct_";
        const Volume exact = import_volume(folder + "explicit_le.dcm");
        CHECK(std::array{exact.nx, exact.ny, exact.nz} == std::array{512, 512, 1});
        CHECK(exact.minimum == -3024);
        CHECK(exact.maximum == 1378);
        for (const char* syntax :
             {"implicit_le", "explicit_be", "deflated", "rle", "jpeg_lossless_p14",
              "jpeg_lossless_sv1", "jpegls_lossless", "j2k_lossless"}) {
            CAPTURE(syntax);
            const Volume volume = import_volume(folder + syntax + ".dcm");
            CHECK(volume.values == exact.values);
            CHECK(!reports(volume, FindingKind::note, "with loss"));
        }
        for (const char* syntax :
             {"j2k_lossy", "jpegls_lossy", "jpeg_baseline8", "jpeg_extended12", "jpeg_p10_12"}) {
            CAPTURE(syntax);
            const Volume volume = import_volume(folder + syntax + ".dcm");
            CHECK(volume.values != exact.values);
            CHECK(reports(volume, FindingKind::note, "1 of 1 slices were compressed with loss"));
            CHECK(std::abs(volume.minimum - exact.minimum) < 60);
            CHECK(std::abs(volume.maximum - exact.maximum) < 30);
        }
    }

    TEST_CASE("a folder of one slice in many syntaxes is one slice, and the copies are reported") {
        if (!has_data()) {
            return;
        }
        const Volume volume = import_volume(data_folder + "dicom_syntaxes");
        CHECK(volume.nz == 1);
        // Those without loss carry the image's own identifier; those with loss have another.
        CHECK(reports(volume, FindingKind::note, "8 copies of slices are left out"));
        CHECK(reports(volume, FindingKind::duplicate_slices, "5 slices have the position"));
    }
}
