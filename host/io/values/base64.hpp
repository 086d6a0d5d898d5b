// The digits of base64 (RFC 4648).
#pragma once

namespace pxpl5::host::io {

/// Returns the six bits of a digit; -1 for any other character.
constexpr int base64_digit(char c) {
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

}  // namespace pxpl5::host::io
