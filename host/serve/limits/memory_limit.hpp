// The memory that a session may use.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <thread>

namespace pxpl5::host::serve {

/// "4.2 GiB".
std::string gib_text(std::uint64_t bytes);

/// Looks every 2 s, from a thread of its own, at the memory of this process and of all that it has
/// started on this computer. Shared pages count once.
class MemoryWatch {
  public:
    /// limit_bytes  0: none.
    /// act          Called once, with a sentence, when the processes have more than the limit.
    MemoryWatch(std::uint64_t limit_bytes, std::function<void(const std::string& why)> act);
    /// Ends the thread.
    ~MemoryWatch();
    MemoryWatch(const MemoryWatch&) = delete;
    MemoryWatch& operator=(const MemoryWatch&) = delete;

  private:
    void run(std::uint64_t limit_bytes) const;

    int stop_fd_;
    std::function<void(const std::string&)> act_;
    std::thread thread_;
};

}  // namespace pxpl5::host::serve
