#include "ringbus/pulse.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <new>
#include <stop_token>
#include <system_error>

#include "ringbus/activity.hpp"

namespace pxpl5::bus {

namespace {

constexpr std::size_t cell_bytes = sizeof(PulseWords);

// `work` has the kind in bits 0..15, the phase in bits 16..23 and the subject in bits 32..63.
constexpr int phase_shift = 16, high_half = 32;

[[noreturn]] void fail(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

/// Only one thread writes, so no locked instruction is needed.
void count(std::atomic<std::uint64_t>& value) {
    value.store(value.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

/// A thread that takes no signal: signals are for the thread of the node.
std::jthread quiet_thread(const std::function<void(const std::stop_token&)>& act) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    std::jthread thread(act);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return thread;
}

void beat(const std::stop_token& stop, PulseWords& words, std::chrono::milliseconds interval) {
    words.beater.store(gettid());
    count(words.beats);  // A process that says Hello has beaten. Otherwise, it is one that starts.
    words.beater.notify_one();
    std::mutex mutex;
    std::condition_variable_any bell;
    std::unique_lock lock(mutex);
    while (!bell.wait_for(lock, stop, interval, [&stop] { return stop.stop_requested(); })) {
        words.cpu_ns.store(processor_ns(), std::memory_order_relaxed);
        count(words.beats);
    }
}

}  // namespace

PulseCell::PulseCell() : fd_(memfd_create("pxpl5-pulse", MFD_CLOEXEC | MFD_ALLOW_SEALING)) {
    constexpr int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
    if (fd_ < 0 || ftruncate(fd_, cell_bytes) != 0 || fcntl(fd_, F_ADD_SEALS, seals) != 0) {
        fail("cannot make shared memory for a pulse");
    }
    map();
    new (words_) PulseWords;
}

PulseCell::PulseCell(int fd) : fd_(fd) {
    struct stat facts {};
    if (fstat(fd_, &facts) != 0 || facts.st_size < static_cast<off_t>(cell_bytes)) {
        throw std::system_error(EINVAL, std::generic_category(), "the descriptor is no pulse");
    }
    map();
    close_fd();
}

PulseCell::~PulseCell() {
    munmap(words_, cell_bytes);
    close_fd();
}

void PulseCell::map() {
    void* place = mmap(nullptr, cell_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
    if (place == MAP_FAILED) {
        fail("cannot map the shared memory of a pulse");
    }
    words_ = static_cast<PulseWords*>(place);
}

void PulseCell::close_fd() {
    if (fd_ >= 0) {
        close(fd_);
        fd_ = -1;
    }
}

PulseReading PulseCell::read() const {
    const auto value = [](const std::atomic<std::uint64_t>& word) {
        return word.load(std::memory_order_relaxed);
    };
    const std::uint64_t work = value(words_->work), place = value(words_->place);
    PulseReading reading{.beats = value(words_->beats),
                         .progress = value(words_->progress),
                         .worked = value(words_->worked),
                         .cpu_ns = value(words_->cpu_ns),
                         .beater = words_->beater.load(std::memory_order_relaxed),
                         .phase = static_cast<Phase>(work >> phase_shift & 0xff),
                         .doing = {}};
    const std::uint64_t kind = work & 0xffff;
    reading.doing.kind =
        kind <= static_cast<std::uint64_t>(Body::MAX) ? static_cast<Body>(kind) : Body::NONE;
    reading.doing.subject = static_cast<std::uint32_t>(work >> high_half);
    reading.doing.done = static_cast<std::uint32_t>(place);
    reading.doing.total = static_cast<std::uint32_t>(place >> high_half);
    return reading;
}

PulseNumbers PulseCell::numbers() const {
    constexpr auto order = std::memory_order_relaxed;
    return {words_->beats.load(order),  words_->progress.load(order), words_->worked.load(order),
            words_->cpu_ns.load(order), words_->work.load(order),     words_->place.load(order)};
}

void PulseCell::set(const PulseNumbers& numbers) {
    constexpr auto order = std::memory_order_relaxed;
    words_->beats.store(numbers.beats, order);
    words_->progress.store(numbers.progress, order);
    words_->worked.store(numbers.worked, order);
    words_->cpu_ns.store(numbers.cpu_ns, order);
    words_->work.store(numbers.work, order);
    words_->place.store(numbers.place, order);
}

Pulse::Pulse(int fd, int interval_ms)
    : cell_(std::make_unique<PulseCell>(fd)),
      beating_(quiet_thread([&words = cell_->words(), interval_ms](const std::stop_token& stop) {
          beat(stop, words, std::chrono::milliseconds(interval_ms));
      })) {
    cell_->words().beater.wait(0);  // The host may look for the thread once the node has beaten.
}

void Pulse::enter(Phase phase, const Doing& doing) {
    if (!cell_) {
        return;
    }
    PulseWords& words = cell_->words();
    words.work.store(static_cast<std::uint64_t>(doing.kind) |
                         static_cast<std::uint64_t>(phase) << phase_shift |
                         static_cast<std::uint64_t>(doing.subject) << high_half,
                     std::memory_order_relaxed);
    words.place.store(doing.done | static_cast<std::uint64_t>(doing.total) << high_half,
                      std::memory_order_relaxed);
    count(words.progress);
    if (phase != Phase::waiting) {
        count(words.worked);
    }
}

}  // namespace pxpl5::bus
