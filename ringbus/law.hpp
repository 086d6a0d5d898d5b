// The table of lawful senders (senders.def) as a lookup.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

namespace law {

using schema::Role;
using RoleSet = std::uint8_t;  ///< One bit per role.

constexpr RoleSet set_of(Role role) {
    return static_cast<RoleSet>(1U << static_cast<unsigned>(role));
}

struct Rule {
    Body kind;
    RoleSet senders, receivers;
};

namespace sets {
inline constexpr RoleSet host = set_of(Role::host), gp = set_of(Role::gp),
                         renderer = set_of(Role::renderer),
                         frame_buffer = set_of(Role::frame_buffer), io = set_of(Role::io);
inline constexpr RoleSet node = gp | renderer | frame_buffer, child = node | io, any = child | host;

inline constexpr Rule rules[] = {
#define MAY_SEND(kind, senders, receivers) {Body::kind, senders, receivers},
#include "ringbus/senders.def"
#undef MAY_SEND
};
}  // namespace sets

inline constexpr std::size_t kinds = static_cast<std::size_t>(Body::MAX) + 1;
inline constexpr std::size_t roles = static_cast<std::size_t>(Role::MAX) + 1;

/// Roles that may receive a kind, by sender and kind.
using Table = std::array<std::array<RoleSet, kinds>, roles>;

constexpr Table make_table() {
    Table table{};
    for (const Rule& rule : sets::rules) {
        for (std::size_t sender = 0; sender < roles; ++sender) {
            if ((rule.senders >> sender & 1U) != 0) {
                RoleSet& receivers = table[sender][static_cast<std::size_t>(rule.kind)];
                receivers = static_cast<RoleSet>(receivers | rule.receivers);
            }
        }
    }
    return table;
}
inline constexpr Table table = make_table();

/// True if every kind of message has a sender.
constexpr bool covers_all_kinds() {
    for (std::size_t kind = 1; kind < kinds; ++kind) {
        bool has_sender = false;
        for (const auto& by_kind : table) {
            has_sender = has_sender || by_kind[kind] != 0;
        }
        if (!has_sender) {
            return false;
        }
    }
    return true;
}
static_assert(covers_all_kinds(), "senders.def needs a rule for each value of Body");

}  // namespace law

/// True if a node of role `from` may send `kind` to a node of role `to`.
constexpr bool may_send(schema::Role from, Body kind, schema::Role to) {
    const auto sender = static_cast<std::size_t>(from), number = static_cast<std::size_t>(kind);
    return sender < law::roles && number < law::kinds &&
           (law::table[sender][number] & law::set_of(to)) != 0;
}

}  // namespace pxpl5::bus
