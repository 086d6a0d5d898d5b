// Large bodies for tests of shared memory.
#pragma once

#include <string>

#include "ringbus/zmq/zmq_link.hpp"
#include "tests/random_seed.hpp"

namespace pxpl5::test {

/// Slices whose values follow from `number`, built in `memory`, which must have room.
inline bus::Payload large_slices(flatbuffers::Allocator* memory, std::size_t bytes,
                                 std::uint32_t number) {
    flatbuffers::FlatBufferBuilder builder(bytes + 256, memory);
    std::uint8_t* values = nullptr;
    const auto values_at = builder.CreateUninitializedVector(bytes, &values);
    for (std::size_t i = 0; i < bytes; ++i) {
        values[i] = static_cast<std::uint8_t>(i * 7 + number);
    }
    return bus::finish(builder, bus::schema::CreateSlices(builder, 0, number % 4096, 1, values_at));
}

/// Returns true if `message` equals large_slices(bytes, number).
inline bool is_whole(const bus::Message& message, std::size_t bytes, std::uint32_t number) {
    const auto* slices = message.as<bus::schema::Slices>();
    bool whole = slices != nullptr && slices->first_slice() == number % 4096 &&
                 slices->values()->size() == bytes;
    for (std::size_t i = 0; whole && i < bytes; ++i) {
        whole = slices->values()->data()[i] == static_cast<std::uint8_t>(i * 7 + number);
    }
    return whole;
}

constexpr int large_patience_ms = 30000;

inline bus::Message next_of(bus::ZmqLink& link) {
    while (true) {
        if (auto message = link.receive()) {
            return *message;
        }
        REQUIRE(link.wait(large_patience_ms));
    }
}

}  // namespace pxpl5::test
