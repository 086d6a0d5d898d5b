#include "host/io/library_assertions.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <cstdio>
#include <cstdlib>

#include "host/io/values/file_at_work.hpp"

namespace pxpl5::host::io {

namespace {

/// The folder of this program's sources, as the compiler names it.
constexpr std::string_view own_folder() {
    constexpr std::string_view here = __FILE__, name = "host/io/library_assertions.cpp";
    return here.substr(0, here.size() - name.size());
}

}  // namespace

bool is_own(const Assertion& assertion) {
    return assertion.source.starts_with(own_folder());
}

std::string refusal_of(const Assertion& assertion, const char* file) {
    const std::string_view source = assertion.source.substr(assertion.source.rfind('/') + 1);
    return fmt::format(
        "{}{}{} refuses this file: its check '{}' fails ({}:{}). The file may be damaged; if other "
        "programs read it, convert it with one of them",
        file == nullptr ? "" : file, file == nullptr ? "" : ": ",
        source.starts_with("gdcm") ? "the DICOM library (GDCM)" : "a library", assertion.expression,
        source, assertion.line);
}

}  // namespace pxpl5::host::io

/// Takes the place of the C library's function. A library's assertion is not an error of this
/// program: the host reports the last line of the log, and exit code 65 means bad data.
extern "C" void __assert_fail(  // NOLINT(bugprone-reserved-identifier): the name is given.
    const char* expression, const char* source, unsigned line, const char* function) noexcept {
    using namespace pxpl5::host::io;
    constexpr int bad_data = 65;
    const Assertion assertion{expression, source, line};
    if (is_own(assertion)) {
        std::fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", source, line, function,
                     expression);
        std::abort();
    }
    std::fprintf(stderr, "%s\n", refusal_of(assertion, file_at_work).c_str());
    std::fflush(stderr);
    _exit(bad_data);
}
