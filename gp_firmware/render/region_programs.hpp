// Region programs: for each region of the picture, a growing stream of instruction words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// The words of one slab of one surface within a region's stream.
struct Segment {
    std::uint16_t surface = 0;  ///< Index in the frame's list of surfaces.
    std::uint32_t slab = 0;
    std::uint32_t first_word = 0, word_count = 0;
    friend bool operator==(const Segment&, const Segment&) = default;
};

/// Words that grow without being cleared first, and keep their room from frame to frame.
class WordBuffer {
  public:
    /// Room for `count` more words; the caller writes all of them.
    std::uint32_t* append(std::size_t count) {
        if (capacity_ - size_ < count) {
            grow(count);
        }
        std::uint32_t* words = words_.get() + size_;
        size_ += count;
        return words;
    }
    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    std::span<const std::uint32_t> words() const { return {words_.get(), size_}; }

  private:
    void grow(std::size_t count);

    std::unique_ptr<std::uint32_t[]> words_;
    std::size_t size_ = 0, capacity_ = 0;
};

struct RegionProgram {
    WordBuffer words;
    std::vector<Segment> segments;  ///< In the order in which they were begun.
    std::vector<Origin> origins;    ///< Of each primitive, if they are kept.
};

/// The programs of all regions of one frame.
class RegionPrograms {
  public:
    /// Empties all programs and makes `region_count` of them.
    /// origins  Whether each region keeps its primitives' origins.
    void begin_frame(std::size_t region_count, bool origins = false);
    bool keeps_origins() const { return keeps_origins_; }

    /// What follows belongs to this slab. Segments of regions that get no word are not made.
    void begin_slab(std::uint16_t surface, std::uint32_t slab);

    /// The primitives that follow come from here. begin_slab() forgets it.
    void set_origin(const Origin& origin) { origin_ = origin; }

    /// Room for `word_count` words of `region`, in the slab's segment: one primitive, which begins
    /// with SETENABS.
    std::uint32_t* append(std::size_t region, std::size_t word_count);

    std::span<const RegionProgram> regions() const { return {regions_.data(), region_count_}; }

  private:
    std::vector<RegionProgram> regions_;
    std::size_t region_count_ = 0;
    std::uint16_t surface_ = 0;
    std::uint32_t slab_ = 0;
    Origin origin_;
    bool keeps_origins_ = false;
};

}  // namespace pxpl5::gp
