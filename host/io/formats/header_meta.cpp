// MetaImage headers: "Key = value" lines, the last of which is ElementDataFile.
#include <fmt/format.h>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

Fields read_fields(HeaderReader& reader) {
    Fields fields;
    for (std::string line; reader.next(line);) {
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) {
            continue;
        }
        const std::string key = lower_case(trimmed(line.substr(0, equals)));
        fields[key] = trimmed(line.substr(equals + 1));
        if (key == "elementdatafile") {
            break;
        }
    }
    return fields;
}

/// The first of `keys` that is there.
std::string first_of(const Fields& fields, std::initializer_list<const char*> keys,
                     const std::string& otherwise) {
    for (const char* key : keys) {
        if (fields.contains(key)) {
            return fields.at(key);
        }
    }
    return otherwise;
}

bool is_true(const Fields& fields, std::initializer_list<const char*> keys, bool otherwise) {
    const std::string text = lower_case(first_of(fields, keys, otherwise ? "true" : "false"));
    return text == "true" || text == "1" || text == "t";
}

std::vector<fs::path> data_files(const fs::path& path, const std::string& name,
                                 HeaderReader& reader) {
    const std::string lower = lower_case(name);
    if (lower == "local") {
        return {path};
    }
    if (lower == "list" || lower.starts_with("list ")) {
        std::vector<fs::path> files;
        for (std::string line; reader.next(line) && files.size() < max_data_files;) {
            if (!trimmed(line).empty()) {
                files.push_back(path.parent_path() / trimmed(line));
            }
        }
        return files;
    }
    if (name.find('%') != std::string::npos) {
        return numbered_files(path, "ElementDataFile", name);
    }
    return {path.parent_path() / name};
}

void locate_data(const fs::path& path, const Fields& fields, HeaderReader& reader,
                 StoredHeader& header) {
    const std::string file = path.string();
    const std::uint64_t header_end = reader.offset_bytes();
    const std::string name = require(file, fields, "ElementDataFile");
    header.data_files = data_files(path, name, reader);
    const bool local = lower_case(name) == "local";
    header.offset_bytes = local ? header_end : 0;
    header.encoding = is_true(fields, {"compresseddata"}, false) ? Encoding::gzip
                      : is_true(fields, {"binarydata"}, true)    ? Encoding::raw
                                                                 : Encoding::ascii;
    const std::string skip = value_or(fields, "headersize", "0");
    header.ends_file = skip != "-1";
    header.at_end = skip == "-1" && header.encoding != Encoding::ascii;
    if (skip != "-1") {
        const auto bytes = whole_numbers(file, "HeaderSize", skip);
        header.offset_bytes += bytes.empty() ? 0 : bytes[0];
    }
    header.big_endian = is_true(fields, {"binarydatabyteordermsb", "elementbyteordermsb"}, false);
}

/// The numbers of a matrix that turns nothing.
std::string identity_text(std::size_t axes) {
    std::string text;
    for (std::size_t at = 0; at < axes * axes; ++at) {
        text += at % (axes + 1) == 0 ? "1 " : "0 ";
    }
    return text;
}

/// Directions are the axes' one after the other; MetaImage's own space is LPS by ITK's convention.
void read_place(const std::string& file, const Fields& fields, std::size_t axes,
                StoredHeader& header) {
    const bool has_spacing = fields.contains("elementspacing");
    const bool has_size = fields.contains("elementsize");
    header.spacing_stated.fill(has_spacing || has_size);
    header.spacing_stated[2] = header.spacing_stated[2] && axes > 2;
    if (!has_spacing && has_size) {
        header.find(FindingKind::assumption,
                    "no ElementSpacing: ElementSize is taken as the spacing");
    }
    const glm::dvec3 spacing =
        three_numbers(file, has_spacing ? "ElementSpacing" : "ElementSize",
                      first_of(fields, {"elementspacing", "elementsize"}, "1 1 1"), 1.0);
    const std::vector<double> matrix = numbers(
        file, "TransformMatrix",
        first_of(fields, {"transformmatrix", "orientation", "rotation"}, identity_text(axes)));
    if (matrix.size() != axes * axes) {
        throw ImportError(fmt::format("{}: TransformMatrix has {} numbers, {} axes need {}", file,
                                      matrix.size(), axes, axes * axes));
    }
    const std::size_t row = axes == 2 ? 2 : axes;
    for (std::size_t column = 0; column < std::min<std::size_t>(axes, 3); ++column) {
        for (std::size_t i = 0; i < std::min<std::size_t>(axes, 3); ++i) {
            if (column * row + i < matrix.size()) {
                header.voxel_to_patient[static_cast<int>(column)][static_cast<int>(i)] =
                    matrix[column * row + i];
            }
        }
    }
    for (int column = 0; column < 3; ++column) {
        header.voxel_to_patient[column] *= spacing[column];
    }
    const glm::dvec3 origin = three_numbers(
        file, "Offset", first_of(fields, {"offset", "position", "origin"}, "0 0 0"), 0.0);
    header.voxel_to_patient[3] = glm::dvec4(origin, 1.0);
    const std::string orientation = value_or(fields, "anatomicalorientation", "");
    if (orientation.empty() || orientation.find('?') != std::string::npos) {  // ITK: "???".
        header.find(FindingKind::assumption,
                    "the header states no AnatomicalOrientation: x, y, z are taken as left, "
                    "posterior, superior by its matrix");
    }
}

}  // namespace

StoredHeader read_meta_header(const fs::path& path, const AllowedFolders& allowed,
                              std::uint32_t frame) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Fields fields = read_fields(reader);
    StoredHeader header;
    header.allowed = allowed;
    header.sizes = whole_numbers(file, "DimSize", require(file, fields, "DimSize"));
    header.type = require(file, fields, "ElementType");
    const std::optional<Component> component = component_named(header.type);
    if (!component || !lower_case(header.type).starts_with("met_")) {
        throw ImportError(fmt::format("{}: ElementType '{}' is not a scalar type of MetaImage",
                                      file, shown(header.type)));
    }
    header.component = *component;
    const auto axes = whole_numbers(file, "NDims", require(file, fields, "NDims"));
    if (axes.size() != 1 || axes[0] != header.sizes.size()) {
        throw ImportError(fmt::format("{}: NDims is {}, but DimSize has {} values", file,
                                      shown(require(file, fields, "NDims")), header.sizes.size()));
    }
    const std::string channels = value_or(fields, "elementnumberofchannels", "1");
    if (channels != "1") {
        throw ImportError(fmt::format("{}: ElementNumberOfChannels is {}, a scalar volume has 1",
                                      file, shown(channels)));
    }
    take_frames(file, frame, FourthAxis::time, header);
    header.scale.slope = number(file, "ElementToIntensityFunctionSlope",
                                value_or(fields, "elementtointensityfunctionslope", "1"));
    header.scale.intercept = number(file, "ElementToIntensityFunctionOffset",
                                    value_or(fields, "elementtointensityfunctionoffset", "0"));
    read_place(file, fields, axes[0], header);
    locate_data(path, fields, reader, header);
    keep_files_of_frame(file, header);
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
