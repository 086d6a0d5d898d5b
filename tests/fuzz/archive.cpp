// ZIP and tar archives: what is unpacked of them. The DICOM files in them are read by `dicom`.
#include <array>
#include <set>
#include <string>
#include <string_view>

#include "host/io/dicom/dicom_file.hpp"
#include "host/io/packed/packed_files.hpp"
#include "host/io/values/import_request.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/scratch.hpp"
#include "tests/gzip.hpp"

namespace pxpl5::fuzz {

namespace {

using host::io::PackedFiles;

/// How the bytes become an archive.
struct Form {
    char letter;
    bool has_end = false;    ///< The end block of tar follows the bytes.
    bool is_packed = false;  ///< gzip follows the mutation: else its checksum refuses nearly all.
};
constexpr std::array forms = {Form{'a'}, Form{'t', true}, Form{'T', true, true}};
constexpr std::size_t end_block_bytes = 1024;
constexpr std::uint64_t most_bytes = 1 << 20;

/// A name is only shown: nothing is written, so it may have "..".
void require_name(std::string_view name, const std::string& archive) {
    require(name.starts_with(archive + "/"), "a file without the name of its archive");
    const std::string_view inside = name.substr(archive.size());
    require(std::ranges::none_of(inside, [](char c) { return c >= 0 && c < ' '; }),
            "a control character in a name");
}

void check(const PackedFiles& found, const std::string& archive) {
    std::set<std::string> names;
    std::uint64_t bytes = 0;
    for (const host::io::DicomInput& each : found.dicom) {
        require_name(each.path.string(), archive);
        require(names.insert(each.path.string()).second, "two files with one name");
        require(each.bytes && begins_as_dicom(each), "a file that is no DICOM file");
        bytes += each.bytes->size();
    }
    require(bytes <= most_bytes, "more bytes than are allowed");
    for (const std::string& reason : found.unreadable) {
        require(reason.starts_with(archive + "/"), "a reason without the name of the archive");
    }
    const std::size_t all = found.dicom.size() + found.unreadable.size() + found.others;
    require(all + found.links <= host::io::max_packed_entries, "more files than are allowed");
}

}  // namespace

/// Input: a letter of a form, and the bytes.
bool accepts(Input input) {
    static const Scratch scratch;
    Bytes bytes(input);
    const auto form = std::ranges::find(forms, bytes.take<char>(), &Form::letter);
    if (form == forms.end()) {
        return false;
    }
    scratch.clear();
    std::string content = bytes.text();
    if (form->has_end) {
        content.append(end_block_bytes, '\0');
    }
    const std::string path = scratch.write(
        "v", form->is_packed ? test::gzipped_at(scratch.at("packed"), content, "wb1") : content);
    try {
        const PackedFiles found = host::io::unpack(path, most_bytes);
        check(found, path);
        return !found.dicom.empty();
    } catch (const host::io::ImportError& error) {
        require(std::string_view(error.what()).starts_with(path), error.what());
        return false;
    }
}

}  // namespace pxpl5::fuzz
