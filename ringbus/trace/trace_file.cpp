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

/// Bytes of an entry, where messages want to lie: at an address that 8 divides.
struct Aligned {
    std::shared_ptr<std::uint64_t[]> words;
    const std::uint8_t* bytes() const { return reinterpret_cast<const std::uint8_t*>(words.get()); }
};

Aligned aligned(std::span<const std::uint8_t> data) {
    Aligned to{
        std::make_shared_for_overwrite<std::uint64_t[]>(data.size() / sizeof(std::uint64_t) + 1)};
    std::memcpy(to.words.get(), data.data(), data.size());
    return to;
}

/// Bytes of the smallest body: its root and its identifier.
constexpr std::size_t least_body_bytes = 2 * sizeof(flatbuffers::uoffset_t);

/// A verified TraceEntry.
struct Stored {
    Aligned at;
    const schema::TraceEntry* entry;
};

/// Throws mcap::Damage.
Stored stored(std::span<const std::uint8_t> data) {
    constexpr std::size_t word = sizeof(std::uint64_t);
    Stored to{aligned(data), nullptr};
    const std::uint8_t* bytes = to.at.bytes();
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

/// The root table of a buffer of which `verifier` knows the begin; null if it is not there.
const flatbuffers::Table* begun_root(flatbuffers::Verifier& verifier, const std::uint8_t* bytes) {
    const flatbuffers::uoffset_t at = verifier.VerifyOffset(0);
    const auto* table = flatbuffers::GetRoot<flatbuffers::Table>(bytes);
    return at != 0 && table->VerifyTableStart(verifier) ? table : nullptr;
}

/// The header of an entry of `size` bytes that begins with `begin`. Checks what the begin tells of
/// the whole, so that few compressed bytes cannot claim a gigabyte: the header must be valid, and
/// the body must have the size and the kind that it names. Throws mcap::Damage, BadMessage.
schema::Header begun_header(std::span<const std::uint8_t> begin, std::uint64_t size) {
    using schema::TraceEntry;
    const auto require = [size](bool good) {
        if (!good) {
            throw mcap::Damage(fmt::format("a message of {} bytes that is no entry", size));
        }
    };
    const Aligned copy = aligned(begin);
    flatbuffers::Verifier verifier(copy.bytes(), begin.size());
    const auto* table = begun_root(verifier, copy.bytes());
    require(table != nullptr &&
            table->VerifyFieldRequired<schema::Header>(verifier, TraceEntry::VT_HEADER,
                                                       alignof(schema::Header)) &&
            table->VerifyOffsetRequired(verifier, TraceEntry::VT_MESSAGE));
    const auto* entry = schema::GetTraceEntry(copy.bytes());
    const auto body_at = static_cast<std::size_t>(entry->message()->data() - copy.bytes());
    require(body_at % sizeof(std::uint64_t) == 0 && body_at + least_body_bytes <= begin.size() &&
            entry->message()->size() <= size - body_at);
    const std::uint8_t* body = entry->message()->data();
    check_header(*entry->header(), entry->message()->size());
    flatbuffers::Verifier body_verifier(body, begin.size() - body_at);
    const auto* message = begun_root(body_verifier, body);
    require(schema::MessageBufferHasIdentifier(body) && message != nullptr &&
            message->VerifyField<std::uint8_t>(body_verifier, schema::Message::VT_BODY_TYPE, 1) &&
            schema::GetMessage(body)->body_type() == static_cast<Body>(entry->header()->kind()));
    return *entry->header();
}

/// Throws mcap::Damage.
schema::Header header_of(const mcap::MessageRecord& message) {
    if (message.data.size() == message.data_bytes) {
        return *stored(message.data).entry->header();
    }
    try {
        return begun_header(message.data, message.data_bytes);
    } catch (const BadMessage& bad) {
        throw mcap::Damage(bad.what());
    }
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
    void add(std::uint64_t chunk, const mcap::MessageRecord& message);
};

void TraceFile::Parts::add(std::uint64_t in_chunk, const mcap::MessageRecord& message) {
    const schema::Header header = header_of(message);
    if (entries.size() >= file.size() / indexed_bytes + unindexed_messages) {
        throw mcap::Damage(fmt::format("more than {} messages, too many for a file of {} bytes",
                                       entries.size(), file.size()));
    }
    entries.push_back({header, message.log_time, in_chunk, message.offset});
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
    visitor.message = [&](std::uint64_t in_chunk, const mcap::MessageRecord& message) {
        if (!known) {
            refuse(fmt::format("data comes before metadata '{}'", metadata_name));
        }
        add(in_chunk, message);
    };
    std::size_t whole = 0;  // Entries of whole chunks.
    visitor.chunk_end = [&] { whole = entries.size(); };
    cut = file.walk(visitor);
    entries.resize(whole);
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
        const Stored entry_at = stored(mcap::message_at(parts_->records, entry.offset).data);
        const auto* body = entry_at.entry->message();
        return {*entry_at.entry->header(), {body->data(), body->size()}, entry_at.at.words};
    } catch (const mcap::Damage& damage) {
        throw TraceError(fmt::format("{}: at offset {}: {}", parts_->file.path().string(),
                                     entry.chunk, damage.what()));
    }
}

}  // namespace pxpl5::bus::trace
