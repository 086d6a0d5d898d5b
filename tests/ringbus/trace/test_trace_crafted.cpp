// Trace files that no writer writes: what they may cost.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <zstd.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "ringbus/trace/mcap.hpp"
#include "ringbus/trace/trace_file.hpp"
#include "ringbus/trace/trace_info.hpp"
#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/trace/recorder_support.hpp"
#include "trace_generated.h"

using namespace pxpl5;
using namespace pxpl5::bus;
using namespace pxpl5::bus::trace;

namespace {

/// The begin, then zeros up to `size` bytes, compressed without ever being whole in memory.
mcap::Bytes compressed(const mcap::Bytes& begin, std::uint64_t size) {
    const std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(),
                                                                          ZSTD_freeCCtx);
    ZSTD_CCtx_setPledgedSrcSize(context.get(), size);
    mcap::Bytes to, piece(begin);
    for (std::uint64_t done = 0; done < size;) {
        ZSTD_inBuffer from{piece.data(), piece.size(), 0};
        done += piece.size();
        const ZSTD_EndDirective then = done == size ? ZSTD_e_end : ZSTD_e_continue;
        for (bool is_done = false; !is_done;) {
            const std::size_t before = to.size();
            to.resize(before + ZSTD_CStreamOutSize());
            ZSTD_outBuffer out{to.data() + before, ZSTD_CStreamOutSize(), 0};
            const std::size_t left = ZSTD_compressStream2(context.get(), &out, &from, then);
            REQUIRE(ZSTD_isError(left) == 0);
            to.resize(before + out.pos);
            is_done = then == ZSTD_e_end ? left == 0 : from.pos == from.size;
        }
        piece.assign(std::min<std::uint64_t>(size - done, std::uint64_t{1} << 20), 0);
    }
    return to;
}

/// A file of compressed chunks with these records, and zeros up to `size` bytes.
void write_chunk(const std::filesystem::path& path, const mcap::Bytes& records, int copies = 1,
                 std::uint64_t size = 0) {
    size = std::max<std::uint64_t>(size, records.size());
    const mcap::Bytes data = compressed(records, size);
    mcap::Bytes file(mcap::magic.begin(), mcap::magic.end());
    mcap::Out out(file);
    out.record(mcap::Op::header, [&] { out.text("").text("test"); });
    out.record(mcap::Op::metadata, [&] {
        out.text(metadata_name).texts(to_metadata(test::info_for(Recording::full)));
    });
    for (int n = 0; n < copies; ++n) {
        out.record(mcap::Op::chunk, [&] {
            out.number(std::uint64_t{0}).number(std::uint64_t{0});
            out.number(size).number(std::uint32_t{0}).text("zstd");
            out.number(std::uint64_t{data.size()}).raw(data);
        });
    }
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()), static_cast<long>(file.size()));
}

constexpr std::uint64_t huge = std::uint64_t{900} << 20;

/// The begin of a message record that ends with the chunk of `huge` bytes.
mcap::Bytes huge_message(const mcap::Bytes& data) {
    mcap::Bytes record;
    mcap::Out out(record);
    out.op(mcap::Op::message).number(huge - mcap::record_head_bytes);
    out.number(std::uint16_t{1}).number(std::uint32_t{1});
    out.number(std::uint64_t{1}).number(std::uint64_t{1}).raw(data);
    return record;
}

/// The begin of an entry whose body has `body_bytes`. Its header states another kind and size; the
/// body begins as a Topology.
mcap::Bytes begun_entry(Body kind, std::uint32_t body_bytes, std::uint32_t stated_bytes) {
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(kind), 1, 0, 0, 0, 0, stated_bytes, 0, 0,
                                0);
    flatbuffers::FlatBufferBuilder builder;
    const bus::Payload body = test::topology_with(2);
    builder.ForceVectorAlignment(body.bytes().size(), 1, 8);
    const auto bytes = builder.CreateVector(body.bytes().data(), body.bytes().size());
    builder.Finish(schema::CreateTraceEntry(builder, &header, 1, bytes));
    mcap::Bytes entry(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
    const auto at = static_cast<std::size_t>(
        reinterpret_cast<const std::uint8_t*>(schema::GetTraceEntry(entry.data())->message()) -
        entry.data());
    flatbuffers::WriteScalar(entry.data() + at, body_bytes);  // The size of the vector.
    return entry;
}

/// The largest memory that this process has had, in KiB.
long most_memory_kib() {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return used.ru_maxrss;
}

/// The records of a recorded chunk.
mcap::Bytes recorded_chunk(const std::filesystem::path& path, int messages) {
    TraceWriter writer(path, test::info_for(Recording::full));
    for (int n = 0; n < messages; ++n) {
        writer.add(test::from(1, test::surface(3, static_cast<std::uint32_t>(n))), 1);
    }
    writer.close();
    const TraceFile file(path);
    mcap::Bytes bytes(static_cast<std::size_t>(std::filesystem::file_size(path)));
    std::ifstream(path, std::ios::binary)
        .read(reinterpret_cast<char*>(bytes.data()), static_cast<long>(bytes.size()));
    mcap::In in(bytes);
    in.raw(file.entries().front().chunk + mcap::record_head_bytes);
    in.raw(2 * sizeof(std::uint64_t));
    mcap::Bytes records(static_cast<std::size_t>(in.number<std::uint64_t>()));
    in.number<std::uint32_t>(), in.text();
    const auto data = in.raw(in.number<std::uint64_t>());
    REQUIRE(ZSTD_decompress(records.data(), records.size(), data.data(), data.size()) ==
            records.size());
    return records;
}

}  // namespace

TEST_SUITE("crafted traces") {
    TEST_CASE("a small file that claims a huge chunk takes no memory") {
        const auto bytes = static_cast<std::uint32_t>(huge - 4096);
        struct Crafted {
            mcap::Bytes begin;
            std::string reason;
        };
        const std::vector<Crafted> files = {
            {{}, "with no message to its end at byte 0"},
            {huge_message({}), "that is no entry"},
            {huge_message(begun_entry(Body::Topology, bytes, bytes - 1)), "body size"},
            {huge_message(begun_entry(Body::Go, bytes, bytes)), "that is no entry"},
        };
        for (const Crafted& crafted : files) {
            CAPTURE(crafted.reason);
            const test::ScratchFolder folder;
            write_chunk(folder / "a.mcap", crafted.begin, 1, huge);
            CHECK(std::filesystem::file_size(folder / "a.mcap") < 200'000);
            const long before = most_memory_kib();
            const TraceFile file(folder / "a.mcap");
            CHECK(file.entries().empty());
            CHECK(file.cut().find(crafted.reason) != std::string::npos);
            CHECK(most_memory_kib() - before < 32 * 1024);
        }
    }
    TEST_CASE("the begin of a huge message tells its kind and size") {
        const test::ScratchFolder folder;
        const auto bytes = static_cast<std::uint32_t>(huge - 4096);
        write_chunk(folder / "a.mcap", huge_message(begun_entry(Body::Topology, bytes, bytes)), 1,
                    huge);
        const long before = most_memory_kib();
        const TraceFile file(folder / "a.mcap");
        REQUIRE(file.entries().size() == 1);
        CHECK(file.entries().front().kind() == Body::Topology);
        CHECK(file.entries().front().header.body_bytes() == bytes);
        CHECK(most_memory_kib() - before < 32 * 1024);
    }
    TEST_CASE("only the last message of a chunk may end beyond its usual size") {
        const test::ScratchFolder folder;
        mcap::Bytes records = recorded_chunk(folder / "whole.mcap", 5000);
        write_chunk(folder / "whole.mcap", records);
        CHECK(TraceFile(folder / "whole.mcap").entries().size() == 5000);
        const mcap::Bytes once = records;
        while (records.size() <= 2 * mcap::chunk_bytes) {
            records.insert(records.end(), once.begin(), once.end());
        }
        write_chunk(folder / "long.mcap", records);
        CHECK(TraceFile(folder / "long.mcap").entries().empty());
    }
    TEST_CASE("a file has no more messages than its bytes can index") {
        const test::ScratchFolder folder;
        const mcap::Bytes records = recorded_chunk(folder / "a.mcap", 5000);
        write_chunk(folder / "a.mcap", records, 100);
        const TraceFile file(folder / "a.mcap");
        CHECK(file.cut().find("too many for a file of") != std::string::npos);
        CHECK(file.entries().size() < 500'000);
    }
    TEST_CASE("a FIFO is no trace, and opening it does not wait") {
        const test::ScratchFolder folder;
        REQUIRE(mkfifo((folder / "pipe.mcap").c_str(), 0600) == 0);
        CHECK_THROWS_AS(TraceFile(folder / "pipe.mcap"), TraceError);
    }
    TEST_CASE("a trace is for its owner alone, and no link is followed to write it") {
        const test::ScratchFolder folder;
        { const TraceWriter writer(folder / "a.mcap", test::info_for(Recording::full)); }
        struct stat facts {};
        REQUIRE(stat((folder / "a.mcap").c_str(), &facts) == 0);
        CHECK((facts.st_mode & 0777) == 0600);
        std::filesystem::create_symlink(folder / "elsewhere", folder / "link.mcap");
        CHECK_THROWS_AS(TraceWriter(folder / "link.mcap", test::info_for(Recording::full)),
                        TraceError);
        CHECK(!std::filesystem::exists(folder / "elsewhere"));
    }
}
