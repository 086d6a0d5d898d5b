// Where a tool's text goes: standard output, or the file of -o.
#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "host/base/part_file.hpp"

namespace pxpl5::host {

/// Thrown when whoever reads standard output has gone (| head): nothing is left to do.
struct OutputClosed {};

/// A file appears when finish() is called. Without it, or if writing fails, the earlier file stays.
class TextOutput {
  public:
    /// path  Empty or "-": standard output. Throws RequestError (failed) if it cannot be opened.
    explicit TextOutput(const std::string& path);

    /// Puts a text; on standard output printable. Throws OutputClosed; RequestError (failed) if
    /// writing fails otherwise.
    void put(std::string_view text);
    /// Puts bytes as they are: binary data, and texts with colors. Throws as put().
    void raw(std::string_view bytes);
    /// Puts `text` and ends the line.
    void line(std::string_view text);
    /// Hands standard output's text to the system, for a reader who waits. Throws as put().
    void flush();
    /// Hands everything to the system, and gives a file its name. Nothing may follow in a file.
    /// Throws as put().
    void finish();

  private:
    void check(bool ok) const;
    [[noreturn]] void fail(const std::string& reason) const;

    struct Close {
        void operator()(std::FILE* file) const;
    };
    std::string path_;  ///< Empty for standard output.
    std::unique_ptr<std::FILE, Close> stream_;
    std::optional<PartFile> file_;  ///< Instead of the stream: a file, not a pipe or a device.
};

}  // namespace pxpl5::host
