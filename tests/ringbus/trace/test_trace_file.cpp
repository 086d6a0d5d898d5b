#include <doctest/doctest.h>
#include <fmt/core.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "ringbus/trace/trace_file.hpp"
#include "tests/random_seed.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/scratch_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using trace::TraceError;
using trace::TraceFile;
using trace::TraceWriter;

namespace {

using Bytes = std::vector<char>;

trace::Info example_info() {
    trace::Info info;
    info.build = "pxpl5 test";
    info.schema_hash = schema_hash();
    info.node = 7;
    info.role = schema::Role::renderer;
    info.index = 3;
    info.dropped = 12;
    info.more = {{"isa_hash", "abc"}, {"topology", "{\n  \"roles\": {}\n}"}};
    return info;
}

/// `payload` as node 7 receives it.
Message received(const Payload& payload, NodeId source, std::uint64_t sequence) {
    const auto bytes = payload.bytes();
    const auto words = std::make_shared<std::vector<std::uint64_t>>(bytes.size() / 8 + 1);
    std::memcpy(words->data(), bytes.data(), bytes.size());
    const schema::Header header(header_magic, protocol_version,
                                static_cast<std::uint16_t>(payload.kind()), source, 7, 2, 0,
                                sequence, bytes.size(), 100, 200 + sequence, 5000 + sequence);
    const auto* start = reinterpret_cast<const std::uint8_t*>(words->data());
    return {header, {start, bytes.size()}, words};
}

std::vector<Message> example_messages() {
    std::vector<Message> messages;
    for (const Payload& payload : test::one_of_each_kind()) {
        messages.push_back(
            received(payload, static_cast<NodeId>(messages.size() % 3), messages.size()));
    }
    return messages;
}

/// Every third message ends a chunk.
void write_example(const std::filesystem::path& path, const std::vector<Message>& messages) {
    TraceWriter writer(path, example_info());
    for (std::size_t i = 0; i < messages.size(); ++i) {
        writer.add(messages[i], 1000 + i);
        if (i % 3 == 2) {
            writer.flush();
        }
    }
    CHECK(writer.messages() == messages.size());
    writer.close();
    CHECK(writer.bytes() == std::filesystem::file_size(path));
}

Bytes read_all(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void write_all(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

bool same_header(const schema::Header& a, const schema::Header& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

bool same_message(const Message& a, const Message& b) {
    return same_header(a.header(), b.header()) &&
           std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin(), b.bytes().end());
}

/// Number of readable messages, which must be the first of `messages`; an incomplete file must
/// report its end. -1 if the file cannot be opened.
int readable(const std::filesystem::path& path, const std::vector<Message>& messages) {
    try {
        const TraceFile file(path);
        bool sound = !file.cut().empty() && file.entries().size() <= messages.size();
        for (std::size_t i = 0; sound && i < file.entries().size(); ++i) {
            sound = same_header(file.entries()[i].header, messages[i].header());
        }
        REQUIRE(sound);
        return static_cast<int>(file.entries().size());
    } catch (const TraceError& error) {
        REQUIRE(std::string(error.what()).find(path.string()) != std::string::npos);
        return -1;
    }
}

/// All offsets of a file, but only every 31st of the two copies of the schema.
std::vector<std::size_t> places_in(const Bytes& whole) {
    const std::string schema = "pxpl5.bus.schema.TraceEntry";
    std::vector<std::size_t> places;
    std::size_t sparse_until = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
        if (whole.size() - at > schema.size() &&
            std::equal(schema.begin(), schema.end(), whole.begin() + static_cast<long>(at))) {
            std::uint64_t record_bytes =
                0;  // 14 bytes before: opcode, this, number, name's length.
            std::memcpy(&record_bytes, whole.data() + at - 14, sizeof record_bytes);
            sparse_until = at + static_cast<std::size_t>(record_bytes) - schema.size();
        }
        if (at >= sparse_until || at % 31 == 0) {
            places.push_back(at);
        }
    }
    return places;
}

/// Changes one byte of a file in place.
void set_byte(const std::filesystem::path& path, std::size_t at, char value) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<long>(at)).put(value);
}

}  // namespace

TEST_SUITE("ringbus/trace_file") {
    TEST_CASE("every kind of message is read back byte for byte") {
        const test::ScratchFolder folder;
        const std::vector<Message> messages = example_messages();
        write_example(folder / "a.mcap", messages);
        const TraceFile file(folder / "a.mcap");
        CHECK(file.cut() == "");
        REQUIRE(file.entries().size() == messages.size());
        for (std::size_t i = messages.size(); i-- > 0;) {  // Backwards: chunks are loaded again.
            const trace::Entry& entry = file.entries()[i];
            CHECK(entry.wall_ns == 1000 + i);
            CHECK(entry.kind() == messages[i].kind());
            CHECK(same_message(file.load(entry), messages[i]));
        }
    }

    TEST_CASE("a file describes itself") {
        const test::ScratchFolder folder;
        write_example(folder / "a.mcap", {});
        const TraceFile file(folder / "a.mcap");
        CHECK(file.entries().empty());
        CHECK(file.cut() == "");
        const trace::Info &info = file.info(), wanted = example_info();
        CHECK(info.build == wanted.build);
        CHECK(info.node == 7);
        CHECK(info.node_name() == "renderer-3");
        CHECK(info.recording == Recording::full);
        CHECK(info.dropped == 12);
        CHECK(info.more == wanted.more);
    }

    TEST_CASE("messages from nothing to larger than a chunk are kept") {
        const test::ScratchFolder folder;
        std::vector<Message> messages;
        std::mt19937_64 random(1);
        for (const std::size_t size : {0, 1, 5, 1000, 3 << 20, 17, 1 << 20, 2}) {
            schema::SlicesT slices;
            slices.slice_count = 1;
            slices.values.resize(size + 1);
            for (auto& value : slices.values) {
                value = static_cast<std::uint8_t>(random());
            }
            messages.push_back(received(pack(slices), 1, messages.size()));
        }
        write_example(folder / "a.mcap", messages);
        const TraceFile file(folder / "a.mcap");
        REQUIRE(file.entries().size() == messages.size());
        for (std::size_t i = 0; i < messages.size(); ++i) {
            CHECK(same_message(file.load(file.entries()[i]), messages[i]));
        }
    }

    TEST_CASE("a file that is cut anywhere gives the messages of its complete chunks") {
        const test::ScratchFolder folder;
        const auto path = folder / "a.mcap";
        std::vector<Message> messages = example_messages();
        write_example(path, messages);
        std::vector<std::uint64_t> chunks;  // Where each message's chunk begins.
        const std::vector<trace::Entry> entries = TraceFile(path).entries();
        for (const trace::Entry& entry : entries) {
            chunks.push_back(entry.chunk);
        }
        int before = static_cast<int>(messages.size());
        std::vector<std::size_t> places = places_in(read_all(path));
        while (!places.empty()) {
            const std::size_t size = places.back();
            places.pop_back();
            CAPTURE(size);
            std::filesystem::resize_file(path, size);
            const int count = readable(path, messages);
            REQUIRE(count <= before);  // Fewer bytes never give more messages.
            REQUIRE((count <= 0 || chunks[static_cast<std::size_t>(count) - 1] < size));
            // A complete chunk is readable.
            const auto next = static_cast<std::size_t>(std::max(count, 0));
            REQUIRE((next + 3 >= chunks.size() || chunks[next + 3] >= size));
            before = count;
        }
        CHECK(before == -1);
    }

    TEST_CASE("flushed messages are readable although the file was never closed") {
        const test::ScratchFolder folder;
        const std::vector<Message> messages = example_messages();
        TraceWriter writer(folder / "a.mcap", example_info());
        CHECK(TraceFile(folder / "a.mcap").entries().empty());
        writer.add(messages[0], 1);
        writer.add(messages[1], 2);
        writer.flush();
        writer.add(messages[2], 3);
        const TraceFile file(folder / "a.mcap");
        CHECK(file.entries().size() == 2);
        CHECK(file.cut() == fmt::format("at offset {} of {} bytes: the file ends here without an "
                                        "end record: it was not closed",
                                        writer.bytes(), writer.bytes()));
        CHECK(same_message(file.load(file.entries()[1]), messages[1]));
    }

    TEST_CASE("every flipped bit is detected, and none makes a message that was not written") {
        const test::ScratchFolder folder;
        const auto path = folder / "a.mcap";
        std::vector<Message> messages = example_messages();
        messages.erase(messages.begin() + 9, messages.end());
        write_example(path, messages);
        const Bytes whole = read_all(path);
        std::set<std::uint64_t> chunks;
        const std::vector<trace::Entry> entries = TraceFile(path).entries();
        for (const trace::Entry& entry : entries) {
            chunks.insert(entry.chunk);
        }
        const std::uint64_t seed = pxpl5::test::seed_or<std::uint64_t>(1);
        CAPTURE(seed);
        std::mt19937_64 random(seed);
        for (const std::size_t at : places_in(whole)) {
            CAPTURE(at);
            set_byte(path, at, static_cast<char>(whole[at] ^ (1 << random() % 8)));
            readable(path, messages);
            set_byte(path, at, whole[at]);
        }
        for (const std::uint64_t chunk : chunks) {  // A chunk must not pass for something else.
            for (int bit = 0; bit < 8; ++bit) {
                CAPTURE(chunk);
                CAPTURE(bit);
                set_byte(path, chunk, static_cast<char>(whole[chunk] ^ (1 << bit)));
                readable(path, messages);
                set_byte(path, chunk, whole[chunk]);
            }
        }
    }

    TEST_CASE("bytes that are damaged in many places are refused, not obeyed") {
        const test::ScratchFolder folder;
        const auto path = folder / "a.mcap", bad = folder / "bad.mcap";
        const std::vector<Message> messages = example_messages();
        write_example(path, messages);
        const Bytes whole = read_all(path);
        const std::uint64_t seed = pxpl5::test::seed_or<std::uint64_t>(1);
        CAPTURE(seed);
        std::mt19937_64 random(seed);
        for (int round = 0; round < 200; ++round) {
            CAPTURE(round);
            Bytes bytes = whole;
            for (std::uint64_t i = 0, n = 1 + random() % 20; i < n; ++i) {
                const std::size_t at = random() % bytes.size(), length = random() % 12;
                for (std::size_t k = at; k < std::min(at + length, bytes.size()); ++k) {
                    bytes[k] = static_cast<char>(round % 2 == 0 ? 0xff : random());
                }
            }
            if (bytes != whole) {
                write_all(bad, bytes);
                readable(bad, messages);
            }
        }
    }

    TEST_CASE("a file that is no trace of this program is refused by name") {
        const test::ScratchFolder folder;
        const auto path = folder / "a.mcap";
        const auto said = [&path] {
            try {
                const TraceFile file(path);
                return std::string("nothing");
            } catch (const TraceError& error) {
                return std::string(error.what()).substr(0, 400);
            }
        };
        CHECK(said() ==
              fmt::format("cannot read trace {}: No such file or directory", path.string()));
        write_all(path, {'P', '5', '\n'});
        CHECK(said() ==
              fmt::format("{} is no MCAP file: it does not begin like one", path.string()));
        trace::Info info = example_info();
        info.schema_hash = 0x1234;
        TraceWriter(path, info).close();
        CHECK(said() == fmt::format("{} is no trace of pxpl5: its messages have schema "
                                    "0000000000001234, this program's {:016x}; it was recorded by "
                                    "pxpl5 test",
                                    path.string(), schema_hash()));
    }

    TEST_CASE("a full disk is an error by name, and the written messages are readable") {
        const test::ScratchFolder folder;
        const std::vector<Message> messages = example_messages();
        CHECK_THROWS_WITH_AS(TraceWriter("/dev/full", example_info()),
                             "cannot write trace /dev/full at byte 0: No space left on device",
                             TraceError);
        std::signal(SIGXFSZ, SIG_IGN);
        TraceWriter writer(folder / "a.mcap", example_info());
        writer.add(messages[0], 1);
        writer.flush();
        rlimit before{};
        getrlimit(RLIMIT_FSIZE, &before);
        rlimit tight = before;
        tight.rlim_cur = writer.bytes() + 40;
        setrlimit(RLIMIT_FSIZE, &tight);
        writer.add(messages[1], 2);
        CHECK_THROWS_AS(writer.flush(), TraceError);
        setrlimit(RLIMIT_FSIZE, &before);
        const std::string text = fmt::format("cannot write trace {} at byte {}: File too large",
                                             (folder / "a.mcap").string(), writer.bytes());
        CHECK_THROWS_WITH_AS(writer.add(messages[2], 3), text.c_str(), TraceError);
        CHECK_THROWS_WITH_AS(writer.close(), text.c_str(), TraceError);
        CHECK(std::filesystem::file_size(folder / "a.mcap") == writer.bytes());
        CHECK(TraceFile(folder / "a.mcap").entries().size() == 1);
    }
}
