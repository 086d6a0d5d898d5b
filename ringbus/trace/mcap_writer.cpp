#include "ringbus/trace/mcap_writer.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "ringbus/trace/error.hpp"

namespace pxpl5::bus::trace::mcap {

namespace {

/// A buffer that a large message enlarged beyond this size is freed.
constexpr std::size_t kept_buffer_bytes = std::size_t{16} << 20;
constexpr int compression_level = 1;
constexpr std::uint16_t schema_id = 1;

struct Times {
    std::uint64_t first = 0, last = 0;
    bool any = false;
    void add(std::uint64_t time) {
        first = any ? std::min(first, time) : time;
        last = any ? std::max(last, time) : time;
        any = true;
    }
};

/// Entry of a chunk in the summary.
struct ChunkPlace {
    Times times;
    std::uint64_t offset = 0, length = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;  ///< By channel.
    std::uint64_t index_length = 0, compressed = 0, uncompressed = 0;
};

struct IndexEntry {
    std::uint64_t time, offset;
};

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

}  // namespace

struct Writer::Parts {
    std::filesystem::path path;
    int file = -1;
    std::uint64_t offset = 0;
    std::uint32_t crc = 0;  ///< CRC of all written bytes.
    std::string failure;    ///< Reason of the failure that ended writing.
    std::unique_ptr<ZSTD_CCtx, FreeContext> context{ZSTD_createCCtx()};

    Bytes schema_record, channel_records;  ///< Repeated in the summary.
    std::uint16_t channels = 0;
    std::string encoding, metadata_name;
    std::uint64_t metadata_offset = 0, metadata_length = 0;

    Bytes chunk, compressed, records;
    Times chunk_times, times;
    std::map<std::uint16_t, std::vector<IndexEntry>>
        index;  ///< Entries of the current chunk, by channel.
    std::vector<ChunkPlace> places;
    std::map<std::uint16_t, std::uint64_t> counts;  ///< Messages by channel.
    std::uint64_t messages = 0;

    ~Parts() {
        if (file >= 0) {
            ::close(file);
        }
    }
    [[noreturn]] void fail(const char* doing) {
        failure = fmt::format("cannot {} trace {} at byte {}: {}", doing, path.string(), offset,
                              std::strerror(errno));
        throw TraceError(failure);
    }
    void check() const {
        if (!failure.empty()) {
            throw TraceError(failure);
        }
        assert(file >= 0);
    }
    void write(std::span<const std::uint8_t> bytes);
    void write_preamble(const Preamble& preamble);
    void write_index(ChunkPlace& place);
    void put_summary(Bytes& summary, std::uint64_t start) const;
    void put_chunk_index(Bytes& summary) const;
    void put_statistics(Bytes& summary) const;
};

/// Whole records only: what a failed write has left of one is cut off again.
void Writer::Parts::write(std::span<const std::uint8_t> bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EINTR) {
            const int reason = errno;
            [[maybe_unused]] const int cut = ftruncate(file, static_cast<off_t>(offset));
            errno = reason;
            fail("write");
        }
        done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
    offset += bytes.size();
    crc = crc_of(bytes, crc);
}

void Writer::Parts::write_preamble(const Preamble& preamble) {
    encoding = preamble.encoding;
    metadata_name = preamble.metadata_name;
    Out record(schema_record);
    record.record(Op::schema, [&] {
        record.number(schema_id).text(preamble.schema_name).text(encoding);
        record.counted([&] { record.raw(preamble.schema); });
    });
    Bytes bytes(magic.begin(), magic.end());
    Out out(bytes);
    out.record(Op::header, [&] { out.text("").text(preamble.library); });
    metadata_offset = bytes.size();
    out.record(Op::metadata, [&] { out.text(metadata_name).texts(preamble.metadata); });
    metadata_length = bytes.size() - metadata_offset;
    write(bytes);
    Out(chunk).raw(schema_record);  // Compressed: it is most of a small file.
}

void Writer::Parts::write_index(ChunkPlace& place) {
    records.clear();
    Out out(records);
    for (const auto& [channel, entries] : index) {
        place.index_offsets[channel] = offset + records.size();
        out.record(Op::message_index, [&, id = channel, &list = entries] {
            out.number(id).counted([&] {
                for (const IndexEntry& entry : list) {
                    out.number(entry.time).number(entry.offset);
                }
            });
        });
    }
    place.index_length = records.size();
    write(records);
}

void Writer::Parts::put_chunk_index(Bytes& summary) const {
    Out out(summary);
    for (const ChunkPlace& place : places) {
        out.record(Op::chunk_index, [&] {
            out.number(place.times.first).number(place.times.last);
            out.number(place.offset).number(place.length);
            out.counted([&] {
                for (const auto& [channel, at] : place.index_offsets) {
                    out.number(channel).number(at);
                }
            });
            out.number(place.index_length).text("zstd");
            out.number(place.compressed).number(place.uncompressed);
        });
    }
}

void Writer::Parts::put_statistics(Bytes& summary) const {
    Out out(summary);
    out.record(Op::statistics, [&] {
        out.number(messages).number(std::uint16_t{1}).number(std::uint32_t{channels});
        out.number(std::uint32_t{0}).number(std::uint32_t{1});  // Attachments, metadata.
        out.number(static_cast<std::uint32_t>(places.size()));
        out.number(times.first).number(times.last).counted([&] {
            for (const auto& [channel, count] : counts) {
                out.number(channel).number(count);
            }
        });
    });
}

/// Everything behind DataEnd, which ends at byte `start`, but the trailing magic.
void Writer::Parts::put_summary(Bytes& summary, std::uint64_t start) const {
    Out out(summary);
    Bytes offsets;
    const auto group = [&](Op op, const auto& put) {
        const std::size_t at = summary.size();
        put();
        if (summary.size() != at) {
            Out to(offsets);
            to.record(Op::summary_offset, [&] {
                to.op(op).number(start + at).number(std::uint64_t{summary.size() - at});
            });
        }
    };
    group(Op::schema, [&] { out.raw(schema_record); });
    group(Op::channel, [&] { out.raw(channel_records); });
    group(Op::statistics, [&] { put_statistics(summary); });
    group(Op::chunk_index, [&] { put_chunk_index(summary); });
    group(Op::metadata_index, [&] {
        out.record(Op::metadata_index, [&] {
            out.number(metadata_offset).number(metadata_length).text(metadata_name);
        });
    });
    const std::uint64_t offsets_start = start + summary.size();
    out.raw(offsets);
    // Its length comes first: the CRC is over all that precedes it.
    out.op(Op::footer).number(std::uint64_t{footer_bytes}).number(start).number(offsets_start);
    out.number(crc_of(summary));
}

Writer::Writer(const std::filesystem::path& path, const Preamble& preamble)
    : parts_(std::make_unique<Parts>()) {
    parts_->path = path;
    if (!parts_->context) {
        throw TraceError(
            fmt::format("cannot create trace {}: no memory to compress it", path.string()));
    }
    // For the owner alone: a trace holds the voxels of a patient.
    parts_->file =
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (parts_->file < 0) {
        throw TraceError(
            fmt::format("cannot create trace {}: {}", path.string(), std::strerror(errno)));
    }
    ZSTD_CCtx_setParameter(parts_->context.get(), ZSTD_c_compressionLevel, compression_level);
    parts_->write_preamble(preamble);
}

Writer::~Writer() = default;

std::uint16_t Writer::channel(const std::string& topic, const Metadata& metadata) {
    parts_->check();
    assert(parts_->channels != UINT16_MAX);
    const std::uint16_t id = ++parts_->channels;
    Bytes record;
    Out out(record);
    out.record(Op::channel, [&] {
        out.number(id).number(schema_id).text(topic).text(parts_->encoding).texts(metadata);
    });
    Out(parts_->chunk).raw(record);
    Out(parts_->channel_records).raw(record);
    return id;
}

void Writer::message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
                     std::span<const std::uint8_t> data) {
    parts_->check();
    parts_->index[channel].push_back({log_time, parts_->chunk.size()});
    parts_->chunk_times.add(log_time);
    Out out(parts_->chunk);
    out.record(Op::message, [&] {
        out.number(channel).number(sequence).number(log_time).number(log_time).raw(data);
    });
    ++parts_->counts[channel];
    ++parts_->messages;
    if (parts_->chunk.size() >= chunk_bytes) {
        end_chunk();
    }
}

void Writer::end_chunk() {
    Parts& parts = *parts_;
    parts.check();
    if (parts.index.empty()) {
        return;  // No message: at most the schema, which can wait for one.
    }
    parts.compressed.resize(ZSTD_compressBound(parts.chunk.size()));
    const std::size_t size =
        ZSTD_compress2(parts.context.get(), parts.compressed.data(), parts.compressed.size(),
                       parts.chunk.data(), parts.chunk.size());
    if (ZSTD_isError(size) != 0) {  // The buffer is large enough, so that memory is short.
        errno = ENOMEM;
        parts.fail("compress");
    }
    parts.compressed.resize(size);
    ChunkPlace place{parts.chunk_times, parts.offset, 0, {}, 0, size, parts.chunk.size()};
    parts.records.clear();
    Out out(parts.records);
    out.record(Op::chunk, [&] {
        out.number(place.times.first).number(place.times.last).number(place.uncompressed);
        out.number(crc_of(parts.chunk)).text("zstd");
        out.number(place.compressed).raw(parts.compressed);
    });
    parts.write(parts.records);
    place.length = parts.records.size();
    parts.write_index(place);
    parts.times.add(place.times.first);
    parts.times.add(place.times.last);
    parts.places.push_back(std::move(place));
    for (Bytes* buffer : {&parts.chunk, &parts.compressed, &parts.records}) {
        buffer->clear();
        if (buffer->capacity() > kept_buffer_bytes) {
            buffer->shrink_to_fit();
        }
    }
    parts.index.clear();
    parts.chunk_times = {};
}

void Writer::close() {
    end_chunk();
    Parts& parts = *parts_;
    Bytes bytes;
    Out out(bytes);
    out.record(Op::data_end, [&] { out.number(parts.crc); });
    Bytes summary;
    parts.put_summary(summary, parts.offset + bytes.size());
    out.raw(summary).raw(magic);
    parts.write(bytes);
    const int file = std::exchange(parts.file, -1);
    if (::close(file) != 0) {
        parts.fail("close");
    }
}

std::uint64_t Writer::messages() const {
    return parts_->messages;
}
std::uint64_t Writer::bytes() const {
    return parts_->offset;
}

}  // namespace pxpl5::bus::trace::mcap
