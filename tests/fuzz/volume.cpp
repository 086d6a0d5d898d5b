// Volume files: the header and the values of each format, through the whole import.
#include <array>

#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/imported.hpp"
#include "tests/fuzz/scratch.hpp"
#include "tests/gzip.hpp"

namespace pxpl5::fuzz {

namespace {

/// A format: the name of the file, and of a second file with the values if there is one.
struct Form {
    char letter;
    const char *name, *values;
    bool is_packed = false;  ///< The file is compressed by gzip after the mutation.
};
constexpr std::array forms = {
    Form{'n', "v.nii", nullptr},          Form{'z', "v.nii.gz", nullptr},
    Form{'Z', "v.nii.gz", nullptr, true}, Form{'r', "v.nrrd", nullptr},
    Form{'R', "v.nhdr", "v.raw"},         Form{'m', "v.mha", nullptr},
    Form{'M', "v.mhd", "v.raw"},          Form{'a', "v.hdr", "v.img"},
    Form{'g', "v.mgh", nullptr},          Form{'G', "v.mgz", nullptr, true},
    Form{'v', "v.vtk", nullptr},          Form{'x', "v.vti", nullptr},
    Form{'w', "v.raw", nullptr},          Form{'?', "v", nullptr},
};
constexpr std::size_t analyze_bytes = 348;  ///< Size of an Analyze header.
constexpr char next_file = 0x1e;            ///< Precedes the values behind a text header.

host::io::RawLayout layout(Bytes& bytes) {
    constexpr std::array types = {"uint8", "int8",   "uint16",  "int16",
                                  "int32", "uint32", "float32", "float64"};
    host::io::RawLayout raw;
    for (std::uint32_t& size : raw.dims) {
        size = bytes.take<std::uint8_t>();
    }
    raw.type = types.at(bytes.take<std::uint8_t>() % types.size());
    raw.big_endian = bytes.take<std::uint8_t>() % 2 != 0;
    raw.offset_bytes = bytes.take<std::uint8_t>();
    return raw;
}

}  // namespace

/// Input: a letter of a format, the processing, and the file.
bool accepts(Input input) {
    static const Scratch scratch;
    Bytes bytes(input);
    const auto form = std::ranges::find(forms, bytes.take<char>(), &Form::letter);
    if (form == forms.end()) {
        return false;
    }
    host::io::ImportRequest request;
    add_processing(bytes, request);
    if (form->letter == 'w') {
        request.raw = layout(bytes);
    }
    scratch.clear();
    std::string header = bytes.text();
    if (form->values != nullptr) {
        const std::size_t end =
            form->letter == 'a' ? analyze_bytes : std::min(header.find(next_file), header.size());
        scratch.write(form->values, header.substr(std::min(end, header.size())));
        header.resize(std::min(end, header.size()));
    }
    request.path = scratch.write(
        form->name,
        form->is_packed ? test::gzipped_at(scratch.at("packed"), header, "wb1") : header);
    return imports(request);
}

}  // namespace pxpl5::fuzz
