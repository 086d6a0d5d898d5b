#include <fmt/core.h>

#include <utility>

#include "ringbus/trace/mcap_writer.hpp"
#include "ringbus/trace/trace_file.hpp"
#include "ringbus/trace/trace_info.hpp"
#include "trace_generated.h"

namespace pxpl5::bus::trace {

namespace {

/// The binary schema of TraceEntry, so that tools that know nothing of us can decode the file.
constexpr std::uint8_t entry_schema[] = {
#include "trace_schema.inc"
};

mcap::Preamble preamble_of(const Info& info) {
    return {info.build,  metadata_name, to_metadata(info),
            schema_name, encoding,      std::span(entry_schema)};
}

}  // namespace

struct TraceWriter::Parts {
    mcap::Writer file;
    std::map<NodeId, std::string> names;
    std::map<std::pair<NodeId, Body>, std::uint16_t> channels;
    flatbuffers::FlatBufferBuilder builder{};

    /// Takes the names of nodes from a Topology.
    void learn_names(const Message& message) {
        if (const auto* hello = message.as<schema::Hello>()) {
            names[message.source()] = name_of(hello->role(), hello->index());
        } else if (const auto* topology = message.as<schema::Topology>()) {
            for (const auto* node : *topology->nodes()) {
                names[node->id()] = name_of(node->role(), node->index());
            }
        }
    }

    std::uint16_t channel_of(const Message& message) {
        const auto [at, is_new] = channels.try_emplace({message.source(), message.kind()});
        if (is_new) {
            const auto name = names.find(message.source());
            const std::string source =
                name != names.end() ? name->second : fmt::format("node-{}", message.source());
            at->second = file.channel(fmt::format("/{}/{}", source, kind_name(message.kind())),
                                      {{"source", std::to_string(message.source())}});
        }
        return at->second;
    }

    std::span<const std::uint8_t> entry(const Message& message, std::uint64_t wall_ns) {
        builder.Clear();
        builder.ForceVectorAlignment(message.bytes().size(), 1, 8);
        const auto body = builder.CreateVector(message.bytes().data(), message.bytes().size());
        builder.Finish(schema::CreateTraceEntry(builder, &message.header(), wall_ns, body));
        return {builder.GetBufferPointer(), builder.GetSize()};
    }
};

TraceWriter::TraceWriter(const std::filesystem::path& path, const Info& info)
    : parts_(new Parts{.file = mcap::Writer(path, preamble_of(info)),
                       .names = {{host_id, name_of(schema::Role::host, 0)}},
                       .channels = {}}) {}

TraceWriter::~TraceWriter() = default;

void TraceWriter::add(const Message& message, std::uint64_t wall_ns) {
    parts_->learn_names(message);
    parts_->file.message(parts_->channel_of(message),
                         static_cast<std::uint32_t>(message.header().clock()), wall_ns,
                         parts_->entry(message, wall_ns));
}

void TraceWriter::flush() {
    parts_->file.end_chunk();
}

void TraceWriter::close() {
    parts_->file.close();
}

std::uint64_t TraceWriter::messages() const {
    return parts_->file.messages();
}
std::uint64_t TraceWriter::bytes() const {
    return parts_->file.bytes();
}

}  // namespace pxpl5::bus::trace
