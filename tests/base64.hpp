// Base64 for tests.
#pragma once

#include <string>
#include <string_view>

namespace pxpl5::test {

/// The text of RFC 4648, with padding.
inline std::string base64(std::string_view bytes) {
    constexpr std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t b = 0; b < 3; ++b) {
            bits =
                bits << 8 | (i + b < bytes.size() ? static_cast<unsigned char>(bytes[i + b]) : 0);
        }
        for (std::size_t d = 0; d < 4; ++d) {
            text += i + d > bytes.size() ? '=' : digits[bits >> (18 - 6 * d) & 63];
        }
    }
    return text;
}

}  // namespace pxpl5::test
