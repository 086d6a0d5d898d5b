// Compressed bodies of messages, for slow networks between computers.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <zmq.hpp>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Smaller bodies travel as they are.
inline constexpr std::size_t min_packed_body_bytes = 1024;

/// Follows the header of a message whose body is compressed. The header's body_bytes is the size
/// of the body itself.
struct PackedBody {
    std::uint32_t method = 1;  ///< 1: a frame of zstd.
};

/// Compresses bodies. Keeps its working memory from one body to the next.
class Packer {
  public:
    Packer();
    ~Packer();
    Packer(const Packer&) = delete;
    Packer& operator=(const Packer&) = delete;

    /// The compressed bytes; nothing if they would save less than a tenth, or without memory.
    std::optional<zmq::message_t> pack(std::span<const std::uint8_t> body);

  private:
    struct Context;
    std::unique_ptr<Context> context_;
};

/// The body of a message that was compressed. Throws BadMessage if the bytes are not those of a
/// body with the size in `header`.
std::shared_ptr<zmq::message_t> unpacked_body(const schema::Header& header, const PackedBody& form,
                                              const zmq::message_t& packed);

}  // namespace pxpl5::bus
