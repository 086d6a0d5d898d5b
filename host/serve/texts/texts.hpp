// Texts of the pages that the server writes itself, in the language of the reader.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::serve {

/// A text, and what stands in its places {0}, {1}, ...
struct Text {
    std::string_view english;  ///< One of class_text, which is also the key of the translation.
    std::vector<std::string> parts = {};
};

/// Returns the language of a reader: "en", or another one that has a catalog.
///
/// asked            By the address; empty if the address asks for none.
/// accept_language  Header of the request (RFC 9110, 12.5.4), with the weights of languages.
std::string language_of(std::string_view asked, std::string_view accept_language);

/// Returns whether a language has this text. English has every text.
bool has_text(std::string_view english, std::string_view language);

/// Returns the number of texts that a catalog has; 0 if there is no such catalog.
std::size_t count_of_texts(std::string_view language);

/// Returns the text in a language, or in English if the language does not have it.
std::string text_in(const Text& text, std::string_view language);

}  // namespace pxpl5::host::serve
