// Region programs: for each region of the picture, what its stream of instruction words will be.
//
// A frame's streams take megabytes and end up in messages, whose parts must have their sizes from
// the start. So triangles are only counted and named here; write_words() sets them up, straight
// into their place, when all of the frame is known.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/render/growing.hpp"
#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// The words of one slab of one surface within a region's stream.
struct Segment {
    std::uint16_t surface = 0;  ///< Index in the frame's list of surfaces.
    std::uint32_t slab = 0;
    std::uint32_t first_word = 0, word_count = 0;
    friend bool operator==(const Segment&, const Segment&) = default;
};

/// A triangle of a region that is still to be set up.
struct alignas(16) NamedTriangle {
    /// Of RegionPrograms::corners(); of positive determinant.
    std::uint32_t v0, v1, v2;
    std::uint32_t surface_word;
};

/// Words of a region that are there already, in their place among its triangles.
struct RawRun {
    std::size_t triangles_before = 0;
    std::size_t word_count = 0;
};

struct RegionProgram {
    Growing<NamedTriangle> triangles;
    Growing<std::uint32_t> raw_words;  ///< Of all `raws`.
    std::vector<RawRun> raws;
    std::vector<Segment> segments;  ///< In the order in which they were begun.
    Growing<Origin> origins;        ///< Of each primitive, if they are kept.

    std::size_t word_count() const;
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

    /// Nothing follows: segments are complete.
    void end_frame();

    /// The primitives that follow come from here. begin_slab() forgets it.
    void set_origin(const Origin& origin) { origin_ = origin; }

    /// Room for more corners, which the caller fills in. They are numbered from corner_count() on.
    /// Throws std::invalid_argument beyond max_corners.
    GridVertex* add_corners(std::size_t count);
    std::size_t corner_count() const { return corners_.size(); }
    std::span<const GridVertex> corners() const { return corners_.values(); }

    /// One more triangle of `region`, in the slab's segment.
    void add(std::size_t region, const NamedTriangle& triangle) {
        RegionProgram& program = open(region);
        *program.triangles.append(1) = triangle;
    }

    /// Room for `word_count` words of `region`, in the slab's segment: one primitive, which begins
    /// with SETENABS.
    std::uint32_t* append(std::size_t region, std::size_t word_count);

    std::span<const RegionProgram> regions() const { return {regions_.data(), region_count_}; }

  private:
    /// The region's program, in which a primitive of the current slab comes next.
    RegionProgram& open(std::size_t region) {
        RegionProgram& program = regions_[region];
        if (slab_of_[region] != slab_serial_) [[unlikely]] {
            begin_segment(region);
        }
        if (keeps_origins_) {
            *program.origins.append(1) = origin_;
        }
        return program;
    }
    void begin_segment(std::size_t region);

    std::vector<RegionProgram> regions_;
    std::vector<std::uint32_t>
        slab_of_;  ///< Of each region, the serial of its last segment's slab.
    Growing<GridVertex> corners_;
    std::size_t region_count_ = 0;
    std::uint16_t surface_ = 0;
    std::uint32_t slab_ = 0;
    std::uint32_t slab_serial_ = 0;  ///< Counts begin_slab() within the frame.
    Origin origin_;
    bool keeps_origins_ = false;
};

/// Of one frame; a number has 32 bits. No GP's memory holds a mesh of so many.
inline constexpr std::size_t max_corners = std::size_t{1} << 31;

/// Writes a region's stream.
///
/// grid   Of the frame's views, which are all of one size.
/// words  Receives word_count() words.
void write_words(const RegionPrograms& programs, std::size_t region, const RegionGrid& grid,
                 std::uint32_t* words);

}  // namespace pxpl5::gp
