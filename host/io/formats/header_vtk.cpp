// VTK legacy headers: keyword lines up to the scalars of a structured-points data set.
#include <fmt/format.h>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

Fields read_fields(const std::string& file, HeaderReader& reader) {
    std::string line;
    if (!reader.next(line) || !line.starts_with("# vtk DataFile")) {
        throw ImportError(file + ": does not begin with '# vtk DataFile'");
    }
    reader.next(line);  // The title: any text.
    Fields fields;
    reader.next(line);
    fields["storage"] = lower_case(trimmed(line));
    while (reader.next(line)) {
        const std::vector<std::string> words = words_of(line);
        if (words.empty()) {
            continue;
        }
        const std::string key = lower_case(words[0]);
        fields[key] = trimmed(line.substr(line.find(words[0]) + words[0].size()));
        if (key == "lookup_table") {
            break;
        }
        if (key == "vectors" || key == "color_scalars" || key == "tensors" || key == "field" ||
            key == "cell_data") {
            throw ImportError(
                fmt::format("{}: its first attribute is {}, must be SCALARS of "
                            "POINT_DATA",
                            file, shown(words[0])));
        }
    }
    return fields;
}

void read_scalars(const std::string& file, const Fields& fields, StoredHeader& header) {
    const std::string text = require(file, fields, "SCALARS");
    const std::vector<std::string> scalars = words_of(text);
    if (scalars.size() > 1 && lower_case(scalars[1]) == "bit") {
        throw ImportError(file +
                          ": SCALARS has values of one bit, which are not read: write them as "
                          "unsigned_char");
    }
    const std::optional<Component> component =
        scalars.size() < 2 ? std::nullopt : component_named(scalars[1]);
    if (!component) {
        throw ImportError(fmt::format("{}: SCALARS is '{}', must be a name and a scalar type", file,
                                      shown(text)));
    }
    if (scalars.size() > 2 && scalars[2] != "1") {
        throw ImportError(
            fmt::format("{}: SCALARS has {} components, a volume has 1", file, shown(scalars[2])));
    }
    header.type = scalars[1];
    header.component = *component;
}

void read_place(const std::string& file, const Fields& fields, StoredHeader& header) {
    const bool stated = fields.contains("spacing") || fields.contains("aspect_ratio");
    header.spacing_stated.fill(stated);
    const glm::dvec3 spacing =
        three_numbers(file, "SPACING",
                      value_or(fields, "spacing", value_or(fields, "aspect_ratio", "1 1 1")), 1.0);
    for (int column = 0; column < 3; ++column) {
        header.voxel_to_patient[column] *= spacing[column];
    }
    const glm::dvec3 origin =
        three_numbers(file, "ORIGIN", value_or(fields, "origin", "0 0 0"), 0.0);
    header.voxel_to_patient[3] = glm::dvec4(origin, 1.0);
    header.assumed_directions =
        "VTK files state no patient space: x, y, z are taken as left, posterior, superior";
}

}  // namespace

StoredHeader read_vtk_header(const std::filesystem::path& path) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Fields fields = read_fields(file, reader);
    const std::string data_set = require(file, fields, "DATASET");
    if (lower_case(data_set) != "structured_points") {
        throw ImportError(
            fmt::format("{}: DATASET is '{}', must be STRUCTURED_POINTS", file, shown(data_set)));
    }
    const std::string storage = fields.at("storage");
    if (storage != "ascii" && storage != "binary") {
        throw ImportError(fmt::format("{}: its third line is '{}', must be ASCII or BINARY", file,
                                      shown(storage)));
    }
    StoredHeader header;
    header.sizes = whole_numbers(file, "DIMENSIONS", require(file, fields, "DIMENSIONS"));
    volume_dims(file, header.sizes);
    read_scalars(file, fields, header);
    require(file, fields, "LOOKUP_TABLE");
    const std::string points = value_or(fields, "point_data", "");
    const std::uint64_t values = needed_bytes(header) / component_bytes(header.component);
    if (!points.empty() && points != std::to_string(values)) {
        header.find(FindingKind::note,
                    fmt::format("POINT_DATA is {}, DIMENSIONS {} have {} points", shown(points),
                                join_sizes(header.sizes), values));
    }
    header.data_files = {path};
    header.offset_bytes = reader.offset_bytes();
    header.encoding = storage == "binary" ? Encoding::raw : Encoding::ascii;
    header.big_endian = true;  // By definition of the format.
    read_place(file, fields, header);
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
