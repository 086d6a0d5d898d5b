// VTK XML image data, written by hand, in each of its forms.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>

#include "tests/base64.hpp"
#include "tests/gzip.hpp"
#include "tests/host/io/volume_writers.hpp"

namespace pxpl5::test {

/// Storage of the values in a VTK XML file.
struct VtiForm {
    std::string format = "appended", encoding = "raw";
    bool compressed = false, wide = true, big_endian = false;
    std::size_t block_bytes = 100;  ///< Size of a block before compression.
};

/// Values behind their lengths, or as text.
inline std::string vti_values(const std::vector<std::int16_t>& values, const VtiForm& form) {
    if (form.format == "ascii") {
        return fmt::format("{}", fmt::join(values, " "));
    }
    const auto number = [&](std::size_t value) {
        return form.wide ? bytes_of(std::uint64_t{value}, form.big_endian)
                         : bytes_of(static_cast<std::uint32_t>(value), form.big_endian);
    };
    const bool is_text = form.format == "binary" || form.encoding == "base64";
    const auto coded = [&](const std::string& bytes) { return is_text ? base64(bytes) : bytes; };
    const std::string bytes = bytes_of(values, form.big_endian);
    if (!form.compressed) {
        return coded(number(bytes.size()) + bytes);
    }
    const std::size_t blocks = (bytes.size() + form.block_bytes - 1) / form.block_bytes;
    std::string lengths =
        number(blocks) + number(form.block_bytes) + number(bytes.size() % form.block_bytes);
    std::string packed;
    for (std::size_t at = 0; at < bytes.size(); at += form.block_bytes) {
        const std::string block = zipped(bytes.substr(at, form.block_bytes));
        lengths += number(block.size());
        packed += block;
    }
    return coded(lengths) + coded(packed);
}

/// The array "density" has the grid's values; "before" and "after", of other values, lie around it.
/// The index begins at (2, -1, 3).
inline std::string vti_file(const Grid& grid, const VtiForm& form = {}) {
    std::string direction;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            direction += fmt::format(" {}", grid.direction(column)[row]);
        }
    }
    const glm::ivec3 first(2, -1, 3);
    const glm::dvec3 origin = grid.origin() - glm::dmat3(grid.affine) * glm::dvec3(first);
    std::string extent;
    for (int axis = 0; axis < 3; ++axis) {
        const int size = grid.dims[static_cast<std::size_t>(axis)];
        extent += fmt::format(" {} {}", first[axis], first[axis] + size - 1);
    }
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{}\" "
        "header_type=\"{}\"{}>\n<ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" "
        "Spacing=\"{} {} {}\" Direction=\"{}\">\n<Piece Extent=\"{}\">\n"
        "<PointData Scalars=\"density\">\n",
        form.big_endian ? "BigEndian" : "LittleEndian", form.wide ? "UInt64" : "UInt32",
        form.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "", extent, origin.x, origin.y,
        origin.z, grid.spacing(0), grid.spacing(1), grid.spacing(2), direction, extent);
    std::string appended;
    const std::vector<std::int16_t> others(grid.values.rbegin(), grid.values.rend());
    for (const char* name : {"before", "density", "after"}) {
        const bool is_wanted = std::string_view(name) == "density";
        const std::string values = vti_values(is_wanted ? grid.values : others, form);
        text +=
            fmt::format("<DataArray type=\"Int16\" Name=\"{}\" format=\"{}\"", name, form.format);
        text += form.format == "appended" ? fmt::format(" offset=\"{}\"/>\n", appended.size())
                : form.format == "ascii"  ? ">" + values + "</DataArray>\n"
                                          : ">\n  " + values + "\n</DataArray>\n";
        appended += values;
    }
    text += "</PointData>\n</Piece>\n</ImageData>\n";
    if (form.format == "appended") {
        text += fmt::format("<AppendedData encoding=\"{}\">\n _{}\n</AppendedData>\n",
                            form.encoding, appended);
    }
    return text + "</VTKFile>\n";
}

/// All forms, each with a name.
inline std::vector<std::pair<std::string, VtiForm>> vti_forms() {
    std::vector<std::pair<std::string, VtiForm>> forms = {{"ascii", {"ascii", ""}}};
    for (const bool compressed : {false, true}) {
        for (const bool wide : {false, true}) {
            for (const bool big_endian : {false, true}) {
                const std::string name = fmt::format("{}-{}-{}", compressed ? "zlib" : "plain",
                                                     wide ? 64 : 32, big_endian ? "big" : "little");
                forms.push_back({"inline-" + name, {"binary", "", compressed, wide, big_endian}});
                forms.push_back({"raw-" + name, {"appended", "raw", compressed, wide, big_endian}});
                forms.push_back(
                    {"base64-" + name, {"appended", "base64", compressed, wide, big_endian}});
            }
        }
    }
    return forms;
}

}  // namespace pxpl5::test
