#include "ringbus/trace/mcap_reader.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "ringbus/trace/error.hpp"
#include "ringbus/trace/mcap_chunk.hpp"

namespace pxpl5::bus::trace::mcap {

namespace {

constexpr std::size_t tail_bytes = record_head_bytes + footer_bytes + magic.size();
constexpr std::size_t piece_bytes = std::size_t{1} << 20;  ///< Bytes of the summary per read.

struct Record {
    Op op{};
    std::uint64_t offset = 0;  ///< Offset of the opcode in the file.
    Bytes bytes;               ///< Opcode and length included.
    std::span<const std::uint8_t> content() const {
        return std::span(bytes).subspan(record_head_bytes);
    }
};

std::uint64_t limit_of(Op op) {
    return op == Op::chunk ? ZSTD_COMPRESSBOUND(max_chunk_bytes) + max_record_bytes
                           : max_record_bytes;
}

/// Checks records that reading does not need. A chunk with a damaged opcode is then not mistaken
/// for such a record.
void check_unused(const Record& record) {
    In in(record.content());
    const auto skip_list = [&in] { in.raw(in.number<std::uint32_t>()); };
    switch (record.op) {
        case Op::header:  // Profile and library.
            in.text(), in.text();
            break;
        case Op::schema:  // Number, name, encoding and the schema itself.
            in.number<std::uint16_t>(), in.text(), in.text(), skip_list();
            break;
        case Op::channel:  // Number, schema, topic, encoding and metadata.
            in.number<std::uint32_t>(), in.text(), in.text(), in.texts();
            break;
        case Op::message_index:
            in.number<std::uint16_t>(), skip_list();
            break;
        default:
            throw Damage(
                fmt::format("a record of kind {} among the data", static_cast<int>(record.op)));
    }
    if (!in.empty()) {
        throw Damage(fmt::format("{} bytes too many in a record of kind {}", in.size(),
                                 static_cast<int>(record.op)));
    }
}

}  // namespace

struct Reader::Parts {
    std::filesystem::path path;
    int file = -1;
    std::uint64_t size = 0;

    ~Parts() {
        if (file >= 0) {
            ::close(file);
        }
    }
    [[noreturn]] void fail() const {
        throw TraceError(
            fmt::format("cannot read trace {}: {}", path.string(), std::strerror(errno)));
    }
    Bytes read(std::uint64_t offset, std::uint64_t count) const;
    Record record(std::uint64_t offset) const;
    std::uint64_t visit(const Visitor& visitor, std::uint64_t& offset) const;
    void check_tail(std::uint64_t start) const;
};

Bytes Reader::Parts::read(std::uint64_t offset, std::uint64_t count) const {
    if (offset > size || count > size - offset) {
        throw Damage(
            fmt::format("{} bytes are needed, {} are left", count, size - std::min(offset, size)));
    }
    Bytes bytes(static_cast<std::size_t>(count));
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t got = pread(file, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
        if (got == 0) {
            throw Damage("the file has become shorter");
        }
        if (got < 0 && errno != EINTR) {
            fail();
        }
        done += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    }
    return bytes;
}

Record Reader::Parts::record(std::uint64_t offset) const {
    if (size - offset < record_head_bytes) {
        throw Damage("the file ends here without an end record: it was not closed");
    }
    const Bytes head = read(offset, record_head_bytes);
    In in(head);
    const Op op{in.number<std::uint8_t>()};
    const auto length = in.number<std::uint64_t>();
    if (length > limit_of(op)) {
        throw Damage(fmt::format("a record of kind {} and {} bytes, the limit is {}",
                                 static_cast<int>(op), length, limit_of(op)));
    }
    return {op, offset, read(offset, record_head_bytes + length)};
}

/// Visits records from `offset` on and advances `offset`. Returns the end of DataEnd.
std::uint64_t Reader::Parts::visit(const Visitor& visitor, std::uint64_t& offset) const {
    std::uint32_t crc = crc_of(read(0, offset));
    while (true) {
        const Record record = this->record(offset);
        if (record.op == Op::metadata) {
            In in(record.content());
            const std::string name = in.text();
            visitor.metadata(name, in.texts());
        } else if (record.op == Op::chunk) {
            for_each_message(record.content(), [&](const MessageRecord& message) {
                visitor.message(offset, message);
            });
            visitor.chunk_end();
        } else if (record.op == Op::data_end) {
            check_crc("all that precedes", crc, In(record.content()).number<std::uint32_t>());
            return offset + record.bytes.size();
        } else {
            check_unused(record);
        }
        crc = crc_of(record.bytes, crc);
        offset += record.bytes.size();
    }
}

/// Checks the summary from `start` on. Reading does not need it, but it proves that the file is
/// complete.
void Reader::Parts::check_tail(std::uint64_t start) const {
    if (size < start + tail_bytes) {
        throw Damage("the summary is cut; no message is missing");
    }
    const Bytes tail = read(size - tail_bytes, tail_bytes);
    In in(tail);
    const bool is_footer =
        Op{in.number<std::uint8_t>()} == Op::footer && in.number<std::uint64_t>() == footer_bytes;
    const auto summary_start = in.number<std::uint64_t>();
    in.number<std::uint64_t>();
    const auto crc = in.number<std::uint32_t>();
    if (!is_footer || (summary_start != start && summary_start != 0) ||
        !std::equal(magic.begin(), magic.end(), in.rest().begin())) {
        throw Damage("the summary has no end; no message is missing");
    }
    std::uint32_t got = 0;
    const std::uint64_t end = size - magic.size() - sizeof crc;
    for (std::uint64_t at = start; at < end; at += piece_bytes) {
        got = crc_of(read(at, std::min<std::uint64_t>(piece_bytes, end - at)), got);
    }
    check_crc("the summary", got, crc);
}

Reader::Reader(const std::filesystem::path& path) : parts_(std::make_unique<Parts>()) {
    parts_->path = path;
    // O_NONBLOCK: a FIFO without a writer would block here for ever.
    parts_->file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat facts {};
    if (parts_->file < 0 || fstat(parts_->file, &facts) != 0) {
        parts_->fail();
    }
    if (!S_ISREG(facts.st_mode)) {
        throw TraceError(fmt::format("{} is no file", path.string()));
    }
    parts_->size = static_cast<std::uint64_t>(facts.st_size);
    const Bytes start = parts_->read(0, std::min<std::uint64_t>(magic.size(), parts_->size));
    if (!std::equal(magic.begin(), magic.end(), start.begin(), start.end())) {
        throw TraceError(
            fmt::format("{} is no MCAP file: it does not begin like one", path.string()));
    }
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

const std::filesystem::path& Reader::path() const {
    return parts_->path;
}

std::uint64_t Reader::size() const {
    return parts_->size;
}

std::string Reader::walk(const Visitor& visitor) const {
    std::uint64_t offset = magic.size();
    try {
        const std::uint64_t end = parts_->visit(visitor, offset);
        offset = end;
        parts_->check_tail(end);
    } catch (const Damage& damage) {
        return fmt::format("at offset {} of {} bytes: {}", offset, parts_->size, damage.what());
    }
    return {};
}

Bytes Reader::chunk(std::uint64_t offset) const {
    if (offset > parts_->size) {
        throw Damage(fmt::format("no chunk at offset {} of {}", offset, parts_->size));
    }
    const Record record = parts_->record(offset);
    if (record.op != Op::chunk) {
        throw Damage(fmt::format("no chunk at offset {}", offset));
    }
    return chunk_records(record.content());
}

}  // namespace pxpl5::bus::trace::mcap
