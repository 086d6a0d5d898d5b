// Small helpers to read text headers: lines, key and value, numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::io {

inline constexpr std::size_t max_header_lines = 10'000;
inline constexpr std::size_t max_header_line_bytes = 65'536;

std::string lower_case(std::string text);
std::string trimmed(std::string_view text);
std::vector<std::string> words_of(std::string_view text);

/// `text` from a file as an error may show it: printable, not long.
std::string shown(std::string_view text);

/// Whether `name` is a pattern of numbered files: one %d, perhaps with a width. Decoders hand the
/// pattern to sprintf, so nothing else may pass.
bool is_file_pattern(const std::string& name);

/// All words of `text` as whole numbers >= 0.
/// Throws ImportError naming `file`, `field` and the word.
std::vector<std::uint64_t> whole_numbers(const std::string& file, const std::string& field,
                                         const std::string& text);

/// Reads a text header line by line and knows where the next line begins.
class HeaderReader {
  public:
    /// Throws ImportError if `path` cannot be opened.
    explicit HeaderReader(const std::filesystem::path& path);
    /// The next line without its end, or false at the end of the file.
    /// Throws ImportError beyond max_header_lines or max_header_line_bytes.
    bool next(std::string& line);
    std::uint64_t offset_bytes() const { return offset_bytes_; }
    std::ifstream& stream() { return stream_; }

  private:
    std::string file_;
    std::ifstream stream_;
    std::uint64_t offset_bytes_ = 0;
    std::size_t lines_ = 0;
};

/// Fields of a header, by lower-case key.
using Fields = std::map<std::string, std::string>;

/// The value of `key`, spelled as in the format. Throws ImportError if it is absent.
const std::string& require(const std::string& file, const Fields& fields, const std::string& key);

/// The value of `key`, or `otherwise`.
std::string value_or(const Fields& fields, const std::string& key, const std::string& otherwise);

/// `text` as one number, or as many separated by blanks; nan and inf are numbers.
/// Throw ImportError naming `file`, `field` and the text.
double number(const std::string& file, const std::string& field, const std::string& text);
std::vector<double> numbers(const std::string& file, const std::string& field,
                            const std::string& text);

/// `text` as a vector; of 2 numbers the third is `otherwise`, a fourth (time) is left out.
glm::dvec3 three_numbers(const std::string& file, const std::string& field, const std::string& text,
                         double otherwise);

/// Throws ImportError if the values of a volume need more than max_volume_bytes. `dims`: size and
/// type as text.
void check_volume_bytes(const std::string& file, const std::string& dims, std::uint64_t needed);

}  // namespace pxpl5::host::io
