// Files of the page as gzip.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace pxpl5::host::serve {

/// Compresses each file when it is first asked for, and again when it has changed.
class CompressedFiles {
  public:
    /// The file as gzip (RFC 1952); null if it cannot be read. Valid until the next call.
    const std::string* find(const std::filesystem::path& file);

  private:
    struct Compressed {
        std::filesystem::file_time_type written;
        std::uintmax_t bytes = 0;
        std::string gzip;
    };
    std::map<std::filesystem::path, Compressed> files_;
};

/// Whether the value of Accept-Encoding (RFC 9110, 12.5.3) names gzip with a weight above 0.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace pxpl5::host::serve
