#include "ringbus/node_loop.hpp"

#include <doctest/doctest.h>
#include <unistd.h>

#include <deque>
#include <functional>
#include <new>
#include <variant>

#include "ringbus/pulse.hpp"
#include "ringbus/wire.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using pxpl5::test::WireBytes;

namespace {

Payload numbered(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

Payload shutdown() {
    return pack(schema::ShutdownT{});
}

/// A link with scripted input: messages, quiet moments, and refused messages.
class ScriptedLink final : public Link {
  public:
    struct Lost {};
    struct Bad {};
    struct Quiet {};  ///< Nothing is here until the node waits.
    using Event = std::variant<Payload, Lost, Bad, Quiet>;

    explicit ScriptedLink(std::deque<Event> events) : events_(std::move(events)) {}

    NodeId id() const override { return 5; }
    const std::string& endpoint() const override { return endpoint_; }
    void add_peer(NodeId, schema::Role, const std::string&) override {}
    void remove_peer(NodeId) override {}
    void send(NodeId to, Payload payload) override {
        REQUIRE(to == host_id);
        sent.push_back(WireBytes(payload).read());
    }

    std::size_t queued() const override { return waits < held_up_waits ? 1 : 0; }
    std::optional<Message> receive() override {
        if (events_.empty() || std::holds_alternative<Quiet>(events_.front())) {
            return std::nullopt;
        }
        const Event event = std::move(events_.front());
        events_.pop_front();
        const schema::Header header = WireBytes(numbered(0)).header;  // From node 3, number 7.
        if (std::holds_alternative<Lost>(event)) {
            throw WireFault(header, schema::FaultCode::lost_message, "6 is missing");
        }
        if (std::holds_alternative<Bad>(event)) {
            throw BadMessage(header, "no good");
        }
        return WireBytes(std::get<Payload>(event)).read();
    }

    bool wait(int) override {
        ++waits;
        if (at_wait) {
            at_wait();
        }
        if (!events_.empty()) {
            events_.pop_front();
        }
        return !events_.empty();
    }

    std::vector<Message> sent;
    int waits = 0;
    int held_up_waits = 0;  ///< Number of waits without credit.
    std::function<void()> at_wait;

  private:
    std::deque<Event> events_;
    std::string endpoint_ = "scripted";
};

/// Each message makes one piece of work. Logs the order of events.
struct Diary final : Node {
    std::string text;
    int pieces = 0;

    void receive(const Message& message, Outbox&) override {
        text += 'r';
        if (message.kind() == Body::RegionPrograms) {
            throw NodeFault(schema::FaultCode::bad_input, "no sum for the picture");
        }
        const std::uint16_t number = message.as<schema::RemoveSurface>()->surface();
        if (number == 66) {
            throw NodeFault(schema::FaultCode::bad_input, "sixty-six");
        }
        if (number == 67) {
            throw std::bad_alloc();
        }
        if (number == 68) {
            throw NodeFault(schema::FaultCode::internal, "sixty-eight", {Body::SetSurface, 9});
        }
        ++pieces;
    }
    bool work(Outbox&) override {
        if (pieces == 0) {
            return false;
        }
        text += 'w';
        if (--pieces == 41) {
            throw NodeFault(schema::FaultCode::internal, "in the middle of work",
                            {Body::BeginFrame, 41});
        }
        return pieces > 0;
    }
    NodeStatus status() const override { return {0, static_cast<std::size_t>(pieces), 0}; }
    Doing doing() override { return current; }
    Doing current;
};

const auto always = [] { return true; };

const schema::Fault& fault(const ScriptedLink& link, std::size_t index) {
    REQUIRE(index < link.sent.size());
    REQUIRE(link.sent[index].kind() == Body::Fault);
    return *link.sent[index].as<schema::Fault>();
}

/// Number of times that a stage began.
std::uint64_t count_of(const schema::Activity& activity, std::string_view name) {
    for (const schema::StageTime* stage : *activity.stages()) {
        if (stage->name()->string_view() == name) {
            return stage->count();
        }
    }
    return 0;
}

}  // namespace

TEST_SUITE("ringbus/node_loop") {
    using Lost = ScriptedLink::Lost;
    using Bad = ScriptedLink::Bad;
    using Quiet = ScriptedLink::Quiet;

    TEST_CASE("all waiting messages are read before the next piece of work") {
        ScriptedLink link(
            {numbered(1), numbered(2), numbered(3), Quiet{}, numbered(4), Quiet{}, shutdown()});
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == "rrrwwwrw");
        CHECK(link.waits == 2);
        CHECK(link.sent.empty());
    }

    TEST_CASE("a node reads on, but does not work, while its messages are queued for credit") {
        ScriptedLink link({numbered(1), Quiet{}, numbered(2), Quiet{}, shutdown()});
        link.held_up_waits = 1;
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == "rrww");
    }

    TEST_CASE("a question about its activity is answered for the node, between its pieces") {
        ScriptedLink link({numbered(1), numbered(2), pack(schema::AskActivityT{}), Quiet{},
                           pack(schema::AskActivityT{}), Quiet{}, shutdown()});
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == "rrww");  // It did not see them.
        REQUIRE(link.sent.size() == 2);
        const auto* before = link.sent[0].as<schema::Activity>();
        const auto* after = link.sent[1].as<schema::Activity>();
        REQUIRE(before != nullptr);
        REQUIRE(after != nullptr);
        CHECK(before->queue() == 2);
        CHECK(after->queue() == 0);
        CHECK(count_of(*before, stage::work) == 0);
        CHECK(count_of(*after, stage::work) == 2);
        CHECK(count_of(*after, stage::send) == 1);
        CHECK(after->wall_ns() > before->wall_ns());
    }

    TEST_CASE("messages after Shutdown are ignored") {
        ScriptedLink link({shutdown(), numbered(1)});
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text.empty());
    }

    TEST_CASE("a node whose parent is gone ends after a quiet moment") {
        ScriptedLink link({numbered(1), Quiet{}});
        Diary node;
        CHECK(!run_node(node, link, [] { return false; }));
        CHECK(node.text == "rw");
    }

    TEST_CASE("a message that the link refuses becomes a Fault with its sender") {
        ScriptedLink link({Lost{}, Bad{}, numbered(1), shutdown()});
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == "r");
        REQUIRE(link.sent.size() == 2);
        const schema::FaultCode codes[] = {schema::FaultCode::lost_message,
                                           schema::FaultCode::bad_message};
        const char* const reasons[] = {"6 is missing", "no good"};
        for (std::size_t i = 0; i < 2; ++i) {
            CHECK(fault(link, i).code() == codes[i]);
            CHECK(fault(link, i).reason()->str() == reasons[i]);
            CHECK(fault(link, i).node() == 5);
            CHECK(fault(link, i).source() == 3);
            CHECK(fault(link, i).sequence() == 7);
        }
    }

    TEST_CASE("an exception of the node becomes a Fault, and the node continues") {
        ScriptedLink link({numbered(66), numbered(67), numbered(1), Quiet{}, shutdown()});
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == "rrrw");
        REQUIRE(link.sent.size() == 2);
        CHECK(fault(link, 0).code() == schema::FaultCode::bad_input);
        CHECK(fault(link, 0).reason()->str() == "sixty-six");
        CHECK(fault(link, 0).source() == 3);
        CHECK(fault(link, 1).code() == schema::FaultCode::out_of_memory);
    }

    TEST_CASE("a fault names the request and the frame at fault, whatever its text says") {
        schema::RegionProgramsT programs;
        programs.frame = 12;
        ScriptedLink link({pack(programs), numbered(66), numbered(68), Bad{}, Quiet{}, shutdown()});
        Diary node;
        CHECK(run_node(node, link, always));
        REQUIRE(link.sent.size() == 4);
        const auto request = [&](std::size_t index) {
            return static_cast<Body>(fault(link, index).request());
        };
        CHECK(fault(link, 0).reason()->str() == "no sum for the picture");
        CHECK(fault(link, 0).frame() == 12);
        CHECK(request(0) == Body::RegionPrograms);
        CHECK_FALSE(fault(link, 1).frame().has_value());
        CHECK(request(1) == Body::RemoveSurface);
        CHECK(fault(link, 2).frame() == 9);  // A cause that the node names takes precedence.
        CHECK(request(2) == Body::SetSurface);
        CHECK_FALSE(fault(link, 3).frame().has_value());
        CHECK(request(3) == Body::RemoveSurface);
    }

    TEST_CASE("the pulse of a node that waits within its work shows the work") {
        PulseCell cell;
        Pulse pulse(dup(cell.fd()), 1000);
        ScriptedLink link({numbered(1), Quiet{}, shutdown()});
        Diary node;
        node.current = {Body::Slices, 3, 4, 90};
        PulseReading seen;
        link.at_wait = [&] { seen = cell.read(); };
        CHECK(run_node(node, link, always, pulse));
        CHECK(seen.phase == Phase::waiting);
        CHECK(seen.doing.kind == Body::Slices);
        CHECK(seen.doing.done == 4);
    }

    TEST_CASE("a fault in one piece of work does not stop the others") {
        std::deque<ScriptedLink::Event> events(42, numbered(1));
        events.push_back(Quiet{});
        events.push_back(shutdown());
        ScriptedLink link(events);
        Diary node;
        CHECK(run_node(node, link, always));
        CHECK(node.text == std::string(42, 'r') + std::string(42, 'w'));
        REQUIRE(link.sent.size() == 1);
        CHECK(fault(link, 0).reason()->str() == "in the middle of work");
        CHECK(fault(link, 0).source() == 5);
        CHECK(fault(link, 0).request() == static_cast<std::uint16_t>(Body::BeginFrame));
        CHECK(fault(link, 0).frame() == 41);
    }
}
