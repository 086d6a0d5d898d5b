#include "host/film/webm_file.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>

extern "C" {
#include <libavformat/avformat.h>
}

namespace pxpl5::host::film {

namespace {

constexpr int buffer_bytes = 1 << 16;

std::string reason_of(int result) {
    std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
    av_strerror(result, text.data(), text.size());
    return text.data();
}

}  // namespace

WebmFile::WebmFile(const PartFile& file, const FilmForm& form) : file_(file) {
    if (file.stream() == nullptr) {
        throw std::runtime_error(std::generic_category().message(errno));
    }
    check(avformat_alloc_output_context2(&format_, nullptr, "webm", nullptr));
    auto* buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    output_ = avio_alloc_context(buffer, buffer_bytes, 1, this, nullptr, &write, &seek);
    AVStream* stream = avformat_new_stream(format_, nullptr);
    if (output_ == nullptr || stream == nullptr) {
        throw std::runtime_error("no memory");
    }
    format_->pb = output_;
    format_->flags |= AVFMT_FLAG_BITEXACT;  // No random numbers.
    av_dict_set(&format_->metadata, "title", form.title.c_str(), 0);
    av_dict_set(&format_->metadata, "comment", form.comment.c_str(), 0);
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = av_d2q(form.rate, 1001000);
    AVCodecParameters& video = *stream->codecpar;
    video.codec_type = AVMEDIA_TYPE_VIDEO;
    video.codec_id = AV_CODEC_ID_VP8;
    video.width = form.width;
    video.height = form.height;
    video.color_space = AVCOL_SPC_SMPTE170M;  // BT.601, as VideoImage.
    video.color_range = AVCOL_RANGE_MPEG;
    check(avformat_write_header(format_, nullptr));
}

WebmFile::~WebmFile() {
    if (output_ != nullptr) {
        av_freep(static_cast<void*>(&output_->buffer));  // FFmpeg may have replaced it.
        avio_context_free(&output_);
    }
    avformat_free_context(format_);
}

void WebmFile::add(const std::string& vp8, bool is_key, std::int64_t begin_ms,
                   std::int64_t duration_ms) {
    AVPacket* packet = av_packet_alloc();
    if (packet == nullptr || av_new_packet(packet, static_cast<int>(vp8.size())) != 0) {
        av_packet_free(&packet);
        throw std::runtime_error("no memory");
    }
    vp8.copy(reinterpret_cast<char*>(packet->data), vp8.size());
    packet->pts = packet->dts = begin_ms;
    packet->duration = duration_ms;
    packet->flags = is_key ? AV_PKT_FLAG_KEY : 0;
    const int result = av_write_frame(format_, packet);
    av_packet_free(&packet);
    check(result);
}

void WebmFile::finish() {
    check(av_write_trailer(format_));
    avio_flush(output_);
    check(output_->error);
}

int WebmFile::write(void* self, std::uint8_t* bytes, int count) {
    auto& film = *static_cast<WebmFile*>(self);
    const auto size = static_cast<std::size_t>(count);
    if (std::fwrite(bytes, 1, size, film.file_.stream()) != size) {
        film.failure_ = film.failure_ == 0 ? errno : film.failure_;
        return AVERROR(EIO);
    }
    return count;
}

std::int64_t WebmFile::seek(void* self, std::int64_t offset, int whence) {
    auto& film = *static_cast<WebmFile*>(self);
    if ((whence & AVSEEK_SIZE) != 0) {
        return AVERROR(ENOSYS);
    }
    std::FILE* stream = film.file_.stream();
    return fseeko(stream, offset, whence) == 0 ? ftello(stream) : AVERROR(EIO);
}

void WebmFile::check(int result) {
    if (failure_ != 0) {
        throw std::runtime_error(std::generic_category().message(failure_));
    }
    if (result < 0) {
        throw std::runtime_error(reason_of(result));
    }
}

}  // namespace pxpl5::host::film
