#include "host/base/text_output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"

namespace pxpl5::host {

TextOutput::TextOutput(const std::string& path) : path_(path == "-" ? "" : path) {
    std::error_code unknown;
    const std::filesystem::file_status there = std::filesystem::status(path_, unknown);
    if (path_.empty() ||
        (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))) {
        if (!path_.empty() && there.type() == std::filesystem::file_type::fifo) {
            fail("it is a FIFO, not a file: give the name of a file, or - for standard output");
        }
        stream_.reset(path_.empty() ? stdout : std::fopen(path_.c_str(), "wb"));
        check(stream_ != nullptr);
    } else if (file_.emplace(path_); file_->has_failed()) {
        fail(file_->keep());
    }
}

void TextOutput::Close::operator()(std::FILE* file) const {
    if (file != stdout) {
        std::fclose(file);
    }
}

void TextOutput::put(std::string_view text) {
    if (path_.empty()) {
        raw(printable(text));  // It may have names and contents of files.
    } else {
        raw(text);
    }
}

void TextOutput::raw(std::string_view bytes) {
    if (!file_) {
        check(std::fwrite(bytes.data(), 1, bytes.size(), stream_.get()) == bytes.size());
    } else if (file_->write(bytes); file_->has_failed()) {
        fail(file_->keep());
    }
}

void TextOutput::line(std::string_view text) {
    put(text);
    put("\n");
}

void TextOutput::flush() {
    if (!file_) {
        check(std::fflush(stream_.get()) == 0);
    }
}

void TextOutput::finish() {
    flush();
    if (file_) {
        if (const std::string reason = file_->keep(); !reason.empty()) {
            fail(reason);
        }
    }
}

void TextOutput::check(bool ok) const {
    if (ok) {
        return;
    }
    if (errno == EPIPE) {
        throw OutputClosed{};
    }
    fail(std::strerror(errno));
}

void TextOutput::fail(const std::string& reason) const {
    throw RequestError(
        ExitCode::failed,
        fmt::format("cannot write {}: {}", path_.empty() ? "standard output" : path_, reason));
}

}  // namespace pxpl5::host
