// DICOM files: our own checks of their structure, then the whole import.
#include "host/io/dicom/dicom_structure.hpp"

#include <fmt/format.h>

#include <csetjmp>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/dicom_file.hpp"
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

/// Attributes are few and short, whatever a file has.
void read_all_attributes(const std::string& path) {
    if (!host::io::begins_as_dicom(path)) {
        return;
    }
    try {
        const host::io::DicomAttributes found = host::io::read_attributes(path);
        require(found.all.size() <= host::io::max_dicom_attributes, "too many attributes");
        for (const host::io::DicomAttribute& each : found.all) {
            require(each.value.size() <= 4 * host::io::max_value_chars, "a long value");
        }
    } catch (const host::io::ImportError& error) {
        require(std::string(error.what()).starts_with(path), error.what());
    }
}

/// The end of an input on which a library asserts. pxpl5-io ends there, and the host continues.
sigjmp_buf refusal;
bool is_importing = false;
bool has_left = false;  ///< The objects of an import were left behind.

/// The folder of this program's sources, as the compiler names it.
constexpr std::string_view own_folder() {
    constexpr std::string_view here = __FILE__, name = "tests/fuzz/dicom.cpp";
    return here.substr(0, here.size() - name.size());
}

/// Reads the attributes of the file, and imports(), but an assertion of a library is a refusal.
bool imports_or_asserts(const std::string& file, const host::io::ImportRequest& request) {
    if (sigsetjmp(refusal, 0) != 0) {
        is_importing = false;
        return false;
    }
    is_importing = true;
    read_all_attributes(file);
    const bool accepted = imports(request);
    is_importing = false;
    return accepted;
}

/// Leaves the import unless the assertion is this program's own.
[[noreturn]] void leave(const char* expression, const char* source, unsigned line) {
    std::fprintf(stderr, "assertion at %s:%u: %s\n", source, line, expression);
    if (!is_importing || std::string_view(source).starts_with(own_folder())) {
        std::abort();
    }
    has_left = true;
    siglongjmp(refusal, 1);
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
    const std::string last = request.path;
    if (files.size() > 1) {
        request.path = scratch.path().string() + "/.";
    }
    return imports_or_asserts(last, request);
}

}  // namespace pxpl5::fuzz

/// Takes the place of the C library's function, also for the libraries that this program loads.
extern "C" void __assert_fail(  // NOLINT(bugprone-reserved-identifier): the name is given.
    const char* expression, const char* source, unsigned line, const char*) noexcept {
    pxpl5::fuzz::leave(expression, source, line);
}

/// Asked by LeakSanitizer. pxpl5-io ends with the assertion, and so do its objects.
extern "C" int __lsan_is_turned_off() {  // NOLINT(bugprone-reserved-identifier)
    return pxpl5::fuzz::has_left ? 1 : 0;
}
