// NIfTI-1, NIfTI-2 and Analyze 7.5: what the header's fields mean.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "host/io/formats/nifti_bytes.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"
#include "host/io/values/place.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

struct NiftiType {
    std::int32_t code;
    Component component;
};
constexpr std::array nifti_types = {
    NiftiType{2, Component::uint8},    NiftiType{4, Component::int16},
    NiftiType{8, Component::int32},    NiftiType{16, Component::float32},
    NiftiType{64, Component::float64}, NiftiType{256, Component::int8},
    NiftiType{512, Component::uint16}, NiftiType{768, Component::uint32},
    NiftiType{1024, Component::int64}, NiftiType{1280, Component::uint64}};

constexpr double max_pixdim_mismatch =
    0.01;  // Share of the sform's column: a hundredth is no rounding.

/// The name of a type that is no scalar; empty if it is unknown.
const char* name_of_other(std::int32_t datatype) {
    switch (datatype) {
        case 1:
            return " (bits)";
        case 32:
        case 1792:
        case 2048:
            return " (complex numbers)";
        case 128:
            return " (RGB color)";
        case 2304:
            return " (RGBA color)";
        default:
            return "";
    }
}

void note_bits(const NiftiFields& fields, StoredHeader& header) {
    const int bits = 8 * static_cast<int>(component_bytes(header.component));
    if (fields.bitpix != 0 && fields.bitpix != bits) {
        header.find(FindingKind::note,
                    fmt::format("bitpix is {}, datatype {} has {} bits: the datatype counts",
                                fields.bitpix, fields.datatype, bits));
    }
}

void read_type(const std::string& file, const NiftiFields& fields, StoredHeader& header) {
    for (const NiftiType& type : nifti_types) {
        if (type.code == fields.datatype) {
            header.component = type.component;
            header.type = component_name(type.component);
            note_bits(fields, header);
            return;
        }
    }
    throw ImportError(
        fmt::format("{}: datatype is {}{}, must be one of the scalar types 2, 4, 8, 16, "
                    "64, 256, 512, 768, 1024, 1280",
                    file, fields.datatype, name_of_other(fields.datatype)));
}

void read_sizes(const std::string& file, const NiftiFields& fields, StoredHeader& header) {
    const std::int64_t axes = fields.dim[0];
    if (axes < 1 || axes > 7) {
        throw ImportError(fmt::format("{}: dim[0] is {}, must be 1 to 7", file, axes));
    }
    for (std::size_t axis = 1; axis <= static_cast<std::size_t>(axes); ++axis) {
        if (fields.dim[axis] < 1) {
            throw ImportError(
                fmt::format("{}: dim[{}] is {}, must be 1 or more", file, axis, fields.dim[axis]));
        }
        header.sizes.push_back(static_cast<std::uint64_t>(fields.dim[axis]));
    }
}

/// Lengths of the axes in millimeters; negative ones, as some Analyze writers use them, count as
/// positive.
glm::dvec3 read_spacing(const std::string& file, const NiftiFields& fields, double unit_mm,
                        StoredHeader& header) {
    glm::dvec3 spacing(1.0);
    for (std::size_t axis = 1; axis <= 3; ++axis) {
        const double stated = fields.pixdim[axis];
        if (axis > header.sizes.size()) {
            header.spacing_stated[axis - 1] = false;
            continue;
        }
        if (!std::isfinite(stated) || stated == 0) {
            throw ImportError(
                fmt::format("{}: pixdim[{}] is {}, must be the distance of voxels in millimeters",
                            file, axis, stated));
        }
        if (stated < 0) {
            header.find(FindingKind::note,
                        fmt::format("pixdim[{}] is {}: its sign is left out", axis, stated));
        }
        spacing[static_cast<int>(axis) - 1] = std::abs(stated) * unit_mm;
    }
    return spacing;
}

double read_unit(const NiftiFields& fields, StoredHeader& header) {
    const int unit = fields.xyzt_units & 7;
    if (unit == 1 || unit == 3) {
        header.find(FindingKind::conversion,
                    fmt::format("lengths in {} are converted to millimeters",
                                unit == 1 ? "meters" : "micrometers"));
        return unit == 1 ? 1000 : 1e-3;
    }
    if (unit != 2 && fields.version != 0) {
        header.find(FindingKind::note, "xyzt_units states no unit of length: read as millimeters");
    }
    return 1;
}

/// Milliseconds between the volumes of a time series; 0 if the file does not state them.
double frame_ms_of(const NiftiFields& fields) {
    constexpr int time_unit = 0x38, seconds = 8, milliseconds = 16, microseconds = 24;
    const int unit = fields.xyzt_units & time_unit;
    const double factor = unit == seconds        ? 1000
                          : unit == milliseconds ? 1
                          : unit == microseconds ? 1e-3
                                                 : 0;
    const double ms = fields.pixdim[4] * factor;
    return std::isfinite(ms) && ms > 0 ? ms : 0;
}

/// The quaternion's rotation, RAS. Source: nifti1.h, "METHOD 2".
glm::dmat3 rotation_of(const std::string& file, const NiftiFields& fields) {
    const double b = fields.quatern[0], c = fields.quatern[1], d = fields.quatern[2];
    const double square = b * b + c * c + d * d;
    constexpr double rounding = 1e-4;  // float32 quaternions of half turns may exceed 1 a little.
    if (!(square <= 1 + rounding)) {
        throw ImportError(
            fmt::format("{}: quatern_b, c, d are {}, {}, {}: their squares must sum to 1 at most",
                        file, b, c, d));
    }
    // Near 1 the root of the rest is nothing but rounding: a half turn.
    double a = 0, norm = 1;
    if (1 - square < 1e-7) {
        norm = 1 / std::sqrt(square);
    } else {
        a = std::sqrt(1 - square);
    }
    const double x = b * norm, y = c * norm, z = d * norm;
    return {a * a + x * x - y * y - z * z, 2 * (x * y + a * z),
            2 * (x * z - a * y),           2 * (x * y - a * z),
            a * a + y * y - x * x - z * z, 2 * (y * z + a * x),
            2 * (x * z + a * y),           2 * (y * z - a * x),
            a * a + z * z - x * x - y * y};
}

glm::dmat4 qform(const std::string& file, const NiftiFields& fields, glm::dvec3 spacing,
                 double unit_mm) {
    const glm::dmat3 rotation = rotation_of(file, fields);
    const double qfac = fields.pixdim[0] < 0 ? -1 : 1;
    glm::dmat4 ras(1.0);
    ras[0] = glm::dvec4(rotation[0] * spacing.x, 0);
    ras[1] = glm::dvec4(rotation[1] * spacing.y, 0);
    ras[2] = glm::dvec4(rotation[2] * spacing.z * qfac, 0);
    ras[3] = glm::dvec4(fields.qoffset[0] * unit_mm, fields.qoffset[1] * unit_mm,
                        fields.qoffset[2] * unit_mm, 1);
    return ras;
}

glm::dmat4 sform(const NiftiFields& fields, glm::dvec3 spacing, double unit_mm,
                 StoredHeader& header) {
    glm::dmat4 ras(1.0);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            ras[column][row] =
                fields.srow[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] *
                unit_mm;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double length = glm::length(glm::dvec3(ras[axis]));
        if (header.spacing_stated[static_cast<std::size_t>(axis)] &&
            std::abs(length - spacing[axis]) > max_pixdim_mismatch * length) {
            header.find(FindingKind::note,
                        fmt::format("pixdim[{}] is {} mm, the sform's step {} mm: the sform counts",
                                    axis + 1, spacing[axis], length));
        }
        header.spacing_stated[static_cast<std::size_t>(axis)] = true;
    }
    return ras;
}

void read_place(const std::string& file, const NiftiFields& fields, StoredHeader& header) {
    const double unit_mm = read_unit(fields, header);
    const glm::dvec3 spacing = read_spacing(file, fields, unit_mm, header);
    glm::dmat4 scaled(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        scaled[axis] *= spacing[axis];
    }
    if (fields.version == 0) {
        header.voxel_to_patient = scaled;
        header.assumed_directions =
            "Analyze 7.5 states no patient space: x, y, z are taken as left, posterior, superior; "
            "left and right may be swapped";
    } else if (fields.sform_code > 0) {
        header.voxel_to_patient = to_lps(sform(fields, spacing, unit_mm, header));
    } else if (fields.qform_code > 0) {
        header.voxel_to_patient = to_lps(qform(file, fields, spacing, unit_mm));
    } else {
        header.voxel_to_patient = to_lps(scaled);
        header.assumed_directions =
            "qform_code and sform_code are 0: x, y, z are taken as right, anterior, superior; left "
            "and right may be swapped";
    }
}

void read_scale(const NiftiFields& fields, StoredHeader& header) {
    if (fields.version == 0 || fields.scl_slope == 0) {
        return;
    }
    if (!std::isfinite(fields.scl_slope) || !std::isfinite(fields.scl_inter)) {
        // Writers that mean "no scaling" put in NaN (SPM, nibabel).
        header.find(FindingKind::note,
                    fmt::format("scl_slope is {} and scl_inter {}: values are not scaled",
                                fields.scl_slope, fields.scl_inter));
        return;
    }
    header.scale = {fields.scl_slope, fields.scl_inter};
    if (!header.scale.is_identity()) {
        header.find(FindingKind::conversion,
                    fmt::format("stored {} values are scaled by {} and shifted by {}", header.type,
                                fields.scl_slope, fields.scl_inter));
    }
}

void locate_data(const fs::path& path, const NiftiFields& fields, StoredHeader& header) {
    const double least = fields.single ? static_cast<double>(fields.header_bytes()) : 0;
    constexpr double most = 9e15;  // Whole numbers up to here are exact in float64.
    if (!(fields.vox_offset >= least) || !(fields.vox_offset < most)) {
        throw ImportError(fmt::format("{}: vox_offset is {}, must be {} or more", path.string(),
                                      fields.vox_offset, least));
    }
    header.data_files = {fields.single ? path : nifti_image_file(path)};
    const DataFile opened(path, header.data_files[0], header.allowed);
    header.encoding = is_gzip(opened.path()) ? Encoding::gzip : Encoding::raw;
    header.byte_skip = static_cast<std::uint64_t>(fields.vox_offset);
    header.ends_file = true;
}

}  // namespace

StoredHeader read_nifti_header(const fs::path& path, const AllowedFolders& allowed,
                               std::uint32_t frame) {
    const std::string file = path.string();
    const NiftiFields fields = read_nifti_fields(nifti_header_file(path));
    const std::string name = lower_case(path.filename().string());
    if ((name.ends_with(".nii") || name.ends_with(".nii.gz")) && !fields.single) {
        throw ImportError(
            fmt::format("{}: magic is '{}', must be 'n+1' or 'n+2'", file, shown(fields.magic)));
    }
    StoredHeader header;
    header.allowed = allowed;
    header.big_endian = fields.big_endian;
    read_sizes(file, fields, header);
    take_frames(file, frame, FourthAxis::time, header);
    header.frame_ms = frame_ms_of(fields);
    read_type(file, fields, header);
    read_place(file, fields, header);
    read_scale(fields, header);
    locate_data(path, fields, header);
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
