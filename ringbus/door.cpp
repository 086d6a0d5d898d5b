#include "ringbus/door.hpp"

#include <fmt/core.h>

namespace pxpl5::bus {

namespace {

std::string name_of(const schema::Header& header) {
    const Body kind = known_kind(header);
    return fmt::format("{} from node {}",
                       kind == Body::NONE ? fmt::format("kind {}", header.kind()) : kind_name(kind),
                       header.source());
}

}  // namespace

Door::Entry& Door::entry_of(NodeId id) {
    if (id >= entries_.size()) {
        entries_.resize(std::size_t{id} + 1);
    }
    return entries_[id];
}

void Door::expect(NodeId id, schema::Role role) {
    entry_of(id) = {Standing::expected, role, false};
}

void Door::admit(NodeId id, schema::Role role) {
    Entry& entry = entry_of(id);
    if (entry.standing < Standing::expected) {
        entry = {Standing::member, role, false};
    }
}

void Door::forget(NodeId id) {
    if (id < entries_.size()) {
        entries_[id] = {Standing::gone, schema::Role::host, false};
    }
}

void Door::connect(NodeId id) {
    if (standing_of(id) == Standing::joining) {
        entries_[id].standing = Standing::member;
    }
}

bool Door::has_joined(NodeId id) const {
    return standing_of(id) >= Standing::joining;
}

bool Door::is_allowed(const Entry& entry, Body kind) const {
    const bool opens = kind == Body::Hello || kind == Body::Connected;
    switch (entry.standing) {
        case Standing::unknown:
        case Standing::gone:
            return false;
        case Standing::expected:
            return kind == Body::Hello && may_send(entry.role, kind, role_);
        case Standing::joining:
            return kind == Body::Connected || kind == Body::Fault;
        case Standing::member:
            return !opens && may_send(entry.role, kind, role_);
    }
    return false;
}

bool Door::may_use(const schema::Header& header, Entrance entrance) {
    const NodeId id = header.source();
    if (!apart_ || standing_of(id) < Standing::expected ||
        (entries_[id].role == *apart_) == (entrance == Entrance::apart)) {
        return true;
    }
    // The sender is not known. It is probably not the node that the header names.
    refuse(RefusalReason::wrong_entrance,
           fmt::format("{}, on the socket for nodes of {} {}", name_of(header),
                       entrance == Entrance::apart ? "role" : "roles other than",
                       schema::EnumNameRole(*apart_)));
    return false;
}

bool Door::lets_in(const schema::Header& header, Entrance entrance) {
    if (!may_use(header, entrance)) {
        return false;
    }
    if (header.source() < entries_.size() &&
        is_allowed(entries_[header.source()], known_kind(header))) {
        return true;
    }
    if (standing_of(header.source()) == Standing::unknown) {
        refuse(RefusalReason::unknown_sender,
               name_of(header) + ", which is not a node of this machine");
    } else if (standing_of(header.source()) != Standing::gone) {
        refuse_known(header, RefusalReason::unlawful,
                     is_expected(header.source())
                         ? "before its Hello"
                         : fmt::format("which a node of role {} may not send to a node of role {}",
                                       schema::EnumNameRole(entries_[header.source()].role),
                                       schema::EnumNameRole(role_)));
    }
    return false;
}

bool Door::lets_join(const schema::Header& header, const schema::Hello& hello,
                     const schema::Secret& secret) {
    Entry& entry = entry_of(header.source());
    const schema::Secret none;
    const schema::Secret& said = hello.secret() != nullptr ? *hello.secret() : none;
    // All bits are compared, so that the time does not depend on the first wrong bit.
    const bool has_secret =
        ((said.low() ^ secret.low()) | (said.high() ^ secret.high())) == 0 && hello.secret();
    if (has_secret && hello.role() == entry.role) {
        entry.standing = Standing::joining;
        return true;
    }
    refuse_known(header, RefusalReason::wrong_secret,
                 has_secret ? "with another role" : "without the secret of this machine");
    return false;
}

void Door::refuse(RefusalReason reason, const std::string& text, std::uint64_t messages) {
    refused_ += messages;
    bool& is_reported = is_reported_[static_cast<std::size_t>(reason)];
    if (!is_reported && report_) {
        is_reported = true;
        report_({reason, host_id, false, text});
    }
}

void Door::refuse_known(const schema::Header& header, RefusalReason reason,
                        const std::string& why) {
    Entry& entry = entries_[header.source()];
    const std::string text = fmt::format("{}, {}", name_of(header), why);
    if (entry.standing < Standing::joining) {
        refuse(reason, text);  // Anyone may use the number of a node that has not joined.
        return;
    }
    ++refused_;
    if (!entry.is_reported && report_) {
        entry.is_reported = true;
        report_({reason, header.source(), true, text});
    }
}

}  // namespace pxpl5::bus
