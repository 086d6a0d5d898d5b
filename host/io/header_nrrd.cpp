// NRRD headers: "key: value" lines up to an empty line.
#include <fmt/format.h>

#include "host/io/header_text.hpp"
#include "host/io/import.hpp"
#include "host/io/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

Fields read_fields(const std::string& file, HeaderReader& reader) {
    std::string line;
    if (!reader.next(line) || !line.starts_with("NRRD000")) {
        throw ImportError(fmt::format("{}: begins with '{}', a NRRD file with 'NRRD000'", file,
                                      shown(trimmed(line.substr(0, 16)))));
    }
    Fields fields;
    while (reader.next(line) && !trimmed(line).empty()) {
        const std::size_t colon = line.find(':');
        const bool is_comment = line.starts_with('#');
        // "key:=value" is the user's own key and no field of the format.
        const bool is_pair = colon != std::string::npos && line.substr(colon, 2) == ":=";
        if (!is_comment && !is_pair && colon != std::string::npos) {
            fields[lower_case(trimmed(line.substr(0, colon)))] = trimmed(line.substr(colon + 1));
        }
    }
    return fields;
}

Storage storage_of(const std::string& file, const std::string& encoding) {
    const std::string name = lower_case(encoding);
    if (name == "raw") {
        return Storage::raw;
    }
    if (name == "ascii" || name == "txt" || name == "text") {
        return Storage::ascii;
    }
    if (name == "gzip" || name == "gz") {
        return Storage::compressed;
    }
    if (name == "hex") {
        return Storage::unchecked;
    }
    throw ImportError(
        fmt::format("{}: encoding is '{}', must be raw, ascii, hex or gzip", file, encoding));
}

/// Where the values are: in this file, in another, or in many.
void locate_data(const std::filesystem::path& path, const Fields& fields, std::uint64_t header_end,
                 StoredHeader& header) {
    const std::string data_file = value_or(fields, "data file", value_or(fields, "datafile", ""));
    const std::string byte_skip = value_or(fields, "byte skip", value_or(fields, "byteskip", "0"));
    const std::string line_skip = value_or(fields, "line skip", value_or(fields, "lineskip", "0"));
    if (byte_skip.starts_with('-') && byte_skip != "-1") {
        throw ImportError(
            fmt::format("{}: byte skip is {}, must be -1 or more", path.string(), byte_skip));
    }
    const std::vector<std::string> names = words_of(data_file);
    const bool many = !names.empty() && (lower_case(names[0]) == "list" || names.size() > 1);
    if (many && lower_case(names[0]) != "list" && !is_file_pattern(names[0]) &&
        !std::filesystem::exists(path.parent_path() / data_file)) {
        throw ImportError(fmt::format("{}: data file '{}' must be a name, or a pattern with one %d",
                                      path.string(), shown(data_file)));
    }
    header.data_file = data_file.empty() ? path : path.parent_path() / data_file;
    header.data_offset_bytes = data_file.empty() ? header_end : 0;
    header.ends_file = byte_skip == "0" && line_skip == "0";
    if (many && !std::filesystem::exists(header.data_file)) {
        header.storage = Storage::unchecked;
    } else if (header.storage == Storage::raw && byte_skip != "-1") {
        header.data_offset_bytes += whole_numbers(path.string(), "byte skip", byte_skip).at(0);
    }
    if (header.storage == Storage::raw && line_skip != "0") {
        header.data_offset_bytes += whole_numbers(path.string(), "line skip", line_skip).at(0);
    }
}

void note_place(const Fields& fields, StoredHeader& header) {
    const std::string directions = value_or(fields, "space directions", "");
    header.spacing_stated = !directions.empty() || fields.contains("spacings");
    const std::string space = lower_case(value_or(fields, "space", ""));
    if (space.empty()) {
        header.notes.emplace_back(
            "the header states no patient space: x, y, z are taken as left, posterior, superior");
    } else if (space.find("left-") != 0 && space.find("right-") != 0 && space.size() > 4) {
        header.notes.push_back(fmt::format(
            "space is '{}', no patient space: x, y, z are taken as left, posterior, superior",
            space));
    }
    const std::string units = value_or(fields, "space units", "");
    if (!units.empty() && units.find("\"mm\"") == std::string::npos) {
        header.notes.push_back(fmt::format("space units are {}: read as millimetres", units));
    }
}

}  // namespace

StoredHeader read_nrrd_header(const std::filesystem::path& path) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Fields fields = read_fields(file, reader);
    StoredHeader header;
    header.sizes = whole_numbers(file, "sizes", require(file, fields, "sizes"));
    header.type = require(file, fields, "type");
    header.value_bytes = scalar_bytes(header.type);
    if (header.value_bytes == 0) {
        throw ImportError(
            fmt::format("{}: type '{}' is not a scalar type of NRRD", file, header.type));
    }
    const auto dimension = whole_numbers(file, "dimension", require(file, fields, "dimension"));
    if (dimension.size() != 1 || dimension[0] != header.sizes.size()) {
        throw ImportError(fmt::format("{}: dimension is {}, but sizes has {} values", file,
                                      require(file, fields, "dimension"), header.sizes.size()));
    }
    header.storage = storage_of(file, require(file, fields, "encoding"));
    locate_data(path, fields, reader.offset_bytes(), header);
    check_stored_header(path, header);
    note_place(fields, header);
    return header;
}

}  // namespace pxpl5::host::io
