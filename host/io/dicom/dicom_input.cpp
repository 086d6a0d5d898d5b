#include "host/io/dicom/dicom_input.hpp"

#include <fstream>
#include <streambuf>

#include "host/io/values/file_facts.hpp"

namespace pxpl5::host::io {

namespace {

/// Reads a text in place.
class TextBuffer : public std::streambuf {
  public:
    explicit TextBuffer(std::shared_ptr<const std::string> text) : text_(std::move(text)) {
        char* const first = const_cast<char*>(text_->data());  // A buffer that only reads.
        setg(first, first, first + text_->size());
    }

  protected:
    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
        const off_type base = from == std::ios::beg   ? 0
                              : from == std::ios::cur ? gptr() - eback()
                                                      : egptr() - eback();
        return seekpos(base + offset, std::ios::in);
    }

    pos_type seekpos(pos_type to, std::ios::openmode) override {
        const off_type at = to;
        if (at < 0 || at > egptr() - eback()) {
            return pos_type(off_type(-1));
        }
        setg(eback(), eback() + at, egptr());
        return to;
    }

  private:
    std::shared_ptr<const std::string> text_;
};

class TextStream : public std::istream {
  public:
    explicit TextStream(std::shared_ptr<const std::string> text)
        : std::istream(nullptr), buffer_(std::move(text)) {
        rdbuf(&buffer_);
    }

  private:
    TextBuffer buffer_;
};

}  // namespace

std::uint64_t DicomInput::size_bytes() const {
    return bytes ? bytes->size() : std::filesystem::file_size(path);
}

FileFacts DicomInput::facts() const {
    return bytes ? FileFacts{bytes->size(), 0, 0} : facts_of(path);
}

std::unique_ptr<std::istream> DicomInput::open() const {
    if (bytes) {
        return std::make_unique<TextStream>(bytes);
    }
    return std::make_unique<std::ifstream>(path, std::ios::binary);
}

}  // namespace pxpl5::host::io
