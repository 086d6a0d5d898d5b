// Encodes the pictures of a film.
#pragma once

#include <vpx/vpx_encoder.h>

#include <cstdint>
#include <span>

#include "host/film/film.hpp"
#include "host/film/video_image.hpp"

namespace pxpl5::host::film {

/// Times of a WebM file are in milliseconds.
inline constexpr int ticks_per_second = 1000;

/// Encodes pictures as VP8, each at once.
class FilmEncoder {
  public:
    /// Throws std::runtime_error with the encoder's reason.
    explicit FilmEncoder(const FilmForm& form);
    ~FilmEncoder();
    FilmEncoder(const FilmEncoder&) = delete;
    FilmEncoder& operator=(const FilmEncoder&) = delete;

    /// Encodes a picture that is shown from `begin` for `duration` ticks.
    VideoPacket encode(std::span<const std::uint32_t> rgba, std::int64_t begin,
                       std::int64_t duration);

  private:
    void check(vpx_codec_err_t result);

    VideoImage image_;
    vpx_codec_enc_cfg_t config_{};
    vpx_codec_ctx_t codec_{};
};

}  // namespace pxpl5::host::film
