// Measures messages between two nodes by size. The answer is short.
#include <benchmark/benchmark.h>

#include <cstring>
#include <thread>

#include "ringbus/zmq/arena.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/ringbus/ipc_address.hpp"

using namespace pxpl5;
namespace schema = bus::schema;

namespace {

constexpr bus::NodeId near_id = 1, far_id = 2;
constexpr std::uint32_t last_volume = 0xFFFFFFFF;  ///< Ends the answering thread.
constexpr std::size_t line_bytes = 64;
constexpr int patience_ms = 10'000;

/// A new message of about `bytes`, in the memory of the sender's link, or, as if the receiver were
/// on another computer, in memory that the link cannot lend.
bus::Payload message_of(std::size_t bytes, std::uint32_t volume, bus::ZmqLink& link,
                        bool is_lent = true) {
    flatbuffers::FlatBufferBuilder builder(bytes + 1024, is_lent ? link.body_allocator() : nullptr);
    std::uint8_t* values = nullptr;
    const auto vector = builder.CreateUninitializedVector(bytes, &values);
    std::memset(values, static_cast<int>(volume & 0xFF), bytes);
    return bus::finish(builder, schema::CreateSlices(builder, volume, 0, 1, vector));
}

/// Reads a byte of every cache line, the least that a receiver does.
std::uint64_t read_lines(const flatbuffers::Vector<std::uint8_t>& values) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < values.size(); i += line_bytes) {
        sum += values.data()[i];
    }
    return sum;
}

bus::Message next(bus::ZmqLink& link) {
    while (true) {
        if (auto message = link.receive()) {
            return *message;
        }
        if (!link.wait(patience_ms)) {
            throw std::runtime_error("no message came");
        }
    }
}

/// Reads each message and answers with a short message, until the last volume arrives.
void answer(bus::ZmqLink& link) {
    while (true) {
        const bus::Message message = next(link);
        const auto* slices = message.as<schema::Slices>();
        if (slices->volume() == last_volume) {
            return;
        }
        benchmark::DoNotOptimize(read_lines(*slices->values()));
        link.send(near_id, bus::pack(schema::VolumeReadyT{}));
    }
}

/// Whether a message of so many bytes can be lent, or is small enough to be copied.
bool is_lent_if_large(std::size_t bytes, bus::ZmqLink& link) {
    const auto& arena = dynamic_cast<const bus::Arena&>(*link.body_allocator());
    // Not volume 0, the default, which takes no room: bodies would lie otherwise.
    const bus::Payload payload = message_of(bytes, 1, link);
    return payload.bytes().size() < bus::min_arena_body_bytes || arena.can_lend(payload);
}

/// Sends messages of state.range(0) bytes from `here` to `there`, each when the last is answered.
void exchange(benchmark::State& state, bus::ZmqLink& here, bus::ZmqLink& there, bool is_lent) {
    const auto bytes = static_cast<std::size_t>(state.range(0));
    here.add_peer(far_id, schema::Role::gp, there.endpoint());
    there.add_peer(near_id, schema::Role::host, here.endpoint());
    if (is_lent && !is_lent_if_large(bytes, here)) {
        state.SkipWithError("the body is not lent: it would be copied");
        return;
    }
    std::thread other([&there] { answer(there); });
    std::uint32_t number = 0;
    for (auto _ : state) {
        here.send(far_id, message_of(bytes, ++number, here, is_lent));
        benchmark::DoNotOptimize(next(here));
    }
    here.send(far_id, message_of(1, last_volume, here));
    other.join();
    state.SetBytesProcessed(state.iterations() * state.range(0));
}

/// There and back. Its CPU time, of all threads, is what two wake-ups and `bytes` cost.
void there_and_back(benchmark::State& state) {
    bus::ZmqLink here({near_id, schema::Role::host}, test::ipc_address("near"));
    bus::ZmqLink there({far_id, schema::Role::gp}, test::ipc_address("far"));
    exchange(state, here, there, true);
}
BENCHMARK(there_and_back)
    ->ArgName("bytes")
    ->RangeMultiplier(16)
    ->Range(64, 16 << 20)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMicrosecond);

/// The same between two computers: the differences of CPU times with and without encryption, and
/// of two sizes, are what both ends need for a message and for a byte.
void over_tcp(benchmark::State& state) {
    const auto protection =
        state.range(1) != 0 ? bus::Protection::curve : bus::Protection::plain_tcp;
    const bus::Credentials credentials = bus::make_credentials(protection);
    bus::ZmqLink here({near_id, schema::Role::host}, "tcp://127.0.0.1:*", credentials);
    bus::ZmqLink there({far_id, schema::Role::gp}, "tcp://127.0.0.1:*", credentials);
    exchange(state, here, there, false);
}
BENCHMARK(over_tcp)
    ->ArgNames({"bytes", "curve"})
    ->ArgsProduct({{64, 1 << 14, 1 << 20}, {0, 1}})
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
