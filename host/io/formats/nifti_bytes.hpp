// The binary header of NIfTI-1, NIfTI-2 and Analyze 7.5 files, of either byte order.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pxpl5::host::io {

/// The fields that matter here, wide enough for both versions. Names are those of the standard.
/// Source: nifti1.h and nifti2.h, nifti.nimh.nih.gov.
struct NiftiFields {
    int version = 1;     ///< 1 or 2; 0 for Analyze 7.5.
    bool single = true;  ///< Header and values in one file.
    bool big_endian = false;
    std::string magic;
    std::array<std::int64_t, 8> dim{};
    std::int32_t datatype = 0, bitpix = 0;
    std::array<double, 8> pixdim{};
    double vox_offset = 0;  ///< Bytes.
    double scl_slope = 0, scl_inter = 0;
    int xyzt_units = 0;
    int qform_code = 0, sform_code = 0;
    std::array<double, 3> quatern{}, qoffset{};
    std::array<std::array<double, 4>, 3> srow{};

    std::uint64_t header_bytes() const { return version == 2 ? 540 : 348; }
};

/// Reads the header of `path`, which may be compressed.
/// Throws ImportError naming sizeof_hdr or magic and its value.
NiftiFields read_nifti_fields(const std::filesystem::path& path);

/// x.hdr and x.img belong together, either may be compressed. Of another name: the same.
std::filesystem::path nifti_header_file(const std::filesystem::path& path);
std::filesystem::path nifti_image_file(const std::filesystem::path& path);

}  // namespace pxpl5::host::io
