#include "host/serve/director/inbox.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <utility>

namespace pxpl5::host::serve {

namespace {

/// The surface or light that is set, if the command can set several.
std::string thing_of(const Arguments& arguments) {
    const bool has_thing =
        find_command(arguments.name).subject_words > 0 && !arguments.words.empty();
    return has_thing ? arguments.words.front() : std::string();
}

}  // namespace

Inbox::Outcome Inbox::add(Wish wish) {
    return wish.is_ask ? add_ask(std::move(wish)) : add_command(std::move(wish));
}

Inbox::Outcome Inbox::add_command(Wish wish) {
    const Arguments& arguments = wish.arguments;
    // pick X Y set=NAME is the only question that changes the scene.
    const bool changes_picture =
        kind_of(arguments) != CommandKind::question || arguments.has("set");
    Command command{{}, subject_of(arguments), thing_of(arguments), changes_picture};
    command.wish = std::move(wish);
    Outcome outcome;
    if (!command.subject.empty()) {
        outcome.superseded = supersede(command);
    }
    if (commands_.size() == max_waiting) {
        return {Added::full, std::nullopt};
    }
    // At the end, because another setting of the same parameter may lie between the two.
    commands_.push_back(std::move(command));
    return outcome;
}

/// Removes the setting that `newer` replaces, if any.
std::optional<Wish> Inbox::supersede(const Command& newer) {
    const auto settings_end =
        std::find_if(commands_.rbegin(), commands_.rend(),
                     [](const Command& each) { return each.subject.empty(); });
    const auto older = std::find_if(commands_.rbegin(), settings_end, [&](const Command& each) {
        return each.subject == newer.subject;
    });
    if (older == settings_end) {
        return std::nullopt;
    }
    // The first setting of a surface or light may add it: later settings would fail without it.
    const auto is_of_thing = [&](const Command& each) {
        return !newer.thing.empty() && each.thing == newer.thing;
    };
    if (std::any_of(commands_.rbegin(), older, is_of_thing) &&
        std::none_of(std::next(older), settings_end, is_of_thing)) {
        return std::nullopt;
    }
    Wish superseded = std::move(older->wish);
    commands_.erase(std::next(older).base());
    return superseded;
}

Inbox::Outcome Inbox::add_ask(Wish wish) {
    std::size_t of_viewer = 0;
    for (Wish& older : asks_) {
        if (older.viewer != wish.viewer) {
            continue;
        }
        if (older.kind == wish.kind) {
            return {Added::waits, std::exchange(older, std::move(wish))};
        }
        ++of_viewer;
    }
    if (of_viewer == max_asks_of_a_viewer) {
        return {Added::full, std::nullopt};
    }
    asks_.push_back(std::move(wish));
    return {};
}

bool Inbox::changes_picture() const {
    return std::ranges::any_of(commands_, &Command::changes_picture);
}

Wish Inbox::take() {
    assert(!empty());
    Wish wish;
    if (has_command()) {
        wish = std::move(commands_.front().wish);
        commands_.pop_front();
    } else {
        wish = std::move(asks_.front());
        asks_.pop_front();
    }
    return wish;
}

std::optional<Wish> Inbox::take_ask(std::string_view kind) {
    const auto found =
        std::ranges::find_if(asks_, [kind](const Wish& ask) { return ask.kind.starts_with(kind); });
    if (found == asks_.end()) {
        return std::nullopt;
    }
    Wish ask = std::move(*found);
    asks_.erase(found);
    return ask;
}

void Inbox::forget_asks(std::uint32_t viewer) {
    std::erase_if(asks_, [viewer](const Wish& ask) { return ask.viewer == viewer; });
}

}  // namespace pxpl5::host::serve
