// Troubles of one simulated node: it stalls, or an allocation fails.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

#include "ringbus/node.hpp"

namespace pxpl5::test {

/// Counts the allocations of nodes, and lets one of them fail. The program's operator new asks
/// about each allocation.
class FailingAllocation {
  public:
    static constexpr std::uint64_t never = ~std::uint64_t{0};

    /// Begins to count. Allocation number `failing` (0 is the first) throws std::bad_alloc.
    static void count_from_zero(std::uint64_t failing = never) {
        counted_ = 0;
        failing_ = failing;
    }
    static std::uint64_t counted() { return counted_; }
    /// Returns true if this allocation fails.
    static bool fails() { return counts_ && counted_++ == failing_; }

    /// Allocations count while it lives, or do not count.
    class Scope {
      public:
        explicit Scope(bool counts) : before_(std::exchange(counts_, counts)) {}
        ~Scope() { counts_ = before_; }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

      private:
        bool before_;
    };

  private:
    inline static bool counts_ = false;
    inline static std::uint64_t counted_ = 0, failing_ = never;
};

/// A stall of one node.
struct Stall {
    std::size_t node = 0;  ///< Place of the node among all but the host.
    std::uint64_t at = 0;  ///< Messages that it receives before it stalls.
    int steps = 0;         ///< Steps that the stall lasts; 0: it does not stall.
};

/// A node that stalls once. Its messages wait, and it answers them afterwards.
class TroubledNode final : public bus::Node {
  public:
    TroubledNode(std::unique_ptr<bus::Node> inside, const Stall& stall)
        : inside_(std::move(inside)), stall_(stall) {}

    void receive(const bus::Message& message, bus::Outbox& out) override {
        const bool stalls = stall_.steps > 0 && received_++ >= stall_.at;
        if (stalls || !waiting_.empty()) {
            waiting_.push_back(message);  // Messages stay in order.
            return;
        }
        Quiet quiet(out);
        const FailingAllocation::Scope scope(true);
        inside_->receive(message, quiet);
    }
    bool work(bus::Outbox& out) override {
        if (!waiting_.empty() && --stall_.steps > 0) {
            return true;
        }
        Quiet quiet(out);
        const FailingAllocation::Scope scope(true);
        if (!waiting_.empty()) {
            const bus::Message message = waiting_.front();
            waiting_.pop_front();
            inside_->receive(message, quiet);
            return true;
        }
        return inside_->work(quiet);
    }
    bus::NodeStatus status() const override { return inside_->status(); }
    bus::Doing doing() override { return inside_->doing(); }

  private:
    /// The ring's own allocations do not count: a message is sent whole.
    class Quiet final : public bus::Outbox {
      public:
        using Outbox::send;
        explicit Quiet(bus::Outbox& out) : out_(out) {}
        void send(bus::NodeId to, bus::Payload payload) override {
            const FailingAllocation::Scope scope(false);
            out_.send(to, std::move(payload));
        }
        flatbuffers::Allocator* body_allocator() override { return out_.body_allocator(); }
        bus::StageClock* clock() override { return out_.clock(); }

      private:
        bus::Outbox& out_;
    };

    std::unique_ptr<bus::Node> inside_;
    Stall stall_;
    std::uint64_t received_ = 0;
    std::deque<bus::Message> waiting_;
};

}  // namespace pxpl5::test
