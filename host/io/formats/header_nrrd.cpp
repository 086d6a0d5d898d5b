// NRRD headers: "key: value" lines up to an empty line.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

/// The fields, and the files of a "data file: LIST".
struct Header {
    std::string file;
    Fields fields;
    std::vector<fs::path> listed_files;

    std::string any(const char* key, const char* other_key, const std::string& otherwise) const {
        return value_or(fields, key, value_or(fields, other_key, otherwise));
    }
};

Header read_fields(const fs::path& path, HeaderReader& reader) {
    Header header{path.string(), {}, {}};
    std::string line;
    if (!reader.next(line) || !line.starts_with("NRRD000")) {
        throw ImportError(fmt::format("{}: begins with '{}', a NRRD file with 'NRRD000'",
                                      header.file, shown(trimmed(line.substr(0, 16)))));
    }
    bool lists_files = false;
    while (reader.next(line) && (!trimmed(line).empty() || lists_files)) {
        if (lists_files) {
            if (!trimmed(line).empty() && header.listed_files.size() < max_data_files) {
                header.listed_files.push_back(path.parent_path() / trimmed(line));
            }
            continue;
        }
        const std::size_t colon = line.find(':');
        const bool is_comment = line.starts_with('#');
        // "key:=value" is the user's own key and no field of the format.
        const bool is_pair = colon != std::string::npos && line.substr(colon, 2) == ":=";
        if (is_comment || is_pair || colon == std::string::npos) {
            continue;
        }
        const std::string key = lower_case(trimmed(line.substr(0, colon)));
        const std::string value = trimmed(line.substr(colon + 1));
        header.fields[key] = value;
        lists_files =
            (key == "data file" || key == "datafile") && lower_case(value).starts_with("list");
    }
    return header;
}

Encoding encoding_of(const std::string& file, const std::string& encoding) {
    const std::string name = lower_case(encoding);
    if (name == "raw") {
        return Encoding::raw;
    }
    if (name == "ascii" || name == "txt" || name == "text") {
        return Encoding::ascii;
    }
    if (name == "gzip" || name == "gz") {
        return Encoding::gzip;
    }
    if (name == "bzip2" || name == "bz2") {
        return Encoding::bzip2;
    }
    if (name == "hex") {
        return Encoding::hex;
    }
    throw ImportError(fmt::format("{}: encoding is '{}', must be raw, ascii, hex, gzip or bzip2",
                                  file, shown(encoding)));
}

std::uint64_t whole(const std::string& file, const std::string& field, const std::string& text) {
    const auto values = whole_numbers(file, field, text);
    if (values.size() != 1) {
        throw ImportError(
            fmt::format("{}: {} is '{}', must be a whole number", file, field, shown(text)));
    }
    return values[0];
}

/// Where the values are: in this file, in another, or in many.
void locate_data(const fs::path& path, const Header& text, std::uint64_t header_end,
                 StoredHeader& header) {
    const std::string data_file = text.any("data file", "datafile", "");
    const std::string byte_skip = text.any("byte skip", "byteskip", "0");
    const std::string line_skip = text.any("line skip", "lineskip", "0");
    const std::vector<std::string> words = words_of(data_file);
    if (data_file.empty()) {
        header.data_files = {path};
        header.offset_bytes = header_end;
    } else if (words.empty()) {
        throw ImportError(fmt::format("{}: data file is '{}', must be a name, a pattern or LIST",
                                      text.file, shown(data_file)));
    } else if (lower_case(words[0]) == "list") {
        header.data_files = text.listed_files;
    } else if (words.size() > 1 && !fs::exists(path.parent_path() / data_file)) {
        header.data_files = numbered_files(path, "data file", data_file);
    } else {
        header.data_files = {path.parent_path() / data_file};
    }
    if (byte_skip.starts_with('-') && byte_skip != "-1") {
        throw ImportError(
            fmt::format("{}: byte skip is {}, must be -1 or more", text.file, shown(byte_skip)));
    }
    header.at_end = byte_skip == "-1" && header.encoding != Encoding::ascii;
    header.byte_skip = byte_skip == "-1" ? 0 : whole(text.file, "byte skip", byte_skip);
    header.line_skip = whole(text.file, "line skip", line_skip);
    header.ends_file = byte_skip == "0" && line_skip == "0";
}

void read_endian(const Header& text, StoredHeader& header) {
    const bool matters =
        component_bytes(header.component) > 1 && header.encoding != Encoding::ascii;
    const std::string endian =
        lower_case(matters ? require(text.file, text.fields, "endian") : std::string("little"));
    if (endian != "little" && endian != "big") {
        throw ImportError(
            fmt::format("{}: endian is '{}', must be little or big", text.file, shown(endian)));
    }
    header.big_endian = endian == "big";
}

/// "(1,0,0) none (0,1,0)": the vector of each axis, nothing for none.
std::vector<std::optional<std::vector<double>>> vectors_of(const std::string& file,
                                                           const std::string& field,
                                                           const std::string& text) {
    std::vector<std::optional<std::vector<double>>> vectors;
    for (std::size_t at = text.find_first_not_of(" \t"); at != std::string::npos;
         at = text.find_first_not_of(" \t", at)) {
        if (lower_case(text.substr(at, 4)) == "none") {
            vectors.emplace_back(std::nullopt);
            at += 4;
            continue;
        }
        const std::size_t end = text.find(')', at);
        if (text[at] != '(' || end == std::string::npos) {
            throw ImportError(fmt::format("{}: {} is '{}', must be vectors like (1,0,0)", file,
                                          field, shown(text)));
        }
        std::string inside = text.substr(at + 1, end - at - 1);
        std::replace(inside.begin(), inside.end(), ',', ' ');
        vectors.emplace_back(numbers(file, field, inside));
        at = end + 1;
    }
    return vectors;
}

/// Signs that take the header's space to LPS.
glm::dvec3 signs_to_lps(const Header& text, StoredHeader& header) {
    const std::string space = lower_case(value_or(text.fields, "space", ""));
    if (space.empty()) {
        header.assumed_directions =
            "the header states no patient space: x, y, z are taken as left, posterior, superior";
        return {1, 1, 1};
    }
    const bool short_name = space.size() <= 4;
    const auto is = [&](const char* words, const char* letters) {
        return space.starts_with(words) || (short_name && space.starts_with(letters));
    };
    if (is("right-anterior-superior", "ras")) {
        return {-1, -1, 1};
    }
    if (is("left-anterior-superior", "las")) {
        return {1, -1, 1};
    }
    if (!is("left-posterior-superior", "lps")) {
        header.find(FindingKind::assumption,
                    fmt::format("space is '{}', no patient space: x, y, z are taken as left, "
                                "posterior, superior",
                                shown(space)));
    }
    return {1, 1, 1};
}

/// Millimeters of a unit; 0 if it is none that is known.
double millimeters(const std::string& unit) {
    return unit == "mm" ? 1 : unit == "cm" ? 10 : unit == "m" ? 1000 : unit == "um" ? 1e-3 : 0;
}

/// The factor from the header's unit of length to millimeters.
double unit_factor(const Header& text, StoredHeader& header) {
    std::string units = value_or(text.fields, "space units", value_or(text.fields, "units", ""));
    if (units.empty()) {
        return 1;
    }
    std::replace(units.begin(), units.end(), '"', ' ');
    const std::vector<std::string> words = words_of(units);
    if (words.empty()) {
        header.find(FindingKind::note, "space units name no unit of length: read as millimeters");
        return 1;
    }
    const double factor = millimeters(words[0]);
    const bool alike = std::all_of(words.begin(), words.end(), [&](const std::string& word) {
        return word == words[0] || millimeters(word) == 0;
    });
    if (factor == 0 || !alike) {
        header.find(
            FindingKind::assumption,
            fmt::format("space units are '{}': read as millimeters", shown(trimmed(units))));
        return 1;
    }
    if (factor != 1) {
        header.find(FindingKind::conversion,
                    fmt::format("lengths in {} are converted to millimeters", words[0]));
    }
    return factor;
}

glm::dvec4 lps(const std::string& file, const std::string& field, const std::vector<double>& v,
               glm::dvec3 factors) {
    if (v.size() < 2 || v.size() > 4) {
        throw ImportError(
            fmt::format("{}: a vector of {} has {} numbers, must be 3", file, field, v.size()));
    }
    return {v[0] * factors.x, v[1] * factors.y, (v.size() > 2 ? v[2] : 0) * factors.z, 0};
}

/// The axes of the volume: all, or of more than three those that are not of size 1 outside space.
std::vector<std::size_t> volume_axes(
    const std::vector<std::uint64_t>& sizes,
    const std::vector<std::optional<std::vector<double>>>& directions) {
    std::vector<std::size_t> axes;
    for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
        const bool outside = axis < directions.size() && !directions[axis];
        if (!(outside && sizes[axis] == 1 && sizes.size() > 3)) {
            axes.push_back(axis);
        }
    }
    return axes;
}

/// The kind of an axis in small letters; "none" if the header states none.
std::string kind_of_axis(const Header& text, std::size_t axis) {
    const std::vector<std::string> kinds = words_of(value_or(text.fields, "kinds", ""));
    return axis < kinds.size() ? lower_case(kinds[axis]) : "none";
}

/// Milliseconds between the volumes along `axis`; 0 if the header does not state them in seconds or
/// milliseconds.
double frame_ms_of(const Header& text, std::size_t axis, const std::vector<double>& spacings) {
    std::string units = value_or(text.fields, "units", "");
    std::vector<std::string> quoted;  // "mm" "mm" "" "s": one for each axis.
    for (std::size_t from = units.find('"'); from != std::string::npos;
         from = units.find('"', from)) {
        const std::size_t to = units.find('"', from + 1);
        if (to == std::string::npos) {
            break;
        }
        quoted.push_back(units.substr(from + 1, to - from - 1));
        from = to + 1;
    }
    if (axis >= quoted.size() || axis >= spacings.size() || !(spacings[axis] > 0) ||
        !std::isfinite(spacings[axis])) {
        return 0;
    }
    return quoted[axis] == "s" ? 1000 * spacings[axis] : quoted[axis] == "ms" ? spacings[axis] : 0;
}

/// Throws ImportError if an axis before the last is not in space, or the last one is of vectors or
/// colors.
void check_order(const Header& text, const std::vector<std::uint64_t>& sizes,
                 const std::vector<std::optional<std::vector<double>>>& directions) {
    for (std::size_t axis = 0; axis < sizes.size() && sizes.size() > 3; ++axis) {
        const std::string kind = kind_of_axis(text, axis);
        const bool may_be_space =
            kind == "domain" || kind == "space" || kind == "???" || kind == "none";
        const bool is_outside = (axis < directions.size() && !directions[axis]) || !may_be_space;
        const bool is_series =
            axis + 1 == sizes.size() && (may_be_space || kind == "time" || kind == "list");
        if (is_outside && !is_series && sizes[axis] > 1) {
            throw ImportError(
                fmt::format("{}: has {} axes ({}), of which axis {} is not in space: vectors and "
                            "color are not read, and the volumes of a time series must be the last "
                            "axis",
                            text.file, sizes.size(), join_sizes(sizes), axis + 1));
        }
    }
}

void read_place(const Header& text, std::uint32_t frame, StoredHeader& header) {
    const auto directions =
        vectors_of(text.file, "space directions", value_or(text.fields, "space directions", ""));
    const std::vector<std::uint64_t> stated = header.sizes;
    const std::vector<std::size_t> axes = volume_axes(stated, directions);
    header.sizes.clear();
    for (const std::size_t axis : axes) {
        header.sizes.push_back(stated[axis]);
    }
    check_order(text, stated, directions);
    take_frames(text.file, frame,
                axes.size() == 4 && kind_of_axis(text, axes[3]) == "time" ? FourthAxis::time
                                                                          : FourthAxis::unknown,
                header);
    const auto spacings = numbers(text.file, "spacings", value_or(text.fields, "spacings", ""));
    if (axes.size() == 4) {
        header.frame_ms = frame_ms_of(text, axes[3], spacings);
    }
    const glm::dvec3 factors = signs_to_lps(text, header) * unit_factor(text, header);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t axis = i < axes.size() ? axes[i] : stated.size();
        const int column = static_cast<int>(i);
        const bool has_vector = axis < directions.size() && directions[axis];
        const bool has_spacing = axis < spacings.size() && !std::isnan(spacings[axis]);
        header.spacing_stated[i] = has_vector || has_spacing;
        if (has_vector) {
            header.voxel_to_patient[column] =
                lps(text.file, "space directions", *directions[axis], factors);
        } else if (has_spacing) {
            header.voxel_to_patient[column] *= spacings[axis] * std::abs(factors[column]);
        }
    }
    const auto origin =
        vectors_of(text.file, "space origin", value_or(text.fields, "space origin", ""));
    if (!origin.empty() && origin[0]) {
        header.voxel_to_patient[3] = lps(text.file, "space origin", *origin[0], factors);
        header.voxel_to_patient[3].w = 1;
    }
}

}  // namespace

StoredHeader read_nrrd_header(const fs::path& path, const AllowedFolders& allowed,
                              std::uint32_t frame) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Header text = read_fields(path, reader);
    StoredHeader header;
    header.allowed = allowed;
    header.sizes = whole_numbers(file, "sizes", require(file, text.fields, "sizes"));
    header.type = require(file, text.fields, "type");
    const std::optional<Component> component = component_named(header.type);
    if (!component) {
        throw ImportError(
            fmt::format("{}: type '{}' is not a scalar type of NRRD", file, shown(header.type)));
    }
    header.component = *component;
    const std::uint64_t axes = whole(file, "dimension", require(file, text.fields, "dimension"));
    if (axes != header.sizes.size()) {
        throw ImportError(fmt::format("{}: dimension is {}, but sizes has {} values", file, axes,
                                      header.sizes.size()));
    }
    header.encoding = encoding_of(file, require(file, text.fields, "encoding"));
    read_place(text, frame, header);
    read_endian(text, header);
    locate_data(path, text, reader.offset_bytes(), header);
    keep_files_of_frame(file, header);
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
