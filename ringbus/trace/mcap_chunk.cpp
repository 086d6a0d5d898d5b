#include "ringbus/trace/mcap_chunk.hpp"

#include <fmt/core.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>
#include <string>

namespace pxpl5::bus::trace::mcap {

namespace {

/// The last record of a chunk begins before this byte: behind a full chunk comes at most a
/// channel.
constexpr std::uint64_t last_begin_bytes = chunk_bytes + (std::size_t{64} << 10);
/// Limit of the memory for one step of decompression: 2 to this power bytes. The writer's level
/// needs 2 MiB.
constexpr int max_window_log = 23;

/// Fields of a chunk record.
struct Packed {
    std::uint64_t size = 0;  ///< Unpacked bytes.
    std::uint32_t crc = 0;   ///< CRC-32 of the unpacked bytes.
    bool is_compressed = false;
    std::span<const std::uint8_t> data;
};

/// Throws Damage.
Packed packed(std::span<const std::uint8_t> content) {
    In in(content);
    in.raw(2 * sizeof(std::uint64_t));  // First and last time.
    Packed chunk;
    chunk.size = in.number<std::uint64_t>();
    chunk.crc = in.number<std::uint32_t>();
    const std::string compression = in.text();
    chunk.data = in.raw(in.number<std::uint64_t>());
    chunk.is_compressed = !compression.empty();
    if (compression != "zstd" && !compression.empty()) {
        throw Damage(fmt::format("a chunk compressed by '{}', expected zstd", compression));
    }
    if (chunk.size > max_chunk_bytes) {
        throw Damage(
            fmt::format("a chunk of {} bytes, the limit is {}", chunk.size, max_chunk_bytes));
    }
    const std::uint64_t stated =
        chunk.is_compressed ? ZSTD_getFrameContentSize(chunk.data.data(), chunk.data.size())
                            : chunk.data.size();
    if (stated != chunk.size) {
        throw Damage(fmt::format("data that do not hold {} bytes", chunk.size));
    }
    return chunk;
}

struct FreeReadingContext {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// Unpacks a chunk from its front.
class Unpacker {
  public:
    explicit Unpacker(const Packed& chunk) : chunk_(chunk), context_(ZSTD_createDCtx()) {
        if (!context_) {
            throw std::bad_alloc();
        }
        ZSTD_DCtx_setParameter(context_.get(), ZSTD_d_windowLogMax, max_window_log);
        if (!chunk_.is_compressed) {
            ready_ = chunk_.data;
        } else {
            piece_.resize(std::min<std::uint64_t>(chunk_.size, ZSTD_DStreamOutSize()));
        }
    }

    std::uint64_t offset() const { return offset_; }
    std::uint64_t left() const { return chunk_.size - offset_; }

    /// Unpacks `count` bytes and appends the first `most` of them to `to`. Throws Damage.
    void read(std::uint64_t count, std::uint64_t most, Bytes& to) {
        for (offset_ += count; count > 0;) {
            if (ready_.empty()) {
                unpack();
            }
            const auto taken = ready_.first(std::min<std::uint64_t>(count, ready_.size()));
            const auto kept = taken.first(std::min<std::uint64_t>(most, taken.size()));
            crc_ = crc_of(taken, crc_);
            to.insert(to.end(), kept.begin(), kept.end());
            ready_ = ready_.subspan(taken.size());
            count -= taken.size();
            most -= kept.size();
        }
    }

    /// Checks the checksum of what was read: all of the chunk. Throws Damage.
    void finish() const { check_crc("a chunk", crc_, chunk_.crc); }

  private:
    void unpack() {
        ZSTD_outBuffer to{piece_.data(), piece_.size(), 0};
        ZSTD_inBuffer from{chunk_.data.data(), chunk_.data.size(), used_};
        while (to.pos == 0) {
            const std::size_t before = from.pos;
            const std::size_t hint = ZSTD_decompressStream(context_.get(), &to, &from);
            if (ZSTD_isError(hint) != 0) {
                throw Damage(fmt::format("compressed data: {}", ZSTD_getErrorName(hint)));
            }
            if (to.pos == 0 && (hint == 0 || from.pos == before)) {
                throw Damage("compressed data: it ends too early");
            }
        }
        used_ = from.pos;
        ready_ = std::span<const std::uint8_t>(piece_).first(to.pos);
    }

    Packed chunk_;
    std::unique_ptr<ZSTD_DCtx, FreeReadingContext> context_;
    Bytes piece_;                          ///< Unpacked bytes.
    std::span<const std::uint8_t> ready_;  ///< Unpacked, but not read.
    std::size_t used_ = 0;                 ///< Compressed bytes that are unpacked.
    std::uint64_t offset_ = 0;             ///< Bytes that were read.
    std::uint32_t crc_ = 0;                ///< CRC-32 of the bytes that were read.
};

/// Takes the fields of a message record before its data.
std::uint64_t take_log_time(In& record) {
    record.number<std::uint16_t>();
    record.number<std::uint32_t>();
    const auto log_time = record.number<std::uint64_t>();
    record.number<std::uint64_t>();
    return log_time;
}

}  // namespace

void for_each_message(std::span<const std::uint8_t> content,
                      const std::function<void(const MessageRecord&)>& take) {
    const Packed chunk = packed(content);
    Unpacker in(chunk);
    Bytes record;
    while (in.left() > 0) {
        const std::uint64_t offset = in.offset();
        const auto refuse = [&] {
            throw Damage(fmt::format("a chunk of {} bytes with no message to its end at byte {}",
                                     chunk.size, offset));
        };
        if (offset >= last_begin_bytes || in.left() < record_head_bytes) {
            refuse();
        }
        record.clear();
        in.read(record_head_bytes, record_head_bytes, record);
        In head(record);
        const Op op{head.number<std::uint8_t>()};
        const auto length = head.number<std::uint64_t>();
        const bool is_message = op == Op::message;
        if (length > in.left() || (!is_message && op != Op::schema && op != Op::channel) ||
            (!is_message && in.offset() + length > last_begin_bytes)) {
            refuse();
        }
        record.clear();
        in.read(length, is_message ? message_head_bytes + max_begin_bytes : 0, record);
        if (is_message) {
            In fields(record);
            const std::uint64_t log_time = take_log_time(fields);
            take({offset, log_time, length - message_head_bytes, fields.rest()});
        }
    }
    in.finish();
}

Bytes chunk_records(std::span<const std::uint8_t> content) {
    const Packed chunk = packed(content);
    Unpacker in(chunk);
    Bytes records;
    records.reserve(static_cast<std::size_t>(chunk.size));
    in.read(chunk.size, chunk.size, records);
    in.finish();
    return records;
}

MessageRecord message_at(std::span<const std::uint8_t> records, std::uint64_t offset) {
    if (offset > records.size()) {
        throw Damage(fmt::format("no message at byte {} of a chunk of {}", offset, records.size()));
    }
    In in(records.subspan(static_cast<std::size_t>(offset)));
    const Op op{in.number<std::uint8_t>()};
    In content(in.raw(in.number<std::uint64_t>()));
    if (op != Op::message) {
        throw Damage(fmt::format("no message at byte {} of a chunk", offset));
    }
    const std::uint64_t log_time = take_log_time(content);
    return {offset, log_time, content.size(), content.rest()};
}

}  // namespace pxpl5::bus::trace::mcap
