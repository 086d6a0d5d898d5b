#include "host/base/text_output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"

namespace pxpl5::host {

TextOutput::TextOutput(const std::string& path) : path_(path == "-" ? "" : path) {
    file_.reset(path_.empty() ? stdout : std::fopen(path_.c_str(), "wb"));
    check(file_ != nullptr);
}

void TextOutput::Close::operator()(std::FILE* file) const {
    if (file != stdout) {
        std::fclose(file);
    }
}

void TextOutput::put(std::string_view text) {
    check(std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size());
}

void TextOutput::line(std::string_view text) {
    put(text);
    put("\n");
}

void TextOutput::finish() {
    check(std::fflush(file_.get()) == 0);
}

void TextOutput::check(bool ok) const {
    if (ok) {
        return;
    }
    if (errno == EPIPE) {
        throw OutputClosed{};
    }
    throw RequestError(ExitCode::failed,
                       fmt::format("cannot write {}: {}", path_.empty() ? "standard output" : path_,
                                   std::strerror(errno)));
}

}  // namespace pxpl5::host
