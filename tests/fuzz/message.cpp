// Ring messages: a message that is accepted has only values in their documented ranges, and
// decodes and encodes to the same bytes.
#include "ringbus/message.hpp"

#include <memory>
#include <vector>

#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/message_ranges.hpp"
#include "tests/ringbus/examples/examples.hpp"

namespace pxpl5::fuzz {

namespace {

using bus::schema::Header;

/// The message of these bytes, as received. Throws BadMessage.
bus::Message received(const Header& header, std::span<const std::uint8_t> bytes) {
    const auto words = std::make_shared<std::vector<std::uint64_t>>(bytes.size() / 8 + 1);
    auto* body = reinterpret_cast<std::uint8_t*>(words->data());
    std::ranges::copy(bytes, body);
    return {header, {body, bytes.size()}, words};
}

Header header_of(std::uint16_t kind, std::size_t body_bytes) {
    return {bus::header_magic, bus::protocol_version, kind, 3, 5, 0, 0, 7, body_bytes, 0, 0, 1};
}

void check_header(const Header& header, std::size_t body_bytes) {
    require(header.magic() == bus::header_magic, "magic of an accepted header");
    require(header.version() == bus::protocol_version, "version of an accepted header");
    require(header.body_bytes() == body_bytes, "body size of an accepted header");
    require(header.reserved() == 0, "reserved field of an accepted header");
    require(header.departure_ns() <= header.arrival_ns(), "times of an accepted header");
}

/// Decoding an encoded message gives the message: encoding it again gives the same bytes.
void check_round_trip(const bus::Message& message) {
    const bus::Payload once = test::repacked(message);
    require(once.kind() == message.kind(), "the kind of a message that was encoded again");
    const bus::Message again = received(
        header_of(static_cast<std::uint16_t>(once.kind()), once.bytes().size()), once.bytes());
    const bus::Payload twice = test::repacked(again);
    require(std::ranges::equal(once.bytes(), twice.bytes()),
            bus::kind_name(message.kind()) + " changes when it is encoded again");
}

/// The example of this number after the edits of an input, behind the byte of its kind.
std::vector<std::uint8_t> edited_example(std::size_t number, Bytes bytes) {
    static const std::vector<bus::Payload> examples = test::one_of_each_kind();
    const bus::Payload& example = examples.at(number % examples.size());
    constexpr std::size_t most_bytes = 8192;
    const auto body = example.bytes().first(std::min(example.bytes().size(), most_bytes));
    std::vector<std::uint8_t> all = edited({body.begin(), body.end()}, bytes);
    all.insert(all.begin(), static_cast<std::uint8_t>(example.kind()));
    return all;
}

}  // namespace

/// Input: a kind and the body; kind 0 stands for a header before the body, and kinds from 128 on
/// for edits of an example.
bool accepts(Input input) {
    Bytes bytes(input);
    const auto kind = bytes.take<std::uint8_t>();
    constexpr std::uint8_t first_edit = 128;
    if (kind >= first_edit) {
        return accepts(edited_example(kind - first_edit, bytes));
    }
    const Header header = kind == 0 ? bytes.take<Header>() : header_of(kind, bytes.rest().size());
    try {
        const bus::Message message = received(header, bytes.rest());
        check_header(message.header(), bytes.rest().size());
        require_documented_ranges(message);
        require(bus::frame_of(message).has_value() == bus::is_of_frame(message.kind()),
                "the frame of " + bus::kind_name(message.kind()));
        check_round_trip(message);
        return true;
    } catch (const bus::BadMessage& bad) {
        require(std::string(bad.what()).find("node") != std::string::npos,
                "the refusal names no sender: " + std::string(bad.what()));
        return false;
    }
}

}  // namespace pxpl5::fuzz
