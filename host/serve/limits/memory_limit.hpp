// The memory that a session may use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>

namespace pxpl5::host::serve {

/// "4.2 GiB".
std::string gib_text(std::uint64_t bytes);

/// Memory that this process and its children may still use: what the computer has left, or less if
/// a control group (version 2) around this process allows less. Empty if it is unknown.
///
/// root  The folder with proc and the mounted control groups.
std::optional<std::uint64_t> free_memory(const std::filesystem::path& root = "/");

/// Looks every 2 s, from a thread of its own, at the memory of this process and of all that it has
/// started on this computer. Shared pages count once.
class MemoryWatch {
  public:
    /// limit_bytes  0: none.
    /// act          Called once, with a sentence, when the processes have more than the limit. It
    ///              must end this process: 20 s later, the watch kills this process.
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
