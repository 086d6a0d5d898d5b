#include <doctest/doctest.h>

#include <deque>
#include <optional>

#include "ringbus/trace/recorder.hpp"
#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/trace/recorder_support.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using namespace pxpl5::test;
using trace::Recorder;
using trace::TraceFile;

namespace {

/// Returns scripted messages; an empty entry is a quiet moment. Keeps sent messages.
class QueueLink final : public Link {
  public:
    NodeId id() const override { return 5; }
    const std::string& endpoint() const override { return endpoint_; }
    void add_peer(NodeId, schema::Role, const std::string&) override {}
    void remove_peer(NodeId) override {}
    void send(NodeId to, Payload payload) override {
        receivers.push_back(to);
        sent.push_back(WireBytes(payload).read());
    }
    std::size_t queued() const override { return 0; }
    std::optional<Message> receive() override {
        if (input.empty() || !input.front()) {
            return std::nullopt;
        }
        const Message message = *input.front();
        input.pop_front();
        return message;
    }
    bool wait(int timeout_ms) override {
        waits_ms.push_back(timeout_ms);
        if (!input.empty() && !input.front()) {
            input.pop_front();
        }
        return !input.empty();
    }

    std::deque<std::optional<Message>> input;
    std::vector<Message> sent;
    std::vector<NodeId> receivers;
    std::vector<int> waits_ms;

  private:
    std::string endpoint_ = "queue";
};

}  // namespace

TEST_SUITE("ringbus/recording_link") {
    TEST_CASE("a question about the node's activity is delivered and not recorded") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        QueueLink queue;
        queue.input = {from(0, topology_with(2)), from(0, pack(schema::AskActivityT{})),
                       from(1, surface(7, 1))};
        trace::RecordingLink link(queue, recorder);
        CHECK(link.receive()->kind() == Body::Topology);
        CHECK(link.receive()->kind() == Body::AskActivity);
        CHECK(link.receive()->kind() == Body::SetSurface);
        CHECK(recorder.save().messages == 2);
    }

    TEST_CASE("delivered messages are recorded, and SaveTrace is answered and not delivered") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        QueueLink queue;
        queue.input = {from(0, topology_with(2)), from(0, pack(schema::SaveTraceT{})),
                       from(1, surface(7, 1))};
        trace::RecordingLink link(queue, recorder);
        CHECK(link.id() == 5);
        CHECK(link.receive()->kind() == Body::Topology);
        const std::optional<Message> next = link.receive();
        REQUIRE(next);
        CHECK(next->as<schema::SetSurface>()->surface() == 7);
        CHECK(!link.receive());
        REQUIRE(queue.sent.size() == 1);
        CHECK(queue.receivers[0] == host_id);
        const auto* saved = queue.sent[0].as<schema::TraceSaved>();
        REQUIRE(saved != nullptr);
        CHECK(saved->messages() == 1);
        CHECK(saved->bytes() == std::filesystem::file_size(folder / "a.mcap"));
        CHECK(saved->error() == nullptr);
        CHECK(kinds_in(folder / "a.mcap") == "Topology");
    }

    TEST_CASE("messages that the trace omits are still delivered") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::flight));
        QueueLink queue;
        queue.input = {from(0, surface(1, 1)), from(0, topology_with(2)), from(0, surface(2, 1))};
        trace::RecordingLink link(queue, recorder, [](const Message& message) {
            return message.kind() == Body::Topology;
        });
        int handed_on = 0;
        while (link.receive()) {
            ++handed_on;
        }
        CHECK(handed_on == 3);
        recorder.save();
        CHECK(kinds_in(folder / "a.mcap") == "SetSurface SetSurface");
    }

    TEST_CASE("a link that waits in vain writes the pending messages") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::full));
        QueueLink queue;
        queue.input = {from(0, surface(1, 1))};
        trace::RecordingLink link(queue, recorder);
        CHECK(link.receive());
        CHECK(!link.wait(1000));
        CHECK(TraceFile(folder / "a.mcap").entries().size() == 1);
        CHECK(queue.waits_ms.size() == 2);
        CHECK(queue.waits_ms[0] + queue.waits_ms[1] == 1000);
        CHECK(!link.wait(1000));
        CHECK(queue.waits_ms.back() == 1000);  // Nothing waits any more.
    }

    TEST_CASE("the host receives one Fault when recording fails, and messages still arrive") {
        const test::ScratchFolder folder;
        Recorder recorder(folder / "a.mcap", info_for(Recording::full));
        QueueLink queue;
        queue.input = {from(0, surface(1, 1)), std::nullopt};
        trace::RecordingLink link(queue, recorder);
        const FileSizeLimit limit(10);
        CHECK(link.receive());
        CHECK(!link.receive());
        CHECK(!link.wait(1000));
        REQUIRE(queue.sent.size() == 1);
        const auto* fault = queue.sent[0].as<schema::Fault>();
        REQUIRE(fault != nullptr);
        CHECK(fault->node() == 5);
        CHECK(fault->reason()->str().starts_with("recording stops: cannot write trace "));
        queue.input = {from(0, surface(2, 1)), from(0, pack(schema::SaveTraceT{}))};
        CHECK(link.receive()->as<schema::SetSurface>()->surface() == 2);
        CHECK(!link.receive());
        REQUIRE(queue.sent.size() == 2);
        CHECK(queue.sent[1].as<schema::TraceSaved>()->error()->str().find("File too large") !=
              std::string::npos);
    }
}
