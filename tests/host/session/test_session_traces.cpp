#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

/// A machine of one GP that answers everything with one fault.
class FaultyMachine final : public MachinePort {
  public:
    FaultyMachine(schema::FaultCode code, bool recording) : code_(code), recording_(recording) {}
    const std::vector<bus::NodeId>& gp_ids() const override { return ids_; }
    const std::vector<bus::NodeId>& renderer_ids() const override { return ids_; }
    const std::vector<bus::NodeId>& frame_buffer_ids() const override { return ids_; }
    void send(bus::NodeId, bus::Payload payload) override {
        const auto* end = schema::GetMessage(payload.bytes().data())->body_as_SceneEnd();
        scene_ = end == nullptr ? scene_ : end->scene();
    }
    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override {
        while (!done()) {
            if (scene_ != 0) {  // What takes the place of a volume that was given up is welcome.
                schema::VolumeReadyT ready;
                ready.volume = scene_;
                take(test::WireBytes(bus::pack(ready)).read());
                continue;
            }
            report(take, stale_frame, "surface 3 has no triangles");
            report(take, std::nullopt, reason);
        }
    }
    void wait_readable(int) override {}
    void prepare_io() override {}
    bus::NodeId start_io(ExitCode) override { return 9; }
    void release_io() override {}
    bool takes_more(pxpl5::bus::NodeId) const override { return true; }
    void allow_cancel(bool) override {}
    void watch(int, std::function<bool()>) override {}
    bool is_recording() const override { return recording_; }
    SavedTraces save_traces() override {
        ++saves;
        return {"/the/traces", 2, 10, 1000, missing};
    }

    std::vector<std::string> missing;
    int saves = 0;
    std::string reason = "as ordered";
    std::optional<std::uint32_t> stale_frame;  ///< Frame of a Fault that precedes each other Fault.

  private:
    void report(const std::function<void(const bus::Message&)>& take,
                std::optional<std::uint32_t> frame, const std::string& text) const {
        if (text == reason || frame) {
            schema::FaultT fault;
            fault.code = code_;
            fault.node = ids_[0];
            fault.frame = frame;
            fault.reason = text;
            take(test::WireBytes(bus::pack(fault)).read());
        }
    }

    schema::FaultCode code_;
    bool recording_;
    std::uint32_t scene_ = 0;             ///< The last one that was sent whole.
    std::vector<bus::NodeId> ids_ = {3};  // As in WireBytes.
};

std::string error_of(FaultyMachine& machine) {
    Session session(machine);
    try {
        session.volumes.load("phantom:letters");
    } catch (const RequestError& error) {
        return error.what();
    }
    return "no error";
}

}  // namespace

TEST_SUITE("host/session_traces") {
    TEST_CASE("a fault that is not the user's has the traces saved, and its text says where") {
        for (const auto code : {schema::FaultCode::internal, schema::FaultCode::lost_message,
                                schema::FaultCode::bad_message}) {
            FaultyMachine machine(code, true);
            CHECK(error_of(machine) ==
                  "phantom:letters: as ordered; traces of 2 nodes: /the/traces");
            CHECK(machine.saves == 1);
        }
    }

    TEST_CASE("a fault of the user's input is told without them, and so is one unrecorded") {
        FaultyMachine full(schema::FaultCode::out_of_memory, true),
            unrecorded(schema::FaultCode::internal, false);
        CHECK(error_of(full) == "phantom:letters: as ordered");
        CHECK(error_of(unrecorded) == "phantom:letters: as ordered");
        CHECK(full.saves + unrecorded.saves == 0);
    }

    TEST_CASE("a fault is a frame's if it says so in its field, whatever its text says") {
        FaultyMachine other_frame(schema::FaultCode::bad_input, false);
        other_frame.stale_frame = 7;
        CHECK(error_of(other_frame) == "phantom:letters: as ordered");
        FaultyMachine no_frame(schema::FaultCode::bad_input, false);
        no_frame.reason = "frame 7: the sum of a picture";
        CHECK(error_of(no_frame) == "phantom:letters: frame 7: the sum of a picture");
    }

    TEST_CASE("a node that cannot write its trace is named with the reason") {
        FaultyMachine machine(schema::FaultCode::internal, true);
        Session session(machine);
        CHECK(session.nodes.save_traces().messages == 10);
        machine.missing = {"gp-3: no space"};
        CHECK_THROWS_WITH_AS(session.nodes.save_traces(),
                             "1 of 3 nodes have written no trace: gp-3: no space", RequestError);
    }
}
