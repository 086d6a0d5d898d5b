#include "ringbus/message.hpp"

#include <fmt/core.h>

#include <cassert>

#include "ringbus/ranges.hpp"
#include "schema_hash.hpp"

namespace pxpl5::bus {

namespace {

constexpr std::size_t body_alignment = 8;

void check(bool good, NodeId source, std::string_view field, std::uint64_t got,
           std::uint64_t wanted) {
    if (!good) {
        throw BadMessage(
            fmt::format("message from node {}: {} is {}, expected {}", source, field, got, wanted));
    }
}

/// Everything that the header says about itself and the body's size.
void check_header(const schema::Header& header, std::size_t body_bytes) {
    const NodeId source = header.source();
    check(header.magic() == header_magic, source, "magic", header.magic(), header_magic);
    check(header.version() == protocol_version, source, "protocol version", header.version(),
          protocol_version);
    check(header.body_bytes() == body_bytes, source, "body size", body_bytes, header.body_bytes());
    check(body_bytes <= max_body_bytes, source, "body size", body_bytes, max_body_bytes);
    check(header.kind() > 0 && header.kind() <= static_cast<std::uint16_t>(Body::MAX), source,
          "kind", header.kind(), static_cast<std::uint16_t>(Body::MAX));
}

}  // namespace

Message::Message(const schema::Header& header, std::span<const std::uint8_t> body,
                 std::shared_ptr<const void> owner)
    : header_(header), body_(body), owner_(std::move(owner)) {
    assert(reinterpret_cast<std::uintptr_t>(body.data()) % body_alignment == 0);
    check_header(header, body.size());
    flatbuffers::Verifier verifier(body.data(), body.size(), max_body_depth, max_body_tables);
    if (body.size() < 2 * sizeof(flatbuffers::uoffset_t) ||
        !schema::MessageBufferHasIdentifier(body.data()) ||
        !schema::VerifyMessageBuffer(verifier)) {
        throw BadMessage(fmt::format("message {} of {} bytes from node {} is not a valid {} body",
                                     header.sequence(), body.size(), source(), kind_name(kind())));
    }
    const Body found = schema::GetMessage(body.data())->body_type();
    if (found != kind()) {
        throw BadMessage(fmt::format("message {} from node {}: the header says {}, the body is {}",
                                     header.sequence(), source(), kind_name(kind()),
                                     kind_name(found)));
    }
    if (const std::string reason = out_of_range(*schema::GetMessage(body.data()));
        !reason.empty()) {
        throw BadMessage(fmt::format("{} {} from node {}: {}", kind_name(kind()), header.sequence(),
                                     source(), reason));
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
