// A whole machine in one thread and one process: the real nodes on a simulated ring.
#pragma once

#include <poll.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gp_firmware/node/node.hpp"
#include "host/base/error.hpp"
#include "host/frame_buffer/node.hpp"
#include "host/io/archive_requests.hpp"
#include "host/machine/port.hpp"
#include "host/machine/roster.hpp"
#include "renderer_firmware/node.hpp"
#include "ringbus/simulated/simulated_link.hpp"
#include "tests/ringbus/wire_bytes.hpp"
#include "tests/system/troubled_node.hpp"

namespace pxpl5::test {

/// Behaves as host::Machine does for a session. The arrival order is drawn from the
/// topology's seed. Volumes come from phantoms: the io process reads archives only, off the ring.
class SimulatedMachine final : public host::MachinePort {
  public:
    /// tap  Sees every delivery, from the first Topology on.
    explicit SimulatedMachine(const host::Topology& topology, bus::SimulatedFault fault = {},
                              bus::SimulatedRing::Tap tap = {}, const Stall& stall = {})
        : ring_(topology.seed, fault), roster_(host::roster_of(topology)) {
        ring_.on_delivery(std::move(tap));
        for (host::RosterEntry& entry : roster_) {
            entry.endpoint = "simulated";
            if (entry.id == bus::host_id) {
                ring_.add(entry.id, mailbox_, entry.role);
            } else {
                const Stall own = nodes_.size() == stall.node ? stall : Stall{};
                nodes_.push_back(std::make_unique<TroubledNode>(make_node(entry.role), own));
                ring_.add(entry.id, *nodes_.back(), entry.role);
            }
        }
        const bus::Payload told = host::topology_message(roster_, topology);
        for (std::size_t i = 1; i < roster_.size(); ++i) {
            ring_.send(bus::host_id, roster_[i].id, told);
        }
        ring_.run_until_idle();  // All nodes connect before the first message.
        for (const bus::Message& message : mailbox_.messages) {
            if (const auto* refusal = message.as<bus::schema::Fault>()) {
                throw host::MachineError(70, "a node ended at its start: " +
                                                 refusal->reason()->str());  // As processes do.
            }
        }
        gps_ = ids_of(roster_, bus::schema::Role::gp);
        renderers_ = ids_of(roster_, bus::schema::Role::renderer);
        frame_buffers_ = ids_of(roster_, bus::schema::Role::frame_buffer);
    }

    const std::vector<bus::NodeId>& gp_ids() const override { return gps_; }
    const std::vector<bus::NodeId>& renderer_ids() const override { return renderers_; }
    const std::vector<bus::NodeId>& frame_buffer_ids() const override { return frame_buffers_; }

    std::vector<host::MachineNode> nodes() const override { return nodes_of(roster_); }
    bus::Traffic traffic() const override { return ring_.traffic(bus::host_id); }

    void send(bus::NodeId to, bus::Payload payload) override {
        if (to == io_id) {
            answer(payload);
        } else {
            ring_.send(bus::host_id, to, payload);
        }
    }

    bool takes_more(bus::NodeId) const override { return true; }

    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override {
        bool is_done = done();
        ask_watcher();  // Also if there is nothing to wait for, as a Machine does.
        while (!is_done) {
            if (!mailbox_.messages.empty()) {
                const bus::Message message = mailbox_.messages.front();
                mailbox_.messages.pop_front();
                take(message);
                is_done = done();
            } else {
                const bool has_stepped = ring_.step();
                is_done = done();
                if (!has_stepped && !is_done) {
                    throw host::MachineError(
                        1, "the ring is idle, and what is waited for has not come");
                }
            }
            if (!is_done) {
                ask_watcher();
            }
        }
    }

    void name_work(const std::string& work) override {
        if (on_work) {
            on_work(work);
        }
    }

    /// Its nodes cannot die by themselves: whoever reads may wait in read().
    void wait_readable(int) override {}

    void prepare_io() override {}
    bus::NodeId start_io(host::ExitCode) override { return io_id; }
    void release_io() override {}
    void allow_cancel(bool allowed) override { can_be_canceled_ = allowed; }
    void allow_give_up(bool allowed) override { may_give_up_ = allowed; }
    void watch(int fd, std::function<bool()> give_up) override {
        has_given_up_ = false;
        watched_fd_ = fd;
        give_up_ = std::move(give_up);
    }

    /// Tests that want to see messages tap the ring.
    bool is_recording() const override { return false; }
    host::SavedTraces save_traces() override {
        throw host::RequestError(host::ExitCode::usage, "a simulated machine writes no traces");
    }

    /// Called with the name of each work that the host waits for or pauses in.
    std::function<void(const std::string&)> on_work;
    /// The pictures that an io process would have written.
    std::vector<bus::schema::ExportPictureT> exported;

  private:
    /// The host's place on the ring.
    struct Mailbox final : bus::Node {
        void receive(const bus::Message& message, bus::Outbox&) override {
            messages.push_back(message);
        }
        bool work(bus::Outbox&) override { return false; }
        std::deque<bus::Message> messages;
    };

    static constexpr bus::NodeId io_id = 0xfffe;

    void ask_watcher() {
        pollfd watched{watched_fd_, POLLIN, 0};
        has_given_up_ |= watched_fd_ >= 0 && poll(&watched, 1, 0) > 0 && give_up_();
        if (has_given_up_ && (can_be_canceled_ || may_give_up_)) {
            has_given_up_ = false;
            throw host::Canceled();
        }
    }

    /// The io process: its messages are not on the ring, whose order they would change.
    void answer(const bus::Payload& request) {
        const auto* asked = bus::schema::GetMessage(request.bytes().data());
        if (const auto* picture = asked->body_as_ExportPicture()) {
            picture->UnPackTo(&exported.emplace_back());
            bus::schema::IoDoneT done;
            done.ok = true;
            mailbox_.messages.push_back(WireBytes(bus::pack(done)).read());
            return;
        }
        const auto* archive = asked->body_as_ReadArchive();
        if (archive == nullptr) {
            throw host::RequestError(host::ExitCode::unavailable,
                                     "the io process of a simulated machine reads archives only");
        }
        for (const bus::Payload& message : host::io::read_archive_file(*archive)) {
            mailbox_.messages.push_back(WireBytes(message).read());
        }
    }

    static std::unique_ptr<bus::Node> make_node(bus::schema::Role role) {
        switch (role) {
            case bus::schema::Role::gp:
                return std::make_unique<gp::GpNode>();
            case bus::schema::Role::renderer:
                return std::make_unique<renderer::RendererNode>();
            default:
                return std::make_unique<host::FrameBufferNode>();
        }
    }

    int watched_fd_ = -1;
    std::function<bool()> give_up_;
    bool can_be_canceled_ = false, may_give_up_ = false, has_given_up_ = false;
    Mailbox mailbox_;
    std::vector<std::unique_ptr<bus::Node>> nodes_;
    bus::SimulatedRing ring_;
    host::Roster roster_;
    std::vector<bus::NodeId> gps_, renderers_, frame_buffers_;
};

}  // namespace pxpl5::test
