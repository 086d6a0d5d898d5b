// Programs in files: assembly, binary words, words as hexadecimal text.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "isa/program.hpp"

namespace pxpl5::host::inspect {

/// The whole file; "-" is standard input. Throws RequestError (bad_data) naming file and reason.
std::string read_file(const std::string& path);

/// "name=value" of --param each. Throws RequestError (usage).
isa::Parameters parse_parameters(const std::vector<std::string>& texts);

/// Assembles the text of `path`, fills the parameters in and checks the program.
/// Throws RequestError (bad_data) naming file, line and what is wrong.
std::vector<std::uint32_t> assemble_file(const std::string& path, const std::string& text,
                                         const isa::Parameters& parameters);

enum class WordFormat : std::uint8_t { detect, binary, hex };

/// Words of a file's content: little-endian binary, or text of hexadecimal words between blanks,
/// with comments from ';' to the line's end. Detected: text if nothing but that occurs in it.
/// Throws RequestError (bad_data).
std::vector<std::uint32_t> parse_words(const std::string& path, const std::string& content,
                                       WordFormat format);

/// Little endian, 4 bytes a word.
std::string binary_of(const std::vector<std::uint32_t>& words);
/// One instruction a line, its assembly as a comment behind; parse_words() reads it.
std::string hex_of(const std::vector<std::uint32_t>& words);

}  // namespace pxpl5::host::inspect
