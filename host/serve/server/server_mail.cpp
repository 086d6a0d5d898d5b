#include "host/serve/server/server_mail.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace pxpl5::host::serve {

namespace {

/// The layers of a state and the resting picture of the state arrive in any order.
NewestFrame next_frame(const NewestFrame& before, Shown frame, std::uint64_t sequence) {
    const bool is_same_state = frame.revision == before.shown.revision;
    if (is_same_state && before.shown.rests && frame.layers > 1) {
        return {before.sequence, before.shown, std::make_shared<const Shown>(std::move(frame))};
    }
    std::shared_ptr<const Shown> layers;
    if (is_same_state && frame.rests) {
        layers =
            before.shown.layers > 1 ? std::make_shared<const Shown>(before.shown) : before.layers;
    }
    return {sequence, std::move(frame), std::move(layers)};
}

}  // namespace

Mail::Mail() : event_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (event_fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    newest_ = newest_pair_ = std::make_shared<NewestFrame>();
}

Mail::~Mail() {
    close(event_fd_);
}

void Mail::wake_session() {
    // It can only fail because the counter is full, and then the descriptor is readable.
    (void)eventfd_write(event_fd_, 1);
}

std::vector<Event> Mail::take() {
    const std::scoped_lock lock(mutex_);
    eventfd_t count = 0;
    (void)eventfd_read(event_fd_, &count);  // Fails if nothing waits: nothing to reset.
    event_bytes_ = 0;
    return std::exchange(events_, {});
}

void Mail::send(Outgoing message) {
    {
        const std::scoped_lock lock(mutex_);
        outgoing_.push_back(std::move(message));
    }
    wake_server();
}

void Mail::show(Shown frame) {
    {
        const std::scoped_lock lock(mutex_);
        const bool is_pair = frame.viewer != 0;
        if (is_pair && frame.viewer != wearer_.viewer) {
            return;
        }
        if (is_pair) {
            newest_pair_ = std::make_shared<NewestFrame>(NewestFrame{++frames_, std::move(frame)});
        } else {
            newest_ =
                std::make_shared<NewestFrame>(next_frame(*newest_, std::move(frame), frames_ + 1));
            frames_ = std::max(frames_, newest_->sequence);
        }
        // Until the server has seen who takes this one.
        (is_pair ? wants_pair_ : wants_frame_) = false;
    }
    wake_server();
}

void Mail::wear(std::uint32_t viewer, std::size_t pair_pixels) {
    {
        const std::scoped_lock lock(mutex_);
        if (viewer == wearer_.viewer && pair_pixels == wearer_.pair_pixels) {
            return;  // Only the pose is newer.
        }
        if (viewer != wearer_.viewer) {
            NewestFrame none;
            none.shown.viewer = viewer;
            newest_pair_ = std::make_shared<NewestFrame>(std::move(none));
            wants_pair_ = false;
        }
        wearer_ = {viewer, pair_pixels};
    }
    wake_server();
}

void Mail::opened(std::string path) {
    {
        const std::scoped_lock lock(mutex_);
        opened_.push_back(std::move(path));
    }
    wake_server();
}

/// A viewer that has joined and left before the session looked, and said nothing, leaves no trace.
/// Otherwise connections that come and go would fill the memory while the session works.
bool Mail::take_back(const Left& left) {
    auto joined = events_.end();
    for (auto event = events_.begin(); event != events_.end(); ++event) {
        const auto* const said = std::get_if<Said>(&*event);
        if (said != nullptr && said->viewer == left.viewer) {
            return false;
        }
        const auto* const came = std::get_if<Joined>(&*event);
        if (came != nullptr && came->viewer == left.viewer) {
            joined = event;
        }
    }
    if (joined == events_.end()) {
        return false;
    }
    events_.erase(joined);
    return true;
}

bool Mail::push(Event event) {
    const auto* said = std::get_if<Said>(&event);
    const std::size_t bytes = said == nullptr ? 0 : said->text.size() + sizeof(Event);
    const std::scoped_lock lock(mutex_);
    if (bytes > 0 && event_bytes_ + bytes > max_waiting_event_bytes) {
        return false;
    }
    const auto* const left = std::get_if<Left>(&event);
    if (left != nullptr && take_back(*left)) {
        return true;
    }
    event_bytes_ += bytes;
    events_.push_back(std::move(event));
    wake_session();
    return true;
}

std::vector<Outgoing> Mail::collect() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(outgoing_, {});
}

std::vector<std::string> Mail::collect_opened() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(opened_, {});
}

std::shared_ptr<const NewestFrame> Mail::newest(std::uint32_t viewer) const {
    const std::scoped_lock lock(mutex_);
    return viewer != 0 && viewer == wearer_.viewer ? newest_pair_ : newest_;
}

Wearer Mail::wearer() const {
    const std::scoped_lock lock(mutex_);
    return wearer_;
}

void Mail::advise(const Wants& wants) {
    const std::scoped_lock lock(mutex_);
    scale_ = wants.advice.scale;
    wants_depths_ = wants.advice.wants_depths;
    pair_scale_ = wants.advice.pair_scale;
    const bool frame = wants.frame && wants.frame_sequence == newest_->sequence;
    const bool pair = wants.pair && wants.pair_sequence == newest_pair_->sequence;
    if ((frame && !wants_frame_) || (pair && !wants_pair_)) {
        wake_session();
    }
    wants_frame_ = frame;
    wants_pair_ = pair;
}

}  // namespace pxpl5::host::serve
