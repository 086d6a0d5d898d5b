#include "host/serve/server/server_mail.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace pxpl5::host::serve {

Mail::Mail() : event_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (event_fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    newest_ = std::make_shared<NewestFrame>();
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
        auto next =
            std::make_shared<NewestFrame>(NewestFrame{newest_->sequence + 1, std::move(frame)});
        newest_ = std::move(next);
        wants_frame_ = false;  // Until the server has seen who takes this one.
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

std::shared_ptr<const NewestFrame> Mail::newest() const {
    const std::scoped_lock lock(mutex_);
    return newest_;
}

void Mail::advise(bool wanted, std::uint64_t sequence, LinkAdvice advice) {
    const std::scoped_lock lock(mutex_);
    scale_ = advice.scale;
    wants_depths_ = advice.wants_depths;
    const bool wants = wanted && sequence == newest_->sequence;
    if (wants && !wants_frame_) {
        wake_session();
    }
    wants_frame_ = wants;
}

}  // namespace pxpl5::host::serve
