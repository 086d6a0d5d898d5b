#include "ringbus/trace/trace_file.hpp"

#include <fmt/core.h>

#include <cstring>
#include <optional>

#include "ringbus/trace/mcap_reader.hpp"
#include "ringbus/trace/trace_info.hpp"
#include "trace_generated.h"

namespace pxpl5::bus::trace {

namespace {

/// Bytes of a message in the file: its entry in the MessageIndex behind the chunk is not
/// compressed.
constexpr std::uint64_t indexed_bytes = 2 * sizeof(std::uint64_t);
/// Messages of a last chunk that may have no MessageIndex, because the recording was cut there.
constexpr std::uint64_t unindexed_messages = std::uint64_t{1} << 16;

/// A verified TraceEntry, where messages want to lie: at an address that 8 divides.
struct Stored {
    std::shared_ptr<std::uint64_t[]> bytes;
    const schema::TraceEntry* entry;
};

/// Throws mcap::Damage.
Stored stored(std::span<const std::uint8_t> data) {
    constexpr std::size_t word = sizeof(std::uint64_t);
    Stored to{std::make_shared_for_overwrite<std::uint64_t[]>(data.size() / word + 1), nullptr};
    std::memcpy(to.bytes.get(), data.data(), data.size());
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(to.bytes.get());
    flatbuffers::Verifier verifier(bytes, data.size(), max_body_depth, max_body_tables);
    if (data.size() < word || !schema::VerifyTraceEntryBuffer(verifier)) {
        throw mcap::Damage(fmt::format("a message of {} bytes that is no entry", data.size()));
    }
    to.entry = schema::GetTraceEntry(bytes);
    const auto at = static_cast<std::size_t>(to.entry->message()->data() - bytes);
    if (at % word != 0) {
        throw mcap::Damage("an entry whose body is not aligned");
    }
    return to;
}

}  // namespace

struct TraceFile::Parts {
    mcap::Reader file;
    Info info;
    std::vector<Entry> entries;
    std::string cut;
    std::uint64_t chunk = 0;  ///< Offset of the chunk that is kept.
    mcap::Bytes records;      ///< Its own; empty if none is kept.

    void read();
    void add_chunk(std::uint64_t offset, std::span<const std::uint8_t> kept);
};

void TraceFile::Parts::add_chunk(std::uint64_t offset, std::span<const std::uint8_t> kept) {
    mcap::for_each_message(kept, [&](const mcap::MessageRecord& message) {
        const Stored entry = stored(message.data);
        if (entries.size() >= file.size() / indexed_bytes + unindexed_messages) {
            throw mcap::Damage(fmt::format("more than {} messages, too many for a file of {} bytes",
                                           entries.size(), file.size()));
        }
        entries.push_back({*entry.entry->header(), message.log_time, offset, message.offset});
    });
}

void TraceFile::Parts::read() {
    bool known = false;
    const auto refuse = [this](const std::string& reason) {
        throw TraceError(fmt::format("{} is no trace of pxpl5: {}", file.path().string(), reason));
    };
    mcap::Visitor visitor;
    visitor.metadata = [&](const std::string& name, const mcap::Metadata& metadata) {
        if (name == metadata_name) {
            info = to_info(metadata);
            known = true;
            if (info.schema_hash != schema_hash()) {
                refuse(
                    fmt::format("its messages have schema {:016x}, this program's {:016x}; it "
                                "was recorded by {}",
                                info.schema_hash, schema_hash(), info.build));
            }
        }
    };
    visitor.chunk = [&](std::uint64_t offset, std::span<const std::uint8_t> kept) {
        if (!known) {
            refuse(fmt::format("data comes before metadata '{}'", metadata_name));
        }
        add_chunk(offset, kept);
    };
    cut = file.walk(visitor);
    if (!known) {
        refuse(cut.empty() ? fmt::format("it has no metadata '{}'", metadata_name) : cut);
    }
}

TraceFile::TraceFile(const std::filesystem::path& path)
    : parts_(new Parts{mcap::Reader(path), {}, {}, {}, 0, {}}) {
    parts_->read();
}

TraceFile::~TraceFile() = default;
TraceFile::TraceFile(TraceFile&&) noexcept = default;
TraceFile& TraceFile::operator=(TraceFile&&) noexcept = default;

const Info& TraceFile::info() const {
    return parts_->info;
}
const std::vector<Entry>& TraceFile::entries() const {
    return parts_->entries;
}
const std::string& TraceFile::cut() const {
    return parts_->cut;
}

Message TraceFile::load(const Entry& entry) const {
    try {
        if (parts_->records.empty() || parts_->chunk != entry.chunk) {
            parts_->records.clear();
            parts_->records = parts_->file.chunk(entry.chunk);
            parts_->chunk = entry.chunk;
        }
        const Stored at = stored(mcap::message_at(parts_->records, entry.offset).data);
        const auto* body = at.entry->message();
        return {*at.entry->header(), {body->data(), body->size()}, at.bytes};
    } catch (const mcap::Damage& damage) {
        throw TraceError(fmt::format("{}: at offset {}: {}", parts_->file.path().string(),
                                     entry.chunk, damage.what()));
    }
}

}  // namespace pxpl5::bus::trace
