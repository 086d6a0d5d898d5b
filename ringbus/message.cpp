#include "ringbus/message.hpp"

#include <fmt/core.h>

#include <cassert>

#include "ringbus/channel_model.hpp"
#include "ringbus/ranges.hpp"
#include "schema_hash.hpp"

namespace pxpl5::bus {

namespace {

void check(bool good, const schema::Header& header, std::string_view field, std::uint64_t got,
           std::uint64_t wanted) {
    if (!good) {
        throw BadMessage(header, fmt::format("message from node {}: {} is {}, expected {}",
                                             header.source(), field, got, wanted));
    }
}

/// Returns true if the bytes are a well-formed message: no offset leads outside.
bool is_well_formed(std::span<const std::uint8_t> body) {
    flatbuffers::Verifier verifier(body.data(), body.size(), max_body_depth, max_body_tables);
    return body.size() >= 2 * sizeof(flatbuffers::uoffset_t) &&
           schema::MessageBufferHasIdentifier(body.data()) && schema::VerifyMessageBuffer(verifier);
}

}  // namespace

void check_header(const schema::Header& header, std::size_t body_bytes) {
    constexpr auto last_kind = static_cast<std::uint16_t>(Body::MAX);
    check(header.magic() == header_magic, header, "magic", header.magic(), header_magic);
    check(header.version() == protocol_version, header, "protocol version", header.version(),
          protocol_version);
    check(header.kind() >= 1, header, "kind", header.kind(), 1);
    check(header.kind() <= last_kind, header, "kind", header.kind(), last_kind);
    check(header.reserved() == 0, header, "reserved field", header.reserved(), 0);
    check(header.channel() < max_channels, header, "channel", header.channel(), max_channels - 1);
    check(header.departure_ns() <= header.arrival_ns(), header, "departure", header.departure_ns(),
          header.arrival_ns());
    check(header.body_bytes() == body_bytes, header, "body size", body_bytes, header.body_bytes());
    check(body_bytes <= max_body_bytes, header, "body size", body_bytes, max_body_bytes);
}

Message::Message(const schema::Header& header, std::span<const std::uint8_t> body,
                 std::shared_ptr<const void> owner)
    : header_(header), body_(body), owner_(std::move(owner)) {
    assert(reinterpret_cast<std::uintptr_t>(body.data()) % body_alignment == 0);
    check_header(header, body.size());
    const auto refuse = [&](const std::string& reason) {
        throw BadMessage(header, fmt::format("{} {} from node {}: {}", kind_name(kind()),
                                             header.sequence(), source(), reason));
    };
    if (!is_well_formed(body)) {
        refuse(fmt::format("its {} bytes are not a valid message", body.size()));
    }
    const schema::Message& message = *schema::GetMessage(body.data());
    if (message.body_type() != kind()) {
        refuse(fmt::format("the header says {}, the body is {}", kind_name(kind()),
                           kind_name(message.body_type())));
    }
    if (const std::string reason = out_of_range(message, body.size()); !reason.empty()) {
        refuse(reason);
    }
}

bool is_of_frame(Body kind) {
    return kind == Body::DrawFrame || kind == Body::BeginFrame || kind == Body::RegionPrograms ||
           kind == Body::RegionPixels || kind == Body::FrameDone || kind == Body::FrameCounts;
}

std::optional<std::uint32_t> frame_of(const Message& message) {
    switch (message.kind()) {
        case Body::DrawFrame:
            return message.as<schema::DrawFrame>()->frame();
        case Body::BeginFrame:
            return message.as<schema::BeginFrame>()->draw()->frame();
        case Body::RegionPrograms:
            return message.as<schema::RegionPrograms>()->frame();
        case Body::RegionPixels:
            return message.as<schema::RegionPixels>()->frame();
        case Body::FrameDone:
            return message.as<schema::FrameDone>()->frame();
        case Body::FrameCounts:
            return message.as<schema::FrameCounts>()->frame();
        default:
            return std::nullopt;
    }
}

std::string kind_name(Body kind) {
    const char* name = schema::EnumNameBody(kind);
    return *name != 0 ? name : fmt::format("kind {}", static_cast<int>(kind));
}

std::uint64_t schema_hash() {
    return generated_schema_hash;
}

}  // namespace pxpl5::bus
