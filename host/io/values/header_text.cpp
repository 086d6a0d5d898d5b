#include "host/io/values/header_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <sstream>

#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t max_shown_chars = 80, max_file_name_chars = 255;

}  // namespace

std::string lower_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) {
        return {};
    }
    return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::vector<std::string> words_of(std::string_view text) {
    std::istringstream stream{std::string(text)};
    std::vector<std::string> words;
    for (std::string word; stream >> word;) {
        words.push_back(word);
    }
    return words;
}

std::string shown(std::string_view text) {
    std::string printable(text.substr(0, max_shown_chars));
    std::replace_if(
        printable.begin(), printable.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
    return text.size() > max_shown_chars ? printable + "..." : printable;
}

bool is_file_pattern(const std::string& name) {
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos || name.size() > max_file_name_chars) {
        return false;
    }
    const std::size_t end = name.find_first_not_of("0123456789", percent + 1);
    return end != std::string::npos && end - percent <= 3 && name[end] == 'd' &&
           name.find('%', end) == std::string::npos;
}

std::vector<std::uint64_t> whole_numbers(const std::string& file, const std::string& field,
                                         const std::string& text) {
    std::vector<std::uint64_t> numbers;
    for (const std::string& word : words_of(text)) {
        std::uint64_t number = 0;
        const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (failure != std::errc{} || end != word.data() + word.size()) {
            throw ImportError(
                fmt::format("{}: {} is '{}', must be whole numbers", file, field, shown(text)));
        }
        numbers.push_back(number);
    }
    return numbers;
}

HeaderReader::HeaderReader(const std::filesystem::path& path)
    : file_(path.string()), stream_(path, std::ios::binary) {
    if (!stream_) {
        throw ImportError(file_ + ": cannot be opened");
    }
}

bool HeaderReader::next(std::string& line) {
    line.clear();
    if (++lines_ > max_header_lines) {
        throw ImportError(fmt::format("{}: more than {} header lines", file_, max_header_lines));
    }
    for (int c = stream_.get(); c != std::ifstream::traits_type::eof(); c = stream_.get()) {
        ++offset_bytes_;
        if (c == '\n') {
            return true;
        }
        line.push_back(static_cast<char>(c));
        if (line.size() > max_header_line_bytes) {
            throw ImportError(fmt::format("{}: header line {} has more than {} bytes", file_,
                                          lines_, max_header_line_bytes));
        }
    }
    return !line.empty();
}

const std::string& require(const std::string& file, const Fields& fields, const std::string& key) {
    const auto found = fields.find(lower_case(key));
    if (found == fields.end()) {
        throw ImportError(fmt::format("{}: its header has no '{}'", file, key));
    }
    return found->second;
}

std::string value_or(const Fields& fields, const std::string& key, const std::string& otherwise) {
    const auto found = fields.find(key);
    return found == fields.end() ? otherwise : found->second;
}

double number(const std::string& file, const std::string& field, const std::string& text) {
    const std::string word = trimmed(text);
    const char* begin = word.c_str() + (word.starts_with('+') ? 1 : 0);
    double value = 0;
    const auto [end, failure] = std::from_chars(begin, word.c_str() + word.size(), value);
    if (failure != std::errc{} || end != word.c_str() + word.size() || word.empty()) {
        throw ImportError(
            fmt::format("{}: {} is '{}', must be a number", file, field, shown(text)));
    }
    return value;
}

std::vector<double> numbers(const std::string& file, const std::string& field,
                            const std::string& text) {
    std::vector<double> values;
    for (const std::string& word : words_of(text)) {
        values.push_back(number(file, field, word));
    }
    return values;
}

glm::dvec3 three_numbers(const std::string& file, const std::string& field, const std::string& text,
                         double otherwise) {
    const std::vector<double> values = numbers(file, field, text);
    if (values.size() < 2 || values.size() > 4) {
        throw ImportError(
            fmt::format("{}: {} is '{}', must be 3 numbers", file, field, shown(text)));
    }
    return {values[0], values[1], values.size() > 2 ? values[2] : otherwise};
}

void check_volume_bytes(const std::string& file, const std::string& dims, std::uint64_t needed) {
    if (needed > max_volume_bytes) {
        throw ImportError(
            fmt::format("{}: {} need {} bytes, at most {} are read: write a smaller file first, a "
                        "part or every "
                        "second voxel (crop= and resample= work on what was read)",
                        file, dims, needed, max_volume_bytes));
    }
}

}  // namespace pxpl5::host::io
