// DICOM files: our own checks of their structure, then the whole import.
#include "host/io/dicom/dicom_structure.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/imported.hpp"
#include "tests/fuzz/scratch.hpp"

namespace pxpl5::fuzz {

namespace {

constexpr std::string_view next_file = "\xff\xff-next-file-\xff\xff";

/// Elements behind the preamble, which is the same in each file.
std::string file_of(std::string_view elements) {
    return std::string(128, '\0').append("DICM").append(elements);
}

std::vector<std::string> files_of(std::string_view bytes) {
    std::vector<std::string> files;
    for (std::size_t at = 0; at != std::string_view::npos;) {
        const std::size_t end = bytes.find(next_file, at);
        files.push_back(file_of(bytes.substr(at, end - at)));
        at = end == std::string_view::npos ? end : end + next_file.size();
    }
    return files;
}

void check_structure(const std::string& path, std::size_t size) {
    try {
        const host::io::PixelBytes pixels = host::io::check_dicom_structure(path);
        require(pixels.left <= size, "pixels beyond the end of a file");
    } catch (const host::io::ImportError& error) {
        require(std::string(error.what()).starts_with(path), error.what());
    }
}

}  // namespace

/// Input: the processing, then the elements of one file, or of several with a mark between them.
bool accepts(Input input) {
    static const Scratch scratch;
    scratch.clear();
    Bytes bytes(input);
    host::io::ImportRequest request;
    add_processing(bytes, request);
    const std::vector<std::string> files = files_of(bytes.text());
    for (std::size_t i = 0; i < files.size(); ++i) {
        request.path = scratch.write(fmt::format("{:03}.dcm", i), files[i]);
        check_structure(request.path, files[i].size());
    }
    if (files.size() > 1) {
        request.path = scratch.path().string() + "/.";
    }
    return imports(request);
}

}  // namespace pxpl5::fuzz
