#include "host/serve/inbox.hpp"

#include <cassert>
#include <utility>

namespace pxpl5::host::serve {

Inbox::Outcome Inbox::add(Wish wish) {
    Entry entry{std::move(wish), {}, false};
    if (!entry.wish.is_ask) {
        entry.subject = subject_of(entry.wish.arguments);
        entry.is_barrier = entry.subject.empty();
    }
    for (auto older = waiting_.rbegin(); older != waiting_.rend(); ++older) {
        if (entry.is_barrier || older->is_barrier || entry.wish.is_ask) {
            break;
        }
        if (older->subject == entry.subject) {
            return {Added::waits, std::exchange(*older, std::move(entry)).wish};
        }
    }
    if (waiting_.size() == max_waiting) {
        return {Added::full, std::nullopt};
    }
    waiting_.push_back(std::move(entry));
    return {};
}

Wish Inbox::take() {
    assert(!waiting_.empty());
    Wish wish = std::move(waiting_.front().wish);
    waiting_.pop_front();
    return wish;
}

void Inbox::forget_asks(std::uint32_t viewer) {
    std::erase_if(waiting_, [viewer](const Entry& entry) {
        return entry.wish.is_ask && entry.wish.viewer == viewer;
    });
}

}  // namespace pxpl5::host::serve
