#include "ringbus/zmq/arena.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

namespace pxpl5::bus {

namespace {

/// Memory grows by this step, or by an eighth. Growing page by page costs twice as much.
constexpr std::size_t least_step_bytes = std::size_t{64} << 10;
/// After this many allocations, memory that they did not use is returned to the system.
constexpr std::uint32_t allocations_per_trim = 4096;
constexpr std::size_t worth_trimming_bytes = std::size_t{1} << 20;

constexpr std::size_t round_up(std::size_t bytes, std::size_t step) {
    return (bytes + step - 1) / step * step;
}

/// Returns true if the process has unlimited address space. Otherwise the arena stays unused.
bool has_address_space() {
    rlimit limit{};
    return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
}

template <typename T>
T* map_part(int file, std::size_t offset, std::size_t bytes, int access) {
    void* memory = mmap(nullptr, bytes, access, MAP_SHARED, file, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : static_cast<T*>(memory);
}

void unmap(const void* memory, std::size_t bytes) {
    if (memory != nullptr) {
        munmap(const_cast<void*>(memory), bytes);
    }
}

/// Closes the file in the destructor.
struct OpenFile {
    int number = -1;

    explicit OpenFile(int opened = -1) : number(opened) {}
    OpenFile(OpenFile&& other) noexcept : number(std::exchange(other.number, -1)) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    ~OpenFile() {
        if (number >= 0) {
            close(number);
        }
    }
};

/// Opens the file of `offer`; returns none if the file is no arena. Opening a device or a pipe can
/// have effects, so the file is opened with O_PATH until its identity is checked.
OpenFile open_arena(const ArenaOffer& offer) {
    const std::string path = fmt::format("/proc/{}/fd/{}", offer.pid, offer.descriptor);
    const OpenFile found{open(path.c_str(), O_PATH | O_CLOEXEC)};
    struct stat facts {};
    if (found.number < 0 || fstat(found.number, &facts) != 0 || !S_ISREG(facts.st_mode) ||
        facts.st_dev != offer.device || facts.st_ino != offer.inode ||
        static_cast<std::size_t>(facts.st_size) != arena_file_bytes) {
        return OpenFile{};
    }
    const std::string same = fmt::format("/proc/self/fd/{}", found.number);
    OpenFile file{open(same.c_str(), O_RDWR | O_CLOEXEC)};
    // The seal prevents a shorter file, so that reading cannot raise SIGBUS.
    const int seals = file.number < 0 ? -1 : fcntl(file.number, F_GET_SEALS);
    return seals >= 0 && (seals & F_SEAL_SHRINK) != 0 ? std::move(file) : OpenFile{};
}

}  // namespace

Arena::Arena(std::size_t lendable_bytes) : blocks_(lendable_bytes) {
    assert(lendable_bytes <= arena_bytes);
}

Arena::~Arena() {
    unmap(control_, sizeof(ArenaControl));
    unmap(bodies_, arena_bytes);
    if (file_ >= 0) {
        close(file_);
    }
}

/// The file has no name. The system removes it when the last process that has it open ends.
bool Arena::open() {
    if (state_ != State::unopened) {
        return state_ == State::open;
    }
    state_ = State::unavailable;
    file_ = has_address_space() ? memfd_create("pxpl5-arena", MFD_CLOEXEC | MFD_ALLOW_SEALING) : -1;
    struct stat facts {};
    if (file_ < 0 || ftruncate(file_, static_cast<off_t>(arena_file_bytes)) != 0 ||
        fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0 ||
        fstat(file_, &facts) != 0) {
        return false;
    }
    control_ = map_part<ArenaControl>(file_, 0, sizeof(ArenaControl), PROT_READ | PROT_WRITE);
    bodies_ =
        map_part<std::uint8_t>(file_, sizeof(ArenaControl), arena_bytes, PROT_READ | PROT_WRITE);
    if (control_ == nullptr || bodies_ == nullptr) {
        return false;
    }
    // All other fields begin as zero, like the pages of a new file.
    control_->returned.store(no_ticket, std::memory_order_relaxed);
    offer_ = {facts.st_dev, facts.st_ino, static_cast<std::uint32_t>(getpid()),
              static_cast<std::uint32_t>(file_)};
    loans_.resize(max_tickets);
    tickets_.resize(max_tickets);
    std::iota(tickets_.rbegin(), tickets_.rend(), 0U);
    state_ = State::open;
    return true;
}

bool Arena::contains(const std::uint8_t* memory) const {
    return bodies_ != nullptr && memory >= bodies_ && memory < bodies_ + arena_bytes;
}

std::uint8_t* Arena::allocate(std::size_t bytes) {
    if (bytes >= min_arena_body_bytes && open()) {
        collect();
        const std::lock_guard lock(blocks_mutex_);
        trim();
        if (const auto offset = blocks_.take(bytes)) {
            const std::size_t end = *offset + bytes;
            if (touch(end)) {
                recently_used_ = std::max(recently_used_, end);
                return bodies_ + *offset;
            }
            blocks_.give_back(*offset, bytes);
        }
    }
    return new std::uint8_t[bytes];
}

void Arena::deallocate(std::uint8_t* memory, std::size_t bytes) {
    // Another thread may drop a small body during open(). Every large body, on the heap or not, was
    // allocated after open().
    if (bytes < min_arena_body_bytes || !contains(memory)) {
        delete[] memory;
        return;
    }
    const std::lock_guard lock(blocks_mutex_);
    blocks_.give_back(static_cast<std::size_t>(memory - bodies_), bytes);
}

/// Makes the system allocate memory up to `end` at once, not page by page at the first write.
/// Returns false if the system has no memory.
bool Arena::touch(std::size_t end) {
    if (end <= touched_) {
        return true;
    }
    const std::size_t step = std::max(least_step_bytes, touched_ / 8);
    const std::size_t wanted =
        std::min(arena_bytes, std::max(end, round_up(touched_ + step, arena_page_bytes)));
    const std::size_t new_end = round_up(wanted, arena_page_bytes);
    const bool good = madvise(bodies_ + touched_, new_end - touched_, MADV_POPULATE_WRITE) == 0;
    if (!good && errno != EINVAL) {  // EINVAL: a kernel before 5.14 allocates page by page.
        return false;
    }
    touched_ = new_end;
    reached_ = std::max(reached_, touched_);
    return true;
}

/// Frames differ in size, so that only many allocations show which memory is unused.
void Arena::trim() {
    if (++allocations_ < allocations_per_trim) {
        return;
    }
    const std::size_t kept =
        round_up(std::max(recently_used_, blocks_.end_in_use()), arena_page_bytes);
    if (kept + kept / 8 + worth_trimming_bytes < reached_) {
        punch(kept, reached_);
        reached_ = kept;
        touched_ = std::min(touched_, kept);
    }
    recently_used_ = blocks_.end_in_use();
    allocations_ = 0;
}

/// Returns the memory of these bytes to the system. They read as zero afterwards.
void Arena::punch(std::size_t begin, std::size_t end) const {
    fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
              static_cast<off_t>(sizeof(ArenaControl) + begin), static_cast<off_t>(end - begin));
}

void Arena::return_memory() {
    if (state_ != State::open) {
        return;
    }
    collect();
    const std::lock_guard lock(blocks_mutex_);
    for (const auto& [offset, size] : blocks_.free()) {
        const std::size_t begin = round_up(offset, arena_page_bytes);
        const std::size_t last_page = (offset + size) / arena_page_bytes * arena_page_bytes;
        const std::size_t end = std::min(reached_, last_page);
        if (begin + worth_trimming_bytes < end) {
            punch(begin, end);
            touched_ = std::min(touched_, begin);  // Later blocks get memory again.
        }
    }
}

bool Arena::can_lend(const Payload& payload) const {
    const auto bytes = payload.bytes();
    return bytes.size() >= min_arena_body_bytes && contains(bytes.data()) &&
           static_cast<std::uint64_t>(bytes.data() - bodies_) % body_alignment == 0;
}

std::optional<ArenaPlace> Arena::lend(NodeId reader, const Payload& payload) {
    if (!can_lend(payload) || reader >= max_arena_readers ||
        control_->is_read_by[reader].load(std::memory_order_acquire) == 0) {
        return std::nullopt;
    }
    collect();
    if (tickets_.empty()) {
        return std::nullopt;
    }
    const std::uint32_t ticket = tickets_.back();
    tickets_.pop_back();
    loans_[ticket] = Loan{payload, reader};
    control_->states[ticket].store(lent_to(reader), std::memory_order_release);
    ArenaPlace place;
    place.offset = static_cast<std::uint64_t>(payload.bytes().data() - bodies_);
    place.ticket = ticket;
    return place;
}

void Arena::collect() {
    std::uint32_t ticket = control_->returned.load(std::memory_order_relaxed);
    if (ticket != no_ticket) {
        ticket = control_->returned.exchange(no_ticket, std::memory_order_acquire);
    }
    // Receivers write this list. It may be damaged, but the loop must end.
    for (std::uint32_t n = 0; n < max_tickets && ticket < max_tickets; ++n) {
        const TicketState state = control_->states[ticket].load(std::memory_order_relaxed);
        if (state == ticket_free && loans_[ticket]) {
            loans_[ticket].reset();
            tickets_.push_back(ticket);
        }
        ticket = control_->next[ticket].load(std::memory_order_relaxed);
    }
}

void Arena::forget(NodeId reader) {
    if (state_ != State::open || reader >= max_arena_readers) {
        return;
    }
    control_->is_read_by[reader].store(0, std::memory_order_relaxed);
    collect();
    for (std::uint32_t ticket = 0; ticket < max_tickets; ++ticket) {
        if (loans_[ticket] && loans_[ticket]->reader == reader) {
            loans_[ticket].reset();
            control_->states[ticket].store(ticket_free, std::memory_order_relaxed);
            tickets_.push_back(ticket);
        }
    }
}

std::shared_ptr<ArenaView> ArenaView::open(const ArenaOffer& offer, NodeId self) {
    if (self >= max_arena_readers || !has_address_space()) {
        return nullptr;
    }
    const OpenFile file = open_arena(offer);
    if (file.number < 0) {
        return nullptr;
    }
    std::shared_ptr<ArenaView> view(new ArenaView(self));
    view->control_ =
        map_part<ArenaControl>(file.number, 0, sizeof(ArenaControl), PROT_READ | PROT_WRITE);
    view->bodies_ =
        map_part<const std::uint8_t>(file.number, sizeof(ArenaControl), arena_bytes, PROT_READ);
    if (view->control_ == nullptr || view->bodies_ == nullptr) {
        return nullptr;
    }
    view->control_->is_read_by[self].store(1, std::memory_order_release);
    return view;
}

ArenaView::~ArenaView() {
    unmap(control_, sizeof(ArenaControl));
    unmap(bodies_, arena_bytes);
}

std::shared_ptr<const void> ArenaView::hold(std::uint32_t ticket) {
    TicketState lent = lent_to(self_);
    if (ticket >= max_tickets ||
        !control_->states[ticket].compare_exchange_strong(
            lent, read_by(self_), std::memory_order_acquire, std::memory_order_relaxed)) {
        return nullptr;
    }
    const auto give_back = [view = shared_from_this(), ticket](const void*) {
        view->give_back(ticket);
    };
    return {static_cast<const void*>(bodies_), give_back};
}

std::span<const std::uint8_t> ArenaView::body(const schema::Header& header,
                                              const ArenaPlace& place) const {
    if (place.ticket >= max_tickets) {
        throw BadMessage(header, fmt::format("message from node {}: its ticket is {}, allowed are "
                                             "at most {}",
                                             header.source(), place.ticket, max_tickets - 1));
    }
    if (place.offset > arena_bytes || header.body_bytes() > arena_bytes - place.offset ||
        place.offset % body_alignment != 0) {
        throw BadMessage(
            header, fmt::format("message from node {}: its body is at {} and has {} bytes, the "
                                "sender's arena has {} bytes in words of {}",
                                header.source(), place.offset, header.body_bytes(), arena_bytes,
                                body_alignment));
    }
    return {bodies_ + place.offset, static_cast<std::size_t>(header.body_bytes())};
}

void ArenaView::give_back(std::uint32_t ticket) {
    TicketState held = read_by(self_);
    if (!control_->states[ticket].compare_exchange_strong(
            held, ticket_free, std::memory_order_acq_rel, std::memory_order_relaxed)) {
        return;  // The sender forgot this node and may have lent the ticket to another node.
    }
    std::uint32_t first = control_->returned.load(std::memory_order_relaxed);
    do {
        control_->next[ticket].store(first, std::memory_order_relaxed);
    } while (!control_->returned.compare_exchange_weak(first, ticket, std::memory_order_release,
                                                       std::memory_order_relaxed));
}

}  // namespace pxpl5::bus
