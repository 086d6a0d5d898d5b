// A Graphics Processor's local memory: a budget in bytes that what it holds is charged to.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace pxpl5::gp {

/// Something does not fit into a GP's local memory. what() also says how many GPs would do.
class OutOfLocalMemory : public std::runtime_error {
  public:
    /// advice  A sentence on what would help; may be empty.
    OutOfLocalMemory(const std::string& what_for, std::size_t needed_bytes,
                     std::size_t available_bytes, const std::string& advice);

    std::size_t needed_bytes;
    std::size_t available_bytes;
};

/// The budget. Holds numbers only; whoever charges owns the bytes.
class LocalMemory {
  public:
    explicit LocalMemory(std::size_t size_bytes) : size_bytes_(size_bytes) {}

    /// Takes `bytes` from the budget for `what_for`, a noun ("slice 12").
    /// Throws OutOfLocalMemory if they are not there; the budget is then unchanged.
    void charge(std::size_t bytes, const std::string& what_for, const std::string& advice = {});

    /// Gives back bytes that were charged before.
    void release(std::size_t bytes);

    std::size_t size_bytes() const { return size_bytes_; }
    std::size_t used_bytes() const { return used_bytes_; }
    std::size_t available_bytes() const { return size_bytes_ - used_bytes_; }

  private:
    std::size_t size_bytes_;
    std::size_t used_bytes_ = 0;
};

}  // namespace pxpl5::gp
