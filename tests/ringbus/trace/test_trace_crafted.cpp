// Trace files that no writer writes: what they may cost.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <zstd.h>

#include <fstream>

#include "ringbus/trace/mcap.hpp"
#include "ringbus/trace/trace_file.hpp"
#include "ringbus/trace/trace_info.hpp"
#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/trace/recorder_support.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using namespace pxpl5::bus::trace;

namespace {

/// A file whose one compressed chunk has these records.
void write_chunk(const std::filesystem::path& path, const mcap::Bytes& records, int copies = 1) {
    mcap::Bytes compressed(ZSTD_compressBound(records.size()));
    compressed.resize(
        ZSTD_compress(compressed.data(), compressed.size(), records.data(), records.size(), 1));
    mcap::Bytes file(mcap::magic.begin(), mcap::magic.end());
    mcap::Out out(file);
    out.record(mcap::Op::header, [&] { out.text("").text("test"); });
    out.record(mcap::Op::metadata, [&] {
        out.text(metadata_name).texts(to_metadata(test::info_for(Recording::full)));
    });
    for (int n = 0; n < copies; ++n) {
        out.record(mcap::Op::chunk, [&] {
            out.number(std::uint64_t{0}).number(std::uint64_t{0});
            out.number(std::uint64_t{records.size()}).number(std::uint32_t{0}).text("zstd");
            out.number(std::uint64_t{compressed.size()}).raw(compressed);
        });
    }
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()), static_cast<long>(file.size()));
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
    TEST_CASE("a chunk of half a gigabyte without a message takes no memory") {
        const test::ScratchFolder folder;
        write_chunk(folder / "a.mcap", mcap::Bytes(std::size_t{512} << 20));
        CHECK(std::filesystem::file_size(folder / "a.mcap") < 100'000);
        const long before = most_memory_kib();
        const TraceFile file(folder / "a.mcap");
        CHECK(file.entries().empty());
        CHECK(file.cut().find("with no message to its end at byte 0") != std::string::npos);
        // The chunk was in memory to be written: only more than that would show.
        CHECK(most_memory_kib() - before < 64 * 1024);
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
