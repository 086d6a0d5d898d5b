// The local memory of a Graphics Processor: a budget in bytes.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace pxpl5::gp {

/// Thrown if data does not fit into a GP's local memory. what() includes the advice.
class OutOfLocalMemory : public std::runtime_error {
  public:
    /// advice  A sentence about a remedy; may be empty.
    OutOfLocalMemory(const std::string& what_for, std::size_t needed_bytes,
                     std::size_t available_bytes, const std::string& advice);

    std::size_t needed_bytes;
    std::size_t available_bytes;
};

/// The budget. It counts bytes; the callers own them.
class LocalMemory {
  public:
    explicit LocalMemory(std::size_t size_bytes) : size_bytes_(size_bytes) {}

    /// Takes `bytes` from the budget for `what_for`, a noun ("slice 12").
    /// Throws OutOfLocalMemory if fewer bytes are free; the budget is then unchanged.
    void charge(std::size_t bytes, const std::string& what_for, const std::string& advice = {});

    /// Returns charged bytes to the budget.
    void release(std::size_t bytes);

    std::size_t size_bytes() const { return size_bytes_; }
    std::size_t used_bytes() const { return used_bytes_; }
    std::size_t available_bytes() const { return size_bytes_ - used_bytes_; }

  private:
    std::size_t size_bytes_;
    std::size_t used_bytes_ = 0;
};

/// Returns the process's freed memory to the system, if the system's allocator can do so.
void return_freed_memory();

}  // namespace pxpl5::gp
