// Guards the connections of a tcp socket: CURVE, and a thread that answers ZeroMQ's questions
// (ZAP).
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <zmq.hpp>

#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::bus {

/// Makes `inbound` accept only clients with the key pair `keys`. Call before bind().
void guard_inbound(zmq::socket_t& inbound, const CurveKeys& keys);

/// Makes `outbound` accept only a server with the key pair `keys`, and prove the same key.
void guard_outbound(zmq::socket_t& outbound, const CurveKeys& keys);

/// Which connections count as those of strangers.
enum class Counted : std::uint8_t {
    all,      ///< Each that has ended without a proof of the key.
    not_cut,  ///< All, except those that the other side has ended before the proof was due.
};

/// Accepts the session's own key and counts the connections that do not prove it.
///
/// The destructor waits for the threads, which end with the context. So the guard must outlive the
/// context.
class Guard {
  public:
    Guard() = default;
    ~Guard();
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;

    /// Starts the thread. Call before `inbound` is bound.
    void start(zmq::context_t& context, zmq::socket_t& inbound, const CurveKeys& keys,
               Counted counted = Counted::all);
    /// Also counts the connections to another socket of the context. Call before it is bound.
    void follow(zmq::context_t& context, zmq::socket_t& inbound);
    /// Connections so far that ended without a proof of the key.
    std::uint64_t strangers() const { return strangers_.load(std::memory_order_relaxed); }

  private:
    std::atomic<std::uint64_t> strangers_{0};
    std::thread thread_, follower_;
};

}  // namespace pxpl5::bus
