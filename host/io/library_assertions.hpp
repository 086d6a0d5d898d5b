// Assertions of libraries of others within this process.
#pragma once

#include <string>
#include <string_view>

namespace pxpl5::host::io {

/// A failed assertion, as the C library reports it.
struct Assertion {
    std::string_view expression;
    std::string_view source;  ///< The file, as the compiler named it.
    unsigned line = 0;
};

/// True if the assertion stands in a source of this program.
bool is_own(const Assertion& assertion);

/// "scan.dcm: the DICOM library (GDCM) refuses this file: ...", without the file if `file` is null.
std::string refusal_of(const Assertion& assertion, const char* file);

}  // namespace pxpl5::host::io
