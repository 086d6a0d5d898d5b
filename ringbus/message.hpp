// A message: a fixed header and a FlatBuffers body, owned, verified, cheap to copy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "generated/vocabulary.hpp"
#include "message_generated.h"

namespace pxpl5::bus {

using NodeId = std::uint16_t;
inline constexpr NodeId host_id = 0;  ///< The host is node 0 of every machine.

inline constexpr std::uint32_t header_magic = 0x35505850;  ///< "PXP5", little endian.
inline constexpr std::uint16_t protocol_version = 5;
inline constexpr std::size_t max_body_bytes = std::size_t{1} << 30;
/// Alignment of a finished body. No field of a message needs more.
inline constexpr std::size_t body_alignment = sizeof(std::uint64_t);
inline constexpr std::size_t max_body_depth = 16;
inline constexpr std::size_t max_body_tables = 1'000'000;

using schema::Body;

/// A finished body. Immutable and shared, so that a broadcast stores it once.
class Payload {
  public:
    Payload() = default;
    explicit Payload(flatbuffers::DetachedBuffer buffer)
        : buffer_(std::make_shared<const flatbuffers::DetachedBuffer>(std::move(buffer))) {}
    std::span<const std::uint8_t> bytes() const { return {buffer_->data(), buffer_->size()}; }
    Body kind() const { return schema::GetMessage(buffer_->data())->body_type(); }

  private:
    std::shared_ptr<const flatbuffers::DetachedBuffer> buffer_;
};

/// Finishes `builder` with `body` as the message and takes the buffer out of it.
template <typename T>
Payload finish(flatbuffers::FlatBufferBuilder& builder, flatbuffers::Offset<T> body) {
    builder.TrackMinAlign(body_alignment);  // A receiver may read the body in place.
    builder.Finish(schema::CreateMessage(builder, schema::BodyTraits<T>::enum_value, body.Union()),
                   schema::MessageIdentifier());
    return Payload(builder.Release());
}

/// Packs an object-API table, for example pack(schema::ShutdownT{...}). For small messages.
template <typename ObjectT>
Payload pack(const ObjectT& object) {
    flatbuffers::FlatBufferBuilder builder;
    return finish(builder, ObjectT::TableType::Pack(builder, &object));
}

/// The message that asked for work that failed, as a Fault names it.
struct FaultCause {
    Body request = Body::NONE;                ///< Kind of the message; NONE if unknown.
    std::optional<std::uint32_t> frame = {};  ///< The frame that fails, if any.
};

/// The header's kind, or NONE if this build knows no such kind.
inline Body known_kind(const schema::Header& header) {
    return header.kind() <= static_cast<std::uint16_t>(Body::MAX) ? static_cast<Body>(header.kind())
                                                                  : Body::NONE;
}

/// Thrown for bytes that are not a valid message: wrong size, magic, version, kind, or not a
/// verifiable FlatBuffer. `what` names the sender, the field and both values.
struct BadMessage : std::runtime_error {
    using std::runtime_error::runtime_error;
    BadMessage(const schema::Header& header, const std::string& reason)
        : std::runtime_error(reason),
          cause{known_kind(header)},
          source(header.source()),
          sequence(header.sequence()) {}
    FaultCause cause;            ///< Without a frame: the body is not trusted.
    NodeId source = host_id;     ///< From the header, which may be wrong.
    std::uint64_t sequence = 0;  ///< From the header, which may be wrong.
};

/// A received, verified message. Copies share the bytes.
class Message {
  public:
    /// Verifies header and body. `owner` keeps `body` alive; `body` must be aligned.
    /// Throws BadMessage.
    Message(const schema::Header& header, std::span<const std::uint8_t> body,
            std::shared_ptr<const void> owner);

    const schema::Header& header() const { return header_; }
    NodeId source() const { return header_.source(); }
    Body kind() const { return static_cast<Body>(header_.kind()); }
    std::span<const std::uint8_t> bytes() const { return body_; }

    /// The body as table T, or null if the message is of another kind.
    template <typename T>
    const T* as() const {
        return schema::GetMessage(body_.data())->template body_as<T>();
    }

  private:
    schema::Header header_;
    std::span<const std::uint8_t> body_;
    std::shared_ptr<const void> owner_;
};

/// Checks all fields of the header, including the size of the body. Throws BadMessage.
void check_header(const schema::Header& header, std::size_t body_bytes);

/// True if messages of this kind belong to a frame.
bool is_of_frame(Body kind);

/// The number of the frame that the message belongs to, if its kind belongs to frames.
std::optional<std::uint32_t> frame_of(const Message& message);

/// Names `message` as the cause of a fault.
inline FaultCause cause_of(const Message& message) {
    return {message.kind(), frame_of(message)};
}

/// "RegionPrograms", for error texts and logs.
std::string kind_name(Body kind);

/// Hash of all schema files, agreed on in Hello.
std::uint64_t schema_hash();

}  // namespace pxpl5::bus
