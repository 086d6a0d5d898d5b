// ITK, where it is installed, reads the same voxels in the same place: an independent opinion.
#include <doctest/doctest.h>
#include <itkGDCMImageIO.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <cstdio>
#include <filesystem>

#include "host/io/import.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

const std::string data_folder = std::string(PXPL5_SOURCE_DIR) + "/../shared/data/";

itk::ImageIOBase::Pointer reader_of(const std::string& path) {
    const std::string suffix = std::filesystem::path(path).extension();
    if (suffix == ".nrrd" || suffix == ".nhdr") {
        return itk::NrrdImageIO::New().GetPointer();
    }
    if (suffix == ".mha" || suffix == ".mhd") {
        return itk::MetaImageIO::New().GetPointer();
    }
    if (suffix == ".vtk") {
        return itk::VTKImageIO::New().GetPointer();
    }
    if (suffix == ".dcm") {
        return itk::GDCMImageIO::New().GetPointer();
    }
    return itk::NiftiImageIO::New().GetPointer();
}

std::vector<double> widened(const std::vector<char>& bytes, itk::IOComponentEnum type) {
    const auto as = [&]<typename T>(T*) {
        const auto* begin = reinterpret_cast<const T*>(bytes.data());
        return std::vector<double>(begin, begin + bytes.size() / sizeof(T));
    };
    switch (type) {
        case itk::IOComponentEnum::UCHAR:
            return as(static_cast<unsigned char*>(nullptr));
        case itk::IOComponentEnum::SHORT:
            return as(static_cast<short*>(nullptr));
        case itk::IOComponentEnum::USHORT:
            return as(static_cast<unsigned short*>(nullptr));
        case itk::IOComponentEnum::INT:
            return as(static_cast<int*>(nullptr));
        case itk::IOComponentEnum::FLOAT:
            return as(static_cast<float*>(nullptr));
        default:
            return as(static_cast<double*>(nullptr));
    }
}

std::vector<double> widened(const Volume& volume) {
    std::vector<char> bytes(volume.values.size());
    std::memcpy(bytes.data(), volume.values.data(), bytes.size());
    constexpr itk::IOComponentEnum types[] = {
        itk::IOComponentEnum::UCHAR, itk::IOComponentEnum::SHORT, itk::IOComponentEnum::USHORT,
        itk::IOComponentEnum::FLOAT};
    return widened(bytes, types[static_cast<std::size_t>(volume.type)]);
}

/// Holds our reading of `path` against ITK's.
void check_file(const std::string& path) {
    CAPTURE(path);
    const Volume volume = import_volume(path);
    const itk::ImageIOBase::Pointer io = reader_of(path);
    io->SetFileName(path);
    io->ReadImageInformation();
    const unsigned axes = std::min(3U, io->GetNumberOfDimensions());
    itk::ImageIORegion region(io->GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
        region.SetSize(axis, io->GetDimensions(axis));
    }
    io->SetIORegion(region);
    std::vector<char> bytes(static_cast<std::size_t>(io->GetImageSizeInBytes()));
    io->Read(bytes.data());
    const std::vector<double> theirs = widened(bytes, io->GetComponentType());
    const std::vector<double> ours = widened(volume);
    REQUIRE(ours.size() == theirs.size());
    double worst = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        worst = std::max(worst, std::abs(ours[i] - theirs[i]) - 1e-6 * std::abs(theirs[i]));
    }
    CHECK(worst <= 1e-6);
    for (unsigned axis = 0; axis < axes; ++axis) {
        const int column = static_cast<int>(axis);
        // One slice has no known distance to a next slice.
        for (unsigned row = 0; row < 3 && volume.nz > 1; ++row) {
            CAPTURE(axis);
            const double step = io->GetDirection(axis)[row] * io->GetSpacing(axis);
            CHECK(volume.voxel_to_patient[column][static_cast<int>(row)] ==
                  doctest::Approx(step).epsilon(1e-5).scale(io->GetSpacing(axis)));
        }
        CHECK(volume.voxel_to_patient[3][column] ==
              doctest::Approx(io->GetOrigin(axis)).epsilon(1e-5));
    }
}

}  // namespace

TEST_SUITE("host/io/itk_agrees") {
    TEST_CASE("ITK reads the same voxels in the same place from the real files that it can read") {
        if (!std::filesystem::is_directory(data_folder)) {
            std::printf("SKIPPED: %s is absent\n", data_folder.c_str());
            return;
        }
        itk::Object::GlobalWarningDisplayOff();
        for (const char* path : {"ct/torso_3mm.nii.gz",
                                 "ct/pelvis_128x128x56.nrrd",
                                 "ct/knee_128x128x56.nrrd",
                                 "ct/phantom_head_oblique.nii.gz",
                                 "ct/headsq.nhdr",
                                 "ct/headsq_msb.mhd",
                                 "mr/head_t1.nii.gz",
                                 "mr/head_96x96x109.mha",
                                 "mr/head_unc_128x128x84.mhd",
                                 "mr/head_unc_64_analyze.hdr",
                                 "mr/head_unc_32_ascii.vtk",
                                 "mr/carotid.vtk",
                                 "us/spine_phantom.mha",
                                 "us/spine_phantom_128x64x96.nrrd",
                                 "us/ball_phantom.nii.gz",
                                 "nifti_variants/avg152T1_LR_nifti.nii.gz",
                                 "nifti_variants/big.nii.gz",
                                 "nifti_variants/little.nii.gz",
                                 "nifti_variants/air.hdr.gz",
                                 "nifti_variants/with_extension.nii.gz",
                                 "nrrd_variants/BallBinary30x30x30.nrrd",
                                 "nrrd_variants/BallBinary30x30x30_gz_lineskip.nrrd",
                                 "nrrd_variants/BallBinary30x30x30_byteskip_minus_one_nifti.nhdr",
                                 "nrrd_variants/BallBinary30x30x30.nii.gz"}) {
            check_file(data_folder + path);
        }
        for (const auto& file :
             std::filesystem::directory_iterator(data_folder + "dicom_syntaxes")) {
            check_file(file.path());
        }
        check_file(data_folder + "ct/knee_dicom/000007.dcm");
    }
}
