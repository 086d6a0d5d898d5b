// Where a tool's text goes: standard output, or the file of -o.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace pxpl5::host {

/// Thrown when whoever reads standard output has gone (| head): nothing is left to do.
struct OutputClosed {};

class TextOutput {
  public:
    /// path  Empty or "-": standard output. Throws RequestError (failed) if it cannot be opened.
    explicit TextOutput(const std::string& path);

    /// Throws OutputClosed; RequestError (failed) if writing fails otherwise.
    void put(std::string_view text);
    /// Puts `text` and ends the line.
    void line(std::string_view text);
    /// Hands everything to the system; throws as put().
    void finish();

  private:
    void check(bool ok) const;

    struct Close {
        void operator()(std::FILE* file) const;
    };
    std::string path_;  ///< Empty for standard output.
    std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace pxpl5::host
