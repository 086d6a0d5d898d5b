#include "host/inspect/tools/program_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "isa/assemble.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::size_t word_bytes = 4;
constexpr unsigned byte_bits = 8;
constexpr std::size_t max_file_bytes = word_bytes * isa::max_program_words;

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", path, reason));
}

std::string without_comments(const std::string& content) {
    std::string text;
    bool comment = false;
    for (const char c : content) {
        comment = c != '\n' && (comment || c == ';');
        text += comment ? ' ' : c;
    }
    return text;
}

/// A byte that hexadecimal text outside of comments may hold.
bool is_hex_text(char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isxdigit(u) != 0 || std::isspace(u) != 0 || c == 'x' || c == 'X';
}

std::vector<std::uint32_t> parse_hex(const std::string& path, const std::string& text) {
    std::vector<std::uint32_t> words;
    for (std::size_t at = 0; at < text.size();) {
        if (std::isspace(static_cast<unsigned char>(text[at])) != 0) {
            ++at;
            continue;
        }
        const auto end = static_cast<std::size_t>(
            std::find_if(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(),
                         [](unsigned char c) { return std::isspace(c) != 0; }) -
            text.begin());
        std::string_view digits(text.data() + at, end - at);
        if (digits.starts_with("0x") || digits.starts_with("0X")) {
            digits.remove_prefix(2);
        }
        std::uint32_t word = 0;
        const auto [stop, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), word, 16);
        if (error != std::errc{} || stop != digits.data() + digits.size()) {
            refuse(path,
                   fmt::format("line {}: '{}' is no hexadecimal word of 32 bits",
                               1 + std::count(text.begin(),
                                              text.begin() + static_cast<std::ptrdiff_t>(at), '\n'),
                               text.substr(at, end - at)));
        }
        words.push_back(word);
        at = end;
    }
    return words;
}

std::vector<std::uint32_t> parse_binary(const std::string& path, const std::string& content) {
    if (content.size() % word_bytes != 0) {
        refuse(path, fmt::format("{} bytes are no whole number of 4-byte words", content.size()));
    }
    std::vector<std::uint32_t> words(content.size() / word_bytes);
    for (std::size_t i = 0; i < content.size(); ++i) {
        const std::uint32_t byte = static_cast<unsigned char>(content[i]);
        words[i / word_bytes] |= byte << (i % word_bytes * byte_bits);
    }
    return words;
}

/// Reads little more than is allowed, so that a stream without an end is refused.
std::string read_to_end(const std::string& path, std::istream& from) {
    std::string content, piece(std::size_t{1} << 16, '\0');
    while (from && content.size() <= max_file_bytes) {
        from.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        content.append(piece, 0, static_cast<std::size_t>(from.gcount()));
    }
    if (from.bad()) {
        refuse(path, std::strerror(errno));
    }
    if (content.size() > max_file_bytes) {
        refuse(path, fmt::format("more than {} bytes, which is the most that a program may have",
                                 grouped(max_file_bytes)));
    }
    return content;
}

}  // namespace

std::string read_file(const std::string& path) {
    if (path == "-") {
        return read_to_end(path, std::cin);
    }
    if (const std::string reason = why_unreadable(path); !reason.empty()) {
        refuse(path, reason + "; give a file, or - for the standard input");
    }
    std::error_code failure;
    const std::uintmax_t bytes = std::filesystem::file_size(path, failure);
    if (!failure && bytes > max_file_bytes) {
        refuse(path, fmt::format("{} bytes; at most {} are read", grouped(bytes),
                                 grouped(max_file_bytes)));
    }
    std::ifstream file(path, std::ios::binary);
    if (!file.is_open()) {
        refuse(path, std::strerror(errno));
    }
    return read_to_end(path, file);
}

isa::Parameters parse_parameters(const std::vector<std::string>& texts) {
    isa::Parameters parameters;
    for (const std::string& text : texts) {
        const std::size_t equals = text.find('=');
        std::string_view digits(text);
        digits.remove_prefix(equals == std::string::npos ? text.size() : equals + 1);
        const bool is_hex = digits.starts_with("0x");
        digits.remove_prefix(is_hex ? 2 : 0);
        std::int64_t value = 0;
        const char* end = digits.data() + digits.size();
        const auto [stop, error] = std::from_chars(digits.data(), end, value, is_hex ? 16 : 10);
        if (equals == 0 || error != std::errc{} || stop != end) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("--param '{}'; it must be name=number, e.g. level=12", text));
        }
        parameters[text.substr(0, equals)] = value;
    }
    return parameters;
}

std::vector<std::uint32_t> assemble_file(const std::string& path, const std::string& text,
                                         const isa::Parameters& parameters) {
    try {
        std::vector<std::uint32_t> words = isa::assemble(text).bind(parameters);
        if (const auto error = isa::check(words).error) {
            refuse(path, fmt::format("word {}: {}", error->word, error->text));
        }
        return words;
    } catch (const isa::AssemblyError& error) {
        refuse(path, error.what());
    } catch (const isa::ParameterError& error) {
        refuse(path, fmt::format("{} (--param name=value)", error.what()));
    }
}

std::vector<std::uint32_t> parse_words(const std::string& path, const std::string& content,
                                       WordFormat format) {
    const std::string text = format == WordFormat::binary ? "" : without_comments(content);
    const bool is_hex = format == WordFormat::hex ||
                        (format == WordFormat::detect && std::ranges::all_of(text, is_hex_text));
    return is_hex ? parse_hex(path, text) : parse_binary(path, content);
}

std::string binary_of(const std::vector<std::uint32_t>& words) {
    std::string bytes;
    bytes.reserve(words.size() * word_bytes);
    for (const std::uint32_t word : words) {
        for (unsigned byte = 0; byte < word_bytes; ++byte) {
            bytes += static_cast<char>(word >> (byte * byte_bits) & 0xFFU);
        }
    }
    return bytes;
}

std::string hex_of(const std::vector<std::uint32_t>& words) {
    std::string text;
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t count = std::max<std::size_t>(isa::instruction_words(words[at]), 1);
        const std::size_t end = std::min(at + count, words.size());
        std::string line;
        for (std::size_t i = at; i < end; ++i) {
            line += fmt::format("{:08x} ", words[i]);
        }
        const std::span<const std::uint32_t> one(words.data() + at, end - at);
        text += fmt::format("{:<36}; {}", line, isa::disassemble(one));
        at = end;
    }
    return text;
}

}  // namespace pxpl5::host::inspect
