// Messages for tests: made, damaged, and read back as from the wire.
#pragma once

#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::test {

/// A message as received. A test may damage header and body first.
struct WireBytes {
    bus::schema::Header header;
    std::shared_ptr<std::vector<std::uint64_t>> body;
    std::size_t size;

    explicit WireBytes(const bus::Payload& payload)
        : header(bus::header_magic, bus::protocol_version,
                 static_cast<std::uint16_t>(payload.kind()), 3, 5, 0, 0, 7, payload.bytes().size(),
                 0, 0, 1),
          body(std::make_shared<std::vector<std::uint64_t>>(payload.bytes().size() / 8 + 1)),
          size(payload.bytes().size()) {
        std::memcpy(body->data(), payload.bytes().data(), size);
    }
    std::uint8_t* bytes() { return reinterpret_cast<std::uint8_t*>(body->data()); }
    bus::Message read() { return {header, {bytes(), size}, body}; }
};

/// The text of the refusal; "" if the message is accepted.
inline std::string refusal(WireBytes wire) {
    try {
        wire.read();
    } catch (const bus::BadMessage& bad) {
        return bad.what();
    }
    return {};
}

inline std::string refusal(const bus::Payload& payload) {
    return refusal(WireBytes(payload));
}

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace pxpl5::test
