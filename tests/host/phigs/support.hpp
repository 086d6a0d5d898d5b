// Archives in tests: parse or flatten a text, or say why not.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "host/base/error.hpp"
#include "host/phigs/content.hpp"

namespace pxpl5::test {

namespace phigs = host::phigs;

inline phigs::Content content_of(const std::string& text) {
    return phigs::flatten(phigs::parse_archive(text, "a.phigs"));
}

/// Elements within one posted structure.
inline std::string posted(const std::string& elements) {
    return "structure s posted { " + elements + " };";
}

/// Why the text is refused; empty if it is not.
inline std::string refusal(const std::string& text) {
    try {
        content_of(text);
    } catch (const host::RequestError& error) {
        CHECK(error.code == host::ExitCode::bad_data);
        return error.what();
    }
    return {};
}

}  // namespace pxpl5::test
