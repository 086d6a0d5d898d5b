// A WebM file of one video. The only sources that include FFmpeg are webm_file.*.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "host/base/part_file.hpp"
#include "host/film/film.hpp"

struct AVFormatContext;
struct AVIOContext;

namespace pxpl5::host::film {

class WebmFile {
  public:
    /// Writes into `file`, which stays where it is. Throws std::runtime_error with the reason.
    WebmFile(const PartFile& file, const FilmForm& form);
    ~WebmFile();
    WebmFile(const WebmFile&) = delete;
    WebmFile& operator=(const WebmFile&) = delete;

    /// Adds a picture in VP8. Times are milliseconds. Throws std::runtime_error.
    void add(const std::string& vp8, bool is_key, std::int64_t begin_ms, std::int64_t duration_ms);
    /// Writes the index and the duration. Throws std::runtime_error.
    void finish();

  private:
    static int write(void* self, std::uint8_t* bytes, int count);
    static std::int64_t seek(void* self, std::int64_t offset, int whence);
    void check(int result);

    const PartFile& file_;
    int failure_ = 0;  ///< The first errno of writing.
    AVFormatContext* format_ = nullptr;
    AVIOContext* output_ = nullptr;
};

}  // namespace pxpl5::host::film
