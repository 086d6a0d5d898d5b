// What tests of shared memory send: bodies built where the link says.
#pragma once

#include <string>

#include "ringbus/zmq_link.hpp"
#include "tests/ringbus/random_seed.hpp"

namespace pxpl5::test {

/// Slices whose values follow from `number`, built in `memory`, which has room for all of it.
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

/// Whether `message` is large_slices(bytes, number), to the last byte.
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
