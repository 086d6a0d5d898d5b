// A simulated machine that dies on order, and starts again.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/simulated_machine.hpp"

namespace pxpl5::test {

using namespace host;

/// The error of a machine whose GP has died.
inline MachineError killed() {
    return {137, "gp-1 was killed by signal 9 (SIGKILL)"};
}

/// Disturbances of a machine from its start on.
struct Disturbance {
    bus::SimulatedFault ring;
    Stall stall;
};

/// A machine that dies when the test says so.
class MortalMachine final : public MachinePort {
  public:
    /// during  Called once, at the first message of a pump.
    /// fate    Asked before each step of a pump. Its error, if any, ends the machine.
    /// launch  Called before each start. Returns the disturbances. Throws if the machine
    ///         cannot be started.
    MortalMachine(const Topology& topology, int& extractions,
                  std::function<std::optional<MachineError>()> fate, std::function<void()>& during,
                  std::function<Disturbance()> launch)
        : topology_(topology),
          extractions_(extractions),
          fate_(std::move(fate)),
          during_(during),
          launch_(std::move(launch)) {
        start_again({});
    }

    RestartSettings restart_of(const std::string&) const override { return topology_.gp.restart; }
    void start_again(const NodeChange& change, int = 0) override {
        Topology plan = with_nodes(topology_, change.gps, change.renderers);
        const Disturbance disturbance = launch_();
        inside_.emplace(plan, disturbance.ring, bus::SimulatedRing::Tap{}, disturbance.stall);
        topology_ = std::move(plan);
        inside_->watch(watched_fd_, give_up_);
    }
    std::vector<MachineNode> nodes() const override { return inside_->nodes(); }

    const std::vector<bus::NodeId>& gp_ids() const override { return inside_->gp_ids(); }
    const std::vector<bus::NodeId>& renderer_ids() const override {
        return inside_->renderer_ids();
    }
    const std::vector<bus::NodeId>& frame_buffer_ids() const override {
        return inside_->frame_buffer_ids();
    }
    void send(bus::NodeId to, bus::Payload payload) override {
        inside_->send(to, std::move(payload));
    }
    bool takes_more(bus::NodeId to) const override { return inside_->takes_more(to); }
    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override {
        const auto count = [&](const bus::Message& message) {
            extractions_ +=
                message.kind() == bus::Body::SurfaceBuilt && message.source() == gp_ids().front()
                    ? 1
                    : 0;
            if (during_) {
                std::exchange(during_, {})();
            }
            take(message);
        };
        inside_->pump(count, [&] {
            if (std::exchange(is_killed_, false)) {
                throw killed();
            }
            if (const std::optional<MachineError> end = fate_()) {
                throw *end;
            }
            return done();
        });
    }
    void wait_readable(int fd) override { inside_->wait_readable(fd); }
    void prepare_io() override {}
    bus::NodeId start_io(ExitCode code) override { return inside_->start_io(code); }
    void release_io() override {}
    void allow_cancel(bool allowed) override { inside_->allow_cancel(allowed); }
    void allow_give_up(bool allowed) override { inside_->allow_give_up(allowed); }
    void kill(bus::NodeId) override { is_killed_ = true; }
    void watch(int fd, std::function<bool()> give_up) override {
        watched_fd_ = fd;
        give_up_ = std::move(give_up);
        inside_->watch(fd, give_up_);
    }
    void tell_suspects(std::function<void(const std::string&)> tell) override {
        tell_suspect = std::move(tell);
    }
    void tell_computers(std::function<void(const std::string&)> tell) override {
        tell_computer = std::move(tell);
    }
    bool is_recording() const override { return false; }
    SavedTraces save_traces() override { return inside_->save_traces(); }

    std::function<void(const std::string&)> tell_suspect;   ///< From tell_suspects().
    std::function<void(const std::string&)> tell_computer;  ///< From tell_computers().

  private:
    Topology topology_;
    std::optional<SimulatedMachine> inside_;
    int& extractions_;
    std::function<std::optional<MachineError>()> fate_;
    bool is_killed_ = false;
    std::function<void()>& during_;
    std::function<Disturbance()> launch_;
    int watched_fd_ = -1;
    std::function<bool()> give_up_;
};

}  // namespace pxpl5::test
