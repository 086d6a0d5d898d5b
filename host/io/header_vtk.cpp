// VTK legacy headers: keyword lines up to the scalars of a structured-points data set.
#include <fmt/format.h>

#include <cstdlib>

#include "host/io/header_text.hpp"
#include "host/io/import.hpp"
#include "host/io/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

/// The decoder reads zeros for words that are no numbers, so they are looked at here.
void check_ascii_values(const std::string& file, HeaderReader& reader, std::uint64_t count) {
    std::string word;
    for (std::uint64_t index = 0; index < count; ++index) {
        if (!(reader.stream() >> word)) {
            throw ImportError(
                fmt::format("{}: has {} values, its header states {}", file, index, count));
        }
        char* end = nullptr;
        std::strtod(word.c_str(), &end);
        if (end != word.c_str() + word.size()) {
            throw ImportError(fmt::format("{}: value {} is '{}', must be a number", file, index,
                                          word.substr(0, 40)));
        }
    }
}

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
        if (key == "vectors" || key == "color_scalars" || key == "tensors") {
            throw ImportError(
                fmt::format("{}: its first attribute is {}, must be SCALARS", file, words[0]));
        }
    }
    return fields;
}

void read_scalars(const std::string& file, const Fields& fields, StoredHeader& header) {
    const std::vector<std::string> scalars = words_of(require(file, fields, "SCALARS"));
    if (scalars.size() < 2 || scalar_bytes(scalars[1]) == 0) {
        throw ImportError(fmt::format("{}: SCALARS is '{}', must be a name and a scalar type", file,
                                      require(file, fields, "SCALARS")));
    }
    if (scalars.size() > 2 && scalars[2] != "1") {
        throw ImportError(
            fmt::format("{}: SCALARS has {} components, a volume has 1", file, scalars[2]));
    }
    header.type = scalars[1];
    header.value_bytes = scalar_bytes(scalars[1]);
}

}  // namespace

StoredHeader read_vtk_header(const std::filesystem::path& path) {
    const std::string file = path.string();
    HeaderReader reader(path);
    const Fields fields = read_fields(file, reader);
    const std::string data_set = lower_case(require(file, fields, "DATASET"));
    if (data_set != "structured_points") {
        throw ImportError(fmt::format("{}: DATASET is '{}', must be STRUCTURED_POINTS", file,
                                      require(file, fields, "DATASET")));
    }
    StoredHeader header;
    header.sizes = whole_numbers(file, "DIMENSIONS", require(file, fields, "DIMENSIONS"));
    read_scalars(file, fields, header);
    require(file, fields, "LOOKUP_TABLE");
    header.data_file = path;
    header.data_offset_bytes = reader.offset_bytes();
    header.storage = fields.at("storage") == "binary" ? Storage::raw : Storage::ascii;
    header.spacing_stated = fields.contains("spacing") || fields.contains("aspect_ratio");
    header.notes.emplace_back(
        "VTK files state no patient space: x, y, z are taken as left, posterior, superior");
    check_stored_header(path, header);
    if (header.storage == Storage::ascii) {
        check_ascii_values(file, reader, header.sizes[0] * header.sizes[1] * header.sizes[2]);
    }
    return header;
}

}  // namespace pxpl5::host::io
