// A small int16 volume in each format, written by hand.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/volume_files.hpp"

namespace pxpl5::test {

/// Voxels, x fastest, and their place: LPS millimeters.
struct Grid {
    std::array<int, 3> dims{};
    glm::dmat4 affine{1.0};
    std::vector<std::int16_t> values;

    glm::dvec3 axis(int column) const { return glm::dvec3(affine[column]); }
    double spacing(int column) const { return glm::length(axis(column)); }
    glm::dvec3 direction(int column) const { return axis(column) / spacing(column); }
    glm::dvec3 origin() const { return glm::dvec3(affine[3]); }
};

inline glm::dvec3 to_ras(glm::dvec3 lps) {
    return {-lps.x, -lps.y, lps.z};
}

inline NiftiHeader nifti1_header(const Grid& grid) {
    NiftiHeader header;
    header.put_dims({3, static_cast<std::int16_t>(grid.dims[0]),
                     static_cast<std::int16_t>(grid.dims[1]),
                     static_cast<std::int16_t>(grid.dims[2]), 1, 1, 1, 1});
    std::array<std::array<float, 4>, 3> rows{};
    for (int column = 0; column < 4; ++column) {
        const glm::dvec3 ras = to_ras(glm::dvec3(grid.affine[column]));
        for (int row = 0; row < 3; ++row) {
            rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
                static_cast<float>(ras[row]);
        }
        if (column < 3) {
            header.put<float>(80 + 4 * static_cast<std::size_t>(column),
                              static_cast<float>(grid.spacing(column)));
        }
    }
    return header.put_sform(rows);
}

/// With an sform.
inline std::string nifti1_file(const Grid& grid) {
    return nifti1_header(grid).bytes() + bytes_of(grid.values);
}

/// Big endian, with a qform: a rotation and qfac. The axes must be at right angles.
inline std::string nifti2_file(const Grid& grid) {
    glm::dmat3 rotation;
    for (int column = 0; column < 3; ++column) {
        rotation[column] = to_ras(grid.direction(column));
    }
    const double qfac = glm::determinant(rotation) < 0 ? -1 : 1;
    rotation[2] *= qfac;
    glm::dquat q = glm::quat_cast(rotation);
    q = q.w < 0 ? -q : q;
    std::string bytes(544, '\0');
    const auto put = [&](std::size_t offset, auto value) {
        bytes.replace(offset, sizeof value, bytes_of(value, true));
    };
    put(0, std::int32_t{540});
    bytes.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
    put(12, std::int16_t{4});
    put(14, std::int16_t{16});
    put(16, std::int64_t{3});
    put(104, qfac);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        put(24 + 8 * axis, std::int64_t{grid.dims[axis]});
        put(112 + 8 * axis, grid.spacing(static_cast<int>(axis)));
        put(376 + 8 * axis, to_ras(grid.origin())[static_cast<int>(axis)]);
    }
    put(168, std::int64_t{544});
    put(344, std::int32_t{1});
    put(352, q.x);
    put(360, q.y);
    put(368, q.z);
    put(500, std::int32_t{2});
    return bytes + bytes_of(grid.values, true);
}

/// In RAS, so that its reader must turn it.
inline std::string nrrd_file(const Grid& grid) {
    std::string text = fmt::format(
        "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: {} {} {}\n"
        "endian: little\nencoding: raw\nspace directions:",
        grid.dims[0], grid.dims[1], grid.dims[2]);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 v = to_ras(grid.axis(column));
        text += fmt::format(" ({},{},{})", v.x, v.y, v.z);
    }
    const glm::dvec3 o = to_ras(grid.origin());
    return text + fmt::format("\nspace origin: ({},{},{})\n\n", o.x, o.y, o.z) +
           bytes_of(grid.values);
}

/// Big endian.
inline std::string meta_image_file(const Grid& grid) {
    std::string matrix;
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 d = grid.direction(column);
        matrix += fmt::format(" {} {} {}", d.x, d.y, d.z);
    }
    const glm::dvec3 o = grid.origin();
    return fmt::format(
               "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = True\n"
               "TransformMatrix ={}\nOffset = {} {} {}\nElementSpacing = {} {} {}\n"
               "DimSize = {} {} {}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
               matrix, o.x, o.y, o.z, grid.spacing(0), grid.spacing(1), grid.spacing(2),
               grid.dims[0], grid.dims[1], grid.dims[2]) +
           bytes_of(grid.values, true);
}

/// The place of the middle of the volume, as FreeSurfer writes it. The axes must be at right
/// angles.
inline std::string mgh_file(const Grid& grid, std::int32_t frames = 1) {
    std::string bytes;
    for (const std::int32_t field : {1, grid.dims[0], grid.dims[1], grid.dims[2], frames, 4, 0}) {
        bytes += bytes_of(field, true);
    }
    bytes += bytes_of(std::int16_t{1}, true);
    glm::dvec3 middle = grid.origin();
    for (int axis = 0; axis < 3; ++axis) {
        bytes += bytes_of(static_cast<float>(grid.spacing(axis)), true);
        middle += grid.axis(axis) * (grid.dims[static_cast<std::size_t>(axis)] / 2.0);
    }
    for (const glm::dvec3 v : {grid.direction(0), grid.direction(1), grid.direction(2), middle}) {
        const glm::dvec3 ras = to_ras(v);
        for (int k = 0; k < 3; ++k) {
            bytes += bytes_of(static_cast<float>(ras[k]), true);
        }
    }
    bytes.resize(284);
    return bytes + bytes_of(grid.values, true);
}

/// Big endian, of the spacing and origin only.
inline std::string vtk_file(const Grid& grid) {
    const glm::dvec3 o = grid.origin();
    return fmt::format(
               "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n"
               "DIMENSIONS {} {} {}\nSPACING {} {} {}\nORIGIN {} {} {}\nPOINT_DATA {}\n"
               "SCALARS s short 1\nLOOKUP_TABLE default\n",
               grid.dims[0], grid.dims[1], grid.dims[2], grid.spacing(0), grid.spacing(1),
               grid.spacing(2), o.x, o.y, o.z, grid.values.size()) +
           bytes_of(grid.values, true);
}

/// Slice z of a series; `index` counts from 0 in the order of names.
inline DicomSet dicom_slice(const Grid& grid, int z) {
    const auto slice =
        static_cast<std::size_t>(grid.dims[0]) * static_cast<std::size_t>(grid.dims[1]);
    const auto begin = grid.values.begin() + static_cast<std::ptrdiff_t>(slice) * z;
    DicomSet set = dicom_image(
        grid.dims[0], grid.dims[1],
        bytes_of(std::vector<std::int16_t>(begin, begin + static_cast<std::ptrdiff_t>(slice))));
    set.text(0x20, 0x13, "IS", std::to_string(z + 1));
    dicom_place(set, grid.origin() + grid.axis(2) * double{z * 1.0}, grid.direction(0),
                grid.direction(1), grid.spacing(0), grid.spacing(1));
    return set;
}

/// A folder of slices, whose names run against their order.
inline std::string write_dicom_series(const TemporaryFolder& folder, const Grid& grid,
                                      const std::string& name) {
    std::filesystem::create_directory(folder.file(name));
    for (int z = 0; z < grid.dims[2]; ++z) {
        folder.write(fmt::format("{}/s{:03}", name, 999 - z), dicom_slice(grid, z).file());
    }
    return folder.file(name);
}

}  // namespace pxpl5::test
