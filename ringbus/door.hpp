// The door of a node: drops received messages that have no lawful sender.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ringbus/law.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Why a door refuses.
enum class RefusalReason : std::uint8_t {
    no_message,      ///< The bytes have no header of this protocol, or are no Hello.
    unknown_sender,  ///< The source is not a node of this machine.
    unlawful,        ///< The sender's role or standing does not allow this kind.
    wrong_secret,    ///< A Hello without the machine's secret.
    stranger,        ///< A connection that did not prove the session's key.
    wrong_entrance,  ///< The sender's role has another socket.
};
inline constexpr std::size_t refusal_reasons = 6;

/// The socket by which a message came.
enum class Entrance : std::uint8_t {
    common,
    apart,  ///< For one role only, see Door::keep_apart().
};

/// The first refusal of a node that has said Hello, or the first for a reason otherwise.
struct Refusal {
    RefusalReason reason = RefusalReason::no_message;
    NodeId source = host_id;
    bool has_joined = false;  ///< `source` has proved that it is a node of this machine.
    std::string text;
};

/// Knows the nodes whose messages may enter, and counts the others. A refused message changes
/// nothing but the count: no sequence number, no modelled time, no credit.
///
/// A node is expected, then it joins with Hello, then Connected makes it a member. Peers that the
/// host has named are members at once. One thread uses the door.
class Door {
  public:
    /// role  This node's role.
    explicit Door(schema::Role role) : role_(role) {}

    /// Lets nodes of this role in by the entrance `apart` only, and other nodes by `common` only.
    void keep_apart(schema::Role role) { apart_ = role; }
    /// Lets only a Hello of node `id` in, then only Connected and Fault, then all lawful kinds.
    void expect(NodeId id, schema::Role role);
    /// Lets all lawful kinds of node `id` in, unless the node is expected or has joined.
    void admit(NodeId id, schema::Role role);
    /// Drops what node `id` still sends, without a count, because its process has ended.
    void forget(NodeId id);

    /// Returns whether the source of `header` may send this kind now, and by this entrance. Counts
    /// a refusal. Requires Wire::is_ours(header).
    bool lets_in(const schema::Header& header, Entrance entrance = Entrance::common);
    /// Returns whether `hello` is of the node that `header` names and has `secret`, and lets the
    /// node join. Counts a refusal.
    bool lets_join(const schema::Header& header, const schema::Hello& hello,
                   const schema::Secret& secret);
    /// The next messages of an accepted node, after its Connected.
    void connect(NodeId id);

    /// Counts a refusal of `messages` without a known sender.
    void refuse(RefusalReason reason, const std::string& text, std::uint64_t messages = 1);

    /// Calls `report` with the first refusal for each reason, and of each node that has joined.
    void on_refusal(std::function<void(const Refusal&)> report) { report_ = std::move(report); }
    /// Refused messages and connections so far.
    std::uint64_t refused() const { return refused_; }
    /// True if the node may take part: it is a member, or has joined.
    bool has_joined(NodeId id) const;
    bool is_expected(NodeId id) const { return standing_of(id) == Standing::expected; }

  private:
    enum class Standing : std::uint8_t { unknown, gone, expected, joining, member };
    struct Entry {
        Standing standing = Standing::unknown;
        schema::Role role = schema::Role::host;
        bool is_reported = false;
    };

    Standing standing_of(NodeId id) const {
        return id < entries_.size() ? entries_[id].standing : Standing::unknown;
    }
    Entry& entry_of(NodeId id);
    /// Returns whether the source of `header` may use `entrance`. Counts a refusal.
    bool may_use(const schema::Header& header, Entrance entrance);
    bool is_allowed(const Entry& entry, Body kind) const;
    void refuse_known(const schema::Header& header, RefusalReason reason, const std::string& why);

    schema::Role role_;
    std::optional<schema::Role> apart_;
    std::vector<Entry> entries_;  ///< By node id.
    std::array<bool, refusal_reasons> is_reported_{};
    std::uint64_t refused_ = 0;
    std::function<void(const Refusal&)> report_;
};

}  // namespace pxpl5::bus
