// One conversation with a machine: sends requests, hands messages on, reports faults.
//
//   part --broadcast, ask--> Conversation --> GPs
//   part <--handle()-------- Conversation <-- GPs, Renderers, frame buffer, io process
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/port.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// The parts of a session share one conversation. One request to all GPs is under way at a time.
class Conversation {
  public:
    using Handler = std::function<void(const bus::Message&)>;
    /// Takes a GP's message. Returns whether the message answers the request under way.
    using Answer = std::function<bool(const bus::Message&)>;

    explicit Conversation(MachinePort& machine) : machine_(machine) {}
    Conversation(const Conversation&) = delete;
    Conversation& operator=(const Conversation&) = delete;

    MachinePort& machine() const { return machine_; }
    const std::vector<bus::NodeId>& gps() const { return machine_.gp_ids(); }
    std::size_t renderer_count() const { return machine_.renderer_ids().size(); }

    /// Hands every message of this kind to `handler`.
    void handle(bus::Body kind, Handler handler);
    /// Hands faults of frames to `takes_fault`, which returns whether wait() throws the fault.
    void handle_frame_faults(std::function<bool(std::uint32_t frame)> takes_fault);

    /// Sends a request to every GP.
    void broadcast(const bus::Payload& request);
    /// Number of broadcasts that may change a frame: all but questions about voxels.
    std::uint64_t broadcasts() const { return broadcasts_; }
    /// The same without new surfaces, whose revisions frames name.
    std::uint64_t other_changes() const { return other_changes_; }

    /// Sends `request` to every GP and waits until each has answered.
    void ask(const std::string& what, const bus::Payload& request, Answer answer);
    /// The same, and a viewer may cancel the wait. A GP answers with one message; those that come
    /// later than the cancellation are dropped.
    ///
    /// answers  Whether a message answers the request. It must not refer to variables of the
    ///          caller, because it is used after a cancellation.
    /// take     Takes an answer.
    void ask_cancelable(const std::string& what, const bus::Payload& request, const Answer& answers,
                        const Handler& take);
    /// Begins a request that the caller sends. forget() must follow before `answer` dangles.
    void expect(Answer answer);
    /// True if every GP has answered the request or refused it with a Fault.
    bool is_answered() const;
    void wait_for_answers(const std::string& what);
    void forget() { answer_ = nullptr; }

    /// Forgets the request under way and its faults: the machine has been started again.
    void begin_again();

    /// Pumps messages until `done`. Then throws RequestError for the first fault since the last
    /// wait, if any.
    void wait(const std::string& what, const std::function<bool()>& done);
    /// Handles the messages that have arrived, without waiting for others. Throws RequestError for
    /// a fault, so that the next request is not blamed for it.
    void take_arrived();
    /// While it exists, a viewer may cancel wait(). The parts then drop late answers.
    class Cancelable {
      public:
        explicit Cancelable(Conversation& conversation) : machine_(conversation.machine()) {
            machine_.allow_give_up(!conversation.is_uncancelable_);
        }
        ~Cancelable() { machine_.allow_give_up(false); }
        Cancelable(const Cancelable&) = delete;
        Cancelable& operator=(const Cancelable&) = delete;

      private:
        MachinePort& machine_;
    };
    /// While it exists, Cancelable allows nothing: what is restored must be whole.
    class Uncancelable {
      public:
        explicit Uncancelable(Conversation& conversation)
            : conversation_(conversation),
              before_(std::exchange(conversation.is_uncancelable_, true)) {}
        ~Uncancelable() { conversation_.is_uncancelable_ = before_; }
        Uncancelable(const Uncancelable&) = delete;
        Uncancelable& operator=(const Uncancelable&) = delete;

      private:
        Conversation& conversation_;
        bool before_;
    };
    /// Looks at signals to the host and at viewers, once, while the host itself computes `what`.
    /// Throws Canceled, MachineError.
    void pause(const std::string& what);
    bool has_fault() const { return fault_.has_value(); }
    /// Pumps until `done` and gives messages, except activities, to `take` only. Drops the fault,
    /// if any.
    void discard_until(const Handler& take, const std::function<bool()>& done);

  private:
    struct Failure {
        std::string reason;
        bool is_internal = false;  ///< Not caused by the user: its traces are of interest.
    };

    /// Answers of a canceled request that are still to come.
    struct Late {
        bus::Body request = bus::Body::NONE;
        Answer answers;
        std::set<bus::NodeId> from;
    };

    void take(const bus::Message& message);
    bool is_late(const bus::Message& message);
    void take_fault(const bus::Message& message);
    std::string traces_of(const Failure& failure) const;

    MachinePort& machine_;
    std::map<bus::Body, Handler> handlers_;
    std::function<bool(std::uint32_t)> takes_frame_fault_;
    Answer answer_;
    std::set<bus::NodeId> answered_;  ///< GPs that have answered the request under way.
    std::vector<Late> late_;
    std::optional<Failure> fault_;
    std::uint64_t broadcasts_ = 0;
    std::uint64_t other_changes_ = 0;
    bool is_uncancelable_ = false;
};

}  // namespace pxpl5::host
