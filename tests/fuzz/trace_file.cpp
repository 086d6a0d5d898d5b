// Trace files: whatever the bytes, the messages that are read are valid, and the end of a damaged
// file is reported with its place.
#include "ringbus/trace/trace_file.hpp"

#include "ringbus/trace/mcap_reader.hpp"
#include "ringbus/trace/trace_info.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/message_ranges.hpp"
#include "tests/fuzz/scratch.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/trace/recorder_support.hpp"

namespace pxpl5::fuzz {

namespace {

namespace trace = bus::trace;
namespace mcap = trace::mcap;

constexpr std::size_t most_bytes = 4096;  ///< Larger examples would only make edits miss.

struct Bases {
    mcap::Bytes written;  ///< The writer's own bytes.
    mcap::Bytes plain;    ///< Neither compressed nor with checksums, so that edits reach records.
    std::size_t messages = 0;
};

mcap::Bytes bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

mcap::Bytes plain_file(const mcap::Bytes& records) {
    mcap::Bytes file(mcap::magic.begin(), mcap::magic.end());
    mcap::Out out(file);
    out.record(mcap::Op::header, [&] { out.text("").text("test"); });
    out.record(mcap::Op::metadata, [&] {
        out.text(trace::metadata_name).texts(trace::to_metadata(test::info_for(Recording::full)));
    });
    out.record(mcap::Op::chunk, [&] {
        out.number(std::uint64_t{0}).number(std::uint64_t{0});
        out.number(std::uint64_t{records.size()}).number(std::uint32_t{0}).text("");
        out.number(std::uint64_t{records.size()}).raw(records);
    });
    out.record(mcap::Op::data_end, [&] { out.number(std::uint32_t{0}); });
    return file;
}

Bases make_bases(const Scratch& scratch) {
    Bases bases;
    const std::string path = scratch.at("base.mcap");
    trace::TraceWriter writer(path, test::info_for(Recording::full));
    for (const bus::Payload& payload : test::one_of_each_kind()) {
        if (payload.bytes().size() < most_bytes) {
            writer.add(test::from(1, payload), ++bases.messages);
        }
    }
    writer.close();
    bases.written = bytes_of(path);
    const trace::TraceFile file(path);
    require(file.cut().empty(), "a trace as it was written");
    const mcap::Bytes records = mcap::Reader(path).chunk(file.entries().front().chunk);
    bases.plain = plain_file(records);
    return bases;
}

/// Returns the number of valid messages.
std::size_t check_messages(const trace::TraceFile& file) {
    std::size_t valid = 0;
    for (const trace::Entry& entry : file.entries()) {
        try {
            const bus::Message message = file.load(entry);
            require(std::memcmp(&message.header(), &entry.header, sizeof entry.header) == 0,
                    "the header of an entry and of its message");
            require_documented_ranges(message);
            ++valid;
        } catch (const bus::BadMessage&) {
        } catch (const trace::TraceError& error) {
            require(std::string(error.what()).find("at offset") != std::string::npos, error.what());
        }
    }
    return valid;
}

}  // namespace

/// Input: a letter, then edits of a trace: 'w' as written, 'p' plain; else a whole file.
bool accepts(Input input) {
    static const Scratch scratch;
    static const Bases bases = make_bases(scratch);
    Bytes bytes(input);
    const char kind = bytes.take<char>();
    const bool is_whole = bytes.empty() && (kind == 'w' || kind == 'p');
    mcap::Bytes content = kind == 'w'   ? edited(bases.written, bytes)
                          : kind == 'p' ? edited(bases.plain, bytes)
                                        : mcap::Bytes(input.begin(), input.end());
    const std::string path =
        scratch.write("a.mcap", {reinterpret_cast<const char*>(content.data()), content.size()});
    try {
        const trace::TraceFile file(path);
        const std::size_t valid = check_messages(file);
        require(!is_whole || valid == bases.messages, "messages of a whole trace are missing");
        require(file.cut().empty() || file.cut().starts_with("at offset "), file.cut());
        return valid > 0;
    } catch (const trace::TraceError& error) {
        require(std::string(error.what()).find(path) != std::string::npos, error.what());
        require(!is_whole, error.what());
        return false;
    }
}

}  // namespace pxpl5::fuzz
