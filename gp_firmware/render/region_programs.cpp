#include "gp_firmware/render/region_programs.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace pxpl5::gp {

namespace {

constexpr std::size_t first_capacity_words = 1024;

}  // namespace

void WordBuffer::grow(std::size_t count) {
    const std::size_t capacity = std::max({first_capacity_words, 2 * capacity_, size_ + count});
    auto words = std::make_unique_for_overwrite<std::uint32_t[]>(capacity);
    if (size_ > 0) {
        std::memcpy(words.get(), words_.get(), size_ * sizeof(std::uint32_t));
    }
    words_ = std::move(words);
    capacity_ = capacity;
}

void RegionPrograms::begin_frame(std::size_t region_count, bool origins) {
    if (regions_.size() < region_count) {
        regions_.resize(region_count);
    }
    region_count_ = region_count;
    keeps_origins_ = origins;
    for (RegionProgram& region : regions_) {
        region.words.clear();
        region.segments.clear();
        region.origins.clear();
    }
}

void RegionPrograms::begin_slab(std::uint16_t surface, std::uint32_t slab) {
    surface_ = surface;
    slab_ = slab;
    origin_ = {};
}

std::uint32_t* RegionPrograms::append(std::size_t region, std::size_t word_count) {
    assert(region < region_count_);
    RegionProgram& program = regions_[region];
    std::vector<Segment>& segments = program.segments;
    if (segments.empty() || segments.back().slab != slab_ || segments.back().surface != surface_) {
        segments.push_back({surface_, slab_, static_cast<std::uint32_t>(program.words.size()), 0});
    }
    if (keeps_origins_) {
        program.origins.push_back(origin_);
    }
    segments.back().word_count += static_cast<std::uint32_t>(word_count);
    return program.words.append(word_count);
}

}  // namespace pxpl5::gp
