// The real volumes: `watertight` is closed but for the border, manifold and oriented on all of
// them, and closed in air.
#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <limits>

#include "host/io/import.hpp"
#include "host/surface/atlas/isovalue_components.hpp"
#include "host/surface/components.hpp"
#include "host/surface/export/border_cap.hpp"
#include "host/surface/export/plane_cut.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/host/surface/surface_support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::Certificate;

namespace {

const std::string data_folder = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/";

/// An isovalue of the data folder's README and the triangles that VTK finds there.
struct Known {
    double isovalue;
    std::int64_t triangles;
};
struct Row {
    const char* path;
    std::vector<Known> known;
};

const Row rows[] = {
    {"ct/torso_3mm.nii.gz", {{-300.5, 180470}, {0.5, 743674}, {200.5, 131148}, {300.5, 85414}}},
    {"ct/pelvis_128x128x56.nrrd",
     {{-300.5, 77522}, {200.5, 112266}, {300.5, 79104}, {400.5, 48552}}},
    {"ct/knee_dicom", {{-300.5, 37814}, {0.5, 126741}, {200.5, 60214}}},
    {"ct/knee_128x128x56.nrrd", {{-519.5, 42416}, {76.5, 111436}, {180.5, 49908}}},
    {"ct/abdomen_j2k_dicom", {{-300.5, 215460}, {200.5, 257212}}},
    {"ct/phantom_head_tilt_dicom", {{-300.5, 224528}, {200.5, 177620}}},
    {"ct/phantom_head_oblique.nii.gz", {{60.5, 497192}, {200.5, 280288}}},
    {"ct/headsq.nhdr", {{500.5, 57686}, {1150.5, 78492}}},
    {"ct/headsq_msb.mhd", {{500.5, 57686}, {1150.5, 78492}}},
    {"mr/head_t1.nii.gz", {{20.5, 397726}, {60.5, 792764}, {200.5, 2254548}}},
    {"mr/head_96x96x109.mha", {{30.5, 121926}, {70.5, 269544}, {200.5, 507022}}},
    {"mr/head_unc_128x128x84.mhd", {{25.5, 191256}, {60.5, 263296}}},
    {"mr/head_unc_64_analyze.hdr", {{2500.5, 31152}}},
    {"mr/head_unc_32_ascii.vtk", {{25.5, 7612}}},
    {"mr/carotid.vtk", {{200.5, 11432}}},
    {"us/spine_phantom.mha", {{20.5, 115192}, {60.5, 108132}, {120.5, 98004}}},
    {"us/spine_phantom_128x64x96.nrrd", {{13.5, 70232}, {60.5, 56900}, {120.5, 50080}}},
    {"us/ball_phantom.nii.gz", {{60.5, 69088}, {90.5, 35412}, {110.5, 24354}}},
};

/// A cut of an exported surface: the plane keeps the places where dot(plane, (x, y, z, 1)) >= 0.
struct CutRow {
    const char* path;
    double isovalue;
    glm::dvec4 plane;
};
const CutRow cut_rows[] = {
    {"ct/knee_128x128x56.nrrd", 180.5, {-1, 0, 0, 28.243}},
    {"ct/knee_128x128x56.nrrd", 180.5, {1, 0, 0, -28.243}},
    {"ct/torso_3mm.nii.gz", 0.5, {0, 0, -1, 250.3}},
    {"ct/torso_3mm.nii.gz", 0.5, {0, -1, 0, -150.7}},
    {"ct/torso_3mm.nii.gz", 0.5, {-1, 0, 0, 10.1}},
    {"ct/phantom_head_oblique.nii.gz", 60.5, {-1, 0, 0, 10.1}},
};

/// Files of other formats, without isovalues of their own.
const char* const variants[] = {"dicom_multiframe/emri_small.dcm",
                                "nifti_variants/avg152T1_LR_nifti.nii.gz",
                                "nifti_variants/avg152T1_LR_nifti2.nii.gz",
                                "nifti_variants/air.hdr.gz",
                                "nifti_variants/big.nii.gz",
                                "nifti_variants/little.nii.gz",
                                "nifti_variants/with_extension.nii.gz",
                                "nrrd_variants/BallBinary30x30x30.nrrd"};

bool has_data() {
    if (std::filesystem::is_directory(data_folder)) return true;
    std::printf("SKIPPED: %s is absent\n", data_folder.c_str());
    return false;
}

Volume for_gps(const host::Volume& volume) {
    Volume out;
    out.shape.nx = volume.nx;
    out.shape.ny = volume.ny;
    out.shape.nz = volume.nz;
    out.shape.type = static_cast<Scalar>(volume.type);
    out.shape.voxel_to_patient = volume.voxel_to_patient;
    out.shape.minimum = volume.minimum;
    out.shape.maximum = volume.maximum;
    out.shape.slice_places = volume.slice_places;
    out.values = volume.values;
    return out;
}

}  // namespace

TEST_SUITE("host/surface/data") {
    TEST_CASE("every surface of the data folder's README certifies, with VTK's triangles") {
        if (!has_data()) return;
        for (const Row& row : rows) {
            CAPTURE(row.path);
            const host::Volume volume = host::io::import_volume(data_folder + row.path);
            const Volume gps_volume = for_gps(volume);
            const Gp gp(gps_volume, {0, 1});
            std::vector<double> isovalues;
            for (const Known& known : row.known) isovalues.push_back(known.isovalue);
            const auto counts = host::count_components(volume, isovalues);
            for (std::size_t i = 0; i < isovalues.size(); ++i) {
                CAPTURE(isovalues[i]);
                const Slabs slabs = extract_slabs(gp.store, isovalues[i]);
                const host::VolumeGrid grid = host::grid_of(volume);
                const Certificate c = host::certify(gather(messages_of(slabs), grid), grid);
                CHECK(c.triangles == row.known[i].triangles);
                CHECK(c.closed_but_for_border());
                CHECK(c.manifold());
                CHECK(c.oriented());
                CHECK(c.components == counts[i].surface());
                const GpSums sums = sums_of(slabs);
                CHECK(c.vertices == sums.vertices);
                CHECK(c.area_mm2 == doctest::Approx(sums.area_mm2).epsilon(1e-9));
                CHECK(c.volume_mm3 == doctest::Approx(sums.volume_mm3).epsilon(1e-6));
            }
        }
    }

    TEST_CASE(
        "the formats' variants certify at a quarter, half and three quarters of their range") {
        if (!has_data()) return;
        for (const char* path : variants) {
            CAPTURE(path);
            const host::Volume volume = host::io::import_volume(data_folder + path);
            const Volume gps_volume = for_gps(volume);
            const Gp gp(gps_volume, {0, 1});
            const host::VolumeGrid grid = host::grid_of(volume);
            for (const double part : {0.25, 0.5, 0.75}) {
                CAPTURE(part);
                const std::vector<double> isovalue{volume.minimum +
                                                   part * (volume.maximum - volume.minimum)};
                const auto messages = messages_of(extract_slabs(gp.store, isovalue[0]));
                const Certificate c = host::certify(gather(messages, grid), grid);
                CHECK(c.triangles > 0);
                CHECK(c.good());
                CHECK(c.components == host::count_components(volume, isovalue)[0].surface());
            }
        }
    }

    TEST_CASE("surfaces cut by a plane and closed are manifolds") {
        if (!has_data()) return;
        for (const CutRow& row : cut_rows) {
            CAPTURE(row.path);
            CAPTURE(row.plane[0]);
            CAPTURE(row.plane[1]);
            const host::Volume volume = host::io::import_volume(data_folder + row.path);
            const host::VolumeGrid grid = host::grid_of(volume);
            host::WeldedMesh mesh =
                gather(messages_of(extract_slabs(for_gps(volume), row.isovalue)), grid);
            host::keep_apart(mesh, grid);
            host::cap_at_border(mesh, volume, row.isovalue);
            host::move_to_patient(mesh, grid);
            host::cut_by_plane(mesh, row.plane, 0.002, true);
            const host::WeldedFile file = host::weld(mesh.p_grid, mesh.triangles);
            const Certificate c = host::certify(file.mesh, host::patient_grid());
            CHECK(file.collapsed == 0);
            CHECK(c.closed());
            CHECK(c.manifold());
            CHECK(c.oriented());
        }
    }

    TEST_CASE("in air every surface is closed, also at isovalues on voxels' values") {
        if (!has_data()) return;
        for (const Row& row : rows) {
            CAPTURE(row.path);
            const Volume volume = for_gps(host::io::import_volume(data_folder + row.path));
            const Volume in_air = padded(volume, volume.shape.minimum);
            const double isovalue = std::ceil(row.known[0].isovalue);
            if (isovalue <= volume.shape.minimum) continue;
            const Certificate c = certify_volume(in_air, isovalue);
            CHECK(c.closed());
            CHECK(c.good());
            CHECK(c.genus().value_or(-1) >= 0);
        }
    }
}
