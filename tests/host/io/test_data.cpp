#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>

#include "host/io/import.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

const std::string data_folder = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/";

/// A row of the data folder's README.
struct Row {
    const char* path;
    int nx, ny, nz;
    glm::dvec3 spacing_mm;
    Scalar type;
    double minimum, maximum;
};

const Row rows[] = {
    {"ct/torso_3mm.nii.gz", 122, 101, 112, {3, 3, 3}, Scalar::int16, -1207, 3382},
    {"ct/pelvis_128x128x56.nrrd", 128, 128, 56, {2.859, 2.367, 3}, Scalar::int16, -1207, 3382},
    {"ct/knee_dicom", 134, 162, 49, {0.977, 0.977, 3.27}, Scalar::int16, -1000, 1494},
    {"ct/knee_128x128x56.nrrd", 128, 128, 56, {1.022, 1.236, 2.861}, Scalar::int16, -1000, 1494},
    {"ct/abdomen_j2k_dicom", 512, 512, 20, {0.977, 0.977, 2}, Scalar::int16, -1024, 1839},
    // The tilted series' slices are 2.397 mm apart along the normal; its step is 2.5 / cos.
    {"ct/phantom_head_oblique.nii.gz", 175, 248, 58, {0.813, 0.813, 2.397}, Scalar::uint8, 0, 255},
    {"ct/headsq.nhdr", 64, 64, 93, {3.2, 3.2, 1.5}, Scalar::int16, 0, 3926},
    {"ct/headsq_msb.mhd", 64, 64, 93, {3.2, 3.2, 1.5}, Scalar::int16, 0, 3926},
    {"mr/head_t1.nii.gz", 160, 232, 160, {1, 0.898, 0.898}, Scalar::float32, 0, 512},
    {"mr/head_96x96x109.mha", 96, 96, 109, {1.667, 2.171, 1.319}, Scalar::int16, 0, 512},
    {"mr/head_unc_128x128x84.mhd", 128, 128, 84, {1.8, 1.8, 1.8}, Scalar::uint8, 0, 202},
    {"mr/head_unc_64_analyze.hdr", 64, 64, 42, {3.6, 3.6, 3.6}, Scalar::int16, 0, 15100},
    {"mr/head_unc_32_ascii.vtk", 32, 32, 21, {7.2, 7.2, 7.2}, Scalar::uint8, 0, 154},
    {"mr/carotid.vtk", 76, 49, 45, {1, 1, 1}, Scalar::float32, 0, 580},
    {"us/spine_phantom.mha", 147, 106, 104, {0.5, 0.5, 0.5}, Scalar::uint8, 0, 251},
    {"us/spine_phantom_128x64x96.nrrd", 128, 64, 96, {0.574, 0.828, 0.542}, Scalar::uint8, 0, 251},
    {"us/ball_phantom.nii.gz", 78, 79, 95, {0.5, 0.5, 0.5}, Scalar::uint8, 0, 255},
};

bool has_data() {
    if (std::filesystem::is_directory(data_folder)) {
        return true;
    }
    std::printf("SKIPPED: %s is absent\n", data_folder.c_str());
    return false;
}

bool notes_say(const Volume& volume, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(),
                       [&](const Finding& f) { return f.text.find(words) != std::string::npos; });
}

}  // namespace

TEST_SUITE("host/io/data") {
    TEST_CASE("the real volumes have the shape, spacing, type and range of their README") {
        if (!has_data()) {
            return;
        }
        for (const Row& row : rows) {
            CAPTURE(row.path);
            const Volume volume = import_volume(data_folder + row.path);
            CHECK(volume.nx == row.nx);
            CHECK(volume.ny == row.ny);
            CHECK(volume.nz == row.nz);
            for (int axis = 0; axis < 3; ++axis) {
                const double spacing_mm = glm::length(glm::dvec3(volume.voxel_to_patient[axis]));
                CHECK(std::abs(spacing_mm - row.spacing_mm[axis]) < 1e-3);
            }
            CHECK(volume.type == row.type);
            CHECK(volume.minimum == row.minimum);
            CHECK(std::abs(volume.maximum - row.maximum) < 1e-3);
        }
    }

    TEST_CASE("one head in two formats and byte orders has the same voxels") {
        if (!has_data()) {
            return;
        }
        CHECK(import_volume(data_folder + "ct/headsq.nhdr").values ==
              import_volume(data_folder + "ct/headsq_msb.mhd").values);
        CHECK(import_volume(data_folder + "nifti_variants/big.nii.gz").values ==
              import_volume(data_folder + "nifti_variants/little.nii.gz").values);
    }

    TEST_CASE("a tilted gantry is read with its shear") {
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
        CHECK(notes_say(volume, "sheared: the y and z axes meet at 73.5"));
    }

    TEST_CASE("one ball in eight NRRD encodings has the same voxels") {
        if (!has_data()) {
            return;
        }
        const std::string folder = data_folder + "nrrd_variants/BallBinary30x30x30";
        const Volume ball = import_volume(folder + ".nrrd");
        for (const char* variant :
             {".nhdr", "_gz.nrrd", "_gz_lineskip.nrrd", ".nii.gz", "_byteskip_minus_one.nhdr",
              "_gz_byteskip_minus_one.nrrd", "_byteskip_minus_one_nifti.nhdr"}) {
            CAPTURE(variant);
            CHECK(import_volume(folder + variant).values == ball.values);
        }
        CHECK_THROWS_AS(import_volume(folder + "_byteskip_minus_five.nhdr"), ImportError);
    }
}
