// MetaImage headers: "Key = value" lines, the last of which is ElementDataFile.
#include <fmt/format.h>

#include "host/io/header_text.hpp"
#include "host/io/import.hpp"
#include "host/io/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

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

void locate_data(const std::filesystem::path& path, const Fields& fields, std::uint64_t header_end,
                 StoredHeader& header) {
    const std::string file = path.string();
    const std::string name = require(file, fields, "ElementDataFile");
    const bool local = name == "LOCAL" || name == "Local" || name == "local";
    header.data_file = local ? path : path.parent_path() / name;
    header.data_offset_bytes = local ? header_end : 0;
    const bool numbered = name.find('%') != std::string::npos;
    if (numbered && !is_file_pattern(words_of(name).at(0))) {
        throw ImportError(
            fmt::format("{}: ElementDataFile '{}' must be LOCAL, LIST, a name, or a "
                        "pattern with one %d",
                        file, shown(name)));
    }
    const bool many = name == "LIST" || name.starts_with("LIST ") || numbered;
    const bool compressed = lower_case(value_or(fields, "compresseddata", "false")) == "true";
    const bool binary = lower_case(value_or(fields, "binarydata", "true")) == "true";
    header.storage = many         ? Storage::unchecked
                     : compressed ? Storage::compressed
                     : binary     ? Storage::raw
                                  : Storage::ascii;
    const std::string skip = value_or(fields, "headersize", "0");
    header.ends_file = skip != "-1";
    if (skip != "-1" && header.storage == Storage::raw) {
        header.data_offset_bytes += whole_numbers(file, "HeaderSize", skip).at(0);
    }
}

}  // namespace

StoredHeader read_meta_header(const std::filesystem::path& path) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Fields fields = read_fields(reader);
    StoredHeader header;
    header.sizes = whole_numbers(file, "DimSize", require(file, fields, "DimSize"));
    header.type = require(file, fields, "ElementType");
    header.value_bytes = scalar_bytes(header.type);
    if (header.value_bytes == 0) {
        throw ImportError(fmt::format("{}: ElementType '{}' is not a scalar type of MetaImage",
                                      file, header.type));
    }
    const auto axes = whole_numbers(file, "NDims", require(file, fields, "NDims"));
    if (axes.size() != 1 || axes[0] != header.sizes.size()) {
        throw ImportError(fmt::format("{}: NDims is {}, but DimSize has {} values", file,
                                      require(file, fields, "NDims"), header.sizes.size()));
    }
    const std::string channels = value_or(fields, "elementnumberofchannels", "1");
    if (channels != "1") {
        throw ImportError(fmt::format("{}: ElementNumberOfChannels is {}, a scalar volume has 1",
                                      file, channels));
    }
    header.spacing_stated = fields.contains("elementspacing");
    if (!header.spacing_stated && fields.contains("elementsize")) {
        header.spacing_stated = true;
        header.notes.emplace_back("no ElementSpacing: ElementSize is taken as the spacing");
    }
    if (!fields.contains("anatomicalorientation")) {
        header.notes.emplace_back(
            "the header states no AnatomicalOrientation: x, y, z are taken as left, posterior, "
            "superior by its matrix");
    }
    locate_data(path, fields, reader.offset_bytes(), header);
    check_stored_header(path, header);
    if (header.storage == Storage::compressed) {
        // The decoder takes what a cut stream gives and says nothing.
        check_inflated(file, header, header.data_offset_bytes, needed_bytes(header));
    }
    return header;
}

}  // namespace pxpl5::host::io
