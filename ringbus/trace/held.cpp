#include "ringbus/trace/held.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace pxpl5::bus::trace {

namespace {

/// Groups of messages. A group is dropped as a whole when a new one begins.
enum class Group : std::uint8_t { machine, model, surfaces };

enum class Does : std::uint8_t {
    stays,     ///< Kept beside all others of its kind.
    replaces,  ///< Replaces the earlier message of its kind and key.
    begins,    ///< Drops model and surfaces, then stays.
    removes,   ///< Drops the messages of its group with its key, and itself.
    drops,     ///< Drops model and surfaces, and itself.
};

struct Rule {
    Body kind;
    Group group;
    Does does;
    bool bulk;                             ///< Counts against the limit.
    std::uint32_t (*key)(const Message&);  ///< Null if only one message applies.
};

std::uint32_t source_of(const Message& message) {
    return message.source();
}
template <typename Table>
std::uint32_t surface_of(const Message& message) {
    return message.as<Table>()->surface();
}

/// The kinds of messages that apply until a later message. Other kinds are not kept.
constexpr std::array rules = {
    Rule{Body::Hello, Group::machine, Does::replaces, false, source_of},
    Rule{Body::Topology, Group::machine, Does::replaces, false, nullptr},
    Rule{Body::VolumeHeader, Group::model, Does::begins, false, nullptr},
    Rule{Body::Slices, Group::model, Does::stays, true, nullptr},
    Rule{Body::VolumeEnd, Group::model, Does::stays, false, nullptr},
    Rule{Body::SceneBegin, Group::model, Does::begins, false, nullptr},
    Rule{Body::ScenePart, Group::model, Does::stays, true, nullptr},
    Rule{Body::SceneEnd, Group::model, Does::stays, false, nullptr},
    Rule{Body::SetSurface, Group::surfaces, Does::replaces, false, surface_of<schema::SetSurface>},
    Rule{Body::RemoveSurface, Group::surfaces, Does::removes, false,
         surface_of<schema::RemoveSurface>},
    // A mask of an older revision is harmless: the GP ignores it.
    Rule{Body::MaskSurface, Group::surfaces, Does::replaces, false,
         surface_of<schema::MaskSurface>},
    Rule{Body::DropVolume, Group::model, Does::drops, false, nullptr},
};

const Rule* rule_of(Body kind) {
    const auto* rule =
        std::find_if(rules.begin(), rules.end(), [kind](const Rule& r) { return r.kind == kind; });
    return rule == rules.end() ? nullptr : rule;
}

std::uint32_t key_of(const Rule& rule, const Message& message) {
    return rule.key == nullptr ? 0 : rule.key(message);
}

/// Returns true if `older` no longer applies after `message`.
bool ends(const Rule& rule, const Message& message, const Message& older) {
    const Rule& its = *rule_of(older.kind());
    switch (rule.does) {
        case Does::stays:
            return false;
        case Does::replaces:
            return its.kind == rule.kind && key_of(its, older) == key_of(rule, message);
        case Does::begins:
        case Does::drops:
            return its.group != Group::machine;
        case Does::removes:
            return its.group == rule.group && key_of(its, older) == key_of(rule, message);
    }
    return false;
}

}  // namespace

template <typename Test>
void HeldSetup::drop(const Test& test) {
    std::erase_if(held_, [&](const Held& older) {
        const bool dropped = test(older);
        if (dropped && rule_of(older.message.kind())->bulk) {
            bulk_bytes_ -= older.message.bytes().size();
        }
        return dropped;
    });
}

std::uint64_t HeldSetup::take(Held held) {
    const std::size_t before = held_.size() + 1;
    const Rule* rule = rule_of(held.message.kind());
    if (rule == nullptr) {
        return 1;
    }
    drop([&](const Held& older) { return ends(*rule, held.message, older.message); });
    bulk_refused_ = bulk_refused_ && rule->does != Does::begins && rule->does != Does::drops;
    if (rule->bulk) {
        bulk_bytes_ += held.message.bytes().size();
        held_.push_back(std::move(held));
        if (bulk_refused_ || bulk_bytes_ > limit_bytes_) {
            bulk_refused_ = true;  // A part of the volume would be useless.
            drop([](const Held& older) { return rule_of(older.message.kind())->bulk; });
        }
    } else if (rule->does != Does::removes && rule->does != Does::drops) {
        held_.push_back(std::move(held));
    }
    return before - held_.size();
}

}  // namespace pxpl5::bus::trace
