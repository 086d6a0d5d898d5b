#include "ringbus/zmq/arena_blocks.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace pxpl5::bus {

namespace {

constexpr std::size_t round_up(std::size_t bytes) {
    constexpr std::size_t grain = ArenaBlocks::grain_bytes;
    return (std::max<std::size_t>(bytes, 1) + grain - 1) / grain * grain;
}

}  // namespace

ArenaBlocks::ArenaBlocks(std::size_t size_bytes) : size_bytes_(size_bytes) {
    assert(size_bytes % grain_bytes == 0);
    free_.emplace(0, size_bytes);
}

std::optional<std::size_t> ArenaBlocks::take(std::size_t bytes) {
    if (bytes > size_bytes_) {
        return std::nullopt;
    }
    const std::size_t wanted = round_up(bytes);
    const auto found = std::find_if(free_.begin(), free_.end(),
                                    [wanted](const auto& block) { return block.second >= wanted; });
    if (found == free_.end()) {
        return std::nullopt;
    }
    const auto [offset, size] = *found;
    free_.erase(found);
    if (size > wanted) {
        free_.emplace(offset + wanted, size - wanted);
    }
    return offset;
}

void ArenaBlocks::give_back(std::size_t offset, std::size_t bytes) {
    auto block = free_.emplace(offset, round_up(bytes)).first;
    if (const auto after = std::next(block); after != free_.end()) {
        assert(block->first + block->second <= after->first);
        if (block->first + block->second == after->first) {
            block->second += after->second;
            free_.erase(after);
        }
    }
    if (block != free_.begin()) {
        const auto before = std::prev(block);
        assert(before->first + before->second <= block->first);
        if (before->first + before->second == block->first) {
            before->second += block->second;
            free_.erase(block);
        }
    }
}

std::size_t ArenaBlocks::end_in_use() const {
    if (free_.empty()) {
        return size_bytes_;
    }
    const auto& [offset, size] = *free_.rbegin();
    return offset + size == size_bytes_ ? offset : size_bytes_;
}

}  // namespace pxpl5::bus
