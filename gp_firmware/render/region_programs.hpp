// Region programs: the contents of each region's opcode stream.
//
// The streams of a frame take megabytes. The parts of a message need their sizes from the start, so
// RegionPrograms only lists the triangles. When the frame is complete, write_words() sets them up
// directly in the message.
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

/// A triangle of a region before set-up.
struct alignas(16) NamedTriangle {
    /// Indices into RegionPrograms::corners(). The determinant is positive.
    std::uint32_t v0, v1, v2;
    std::uint32_t surface_word;
};

/// Finished words of a region and their place among its triangles.
struct RawRun {
    std::size_t triangles_before = 0;
    std::size_t word_count = 0;
};

struct RegionProgram {
    Growing<NamedTriangle> triangles;
    Growing<std::uint32_t> raw_words;  ///< The words of all `raws`.
    std::vector<RawRun> raws;
    std::vector<Segment> segments;  ///< In drawing order.
    Growing<Origin> origins;        ///< One per primitive, if origins are kept.

    std::size_t word_count() const;
};

/// The programs of all regions of one frame.
class RegionPrograms {
  public:
    /// Starts a frame with `region_count` empty programs.
    /// origins  Whether each region keeps its primitives' origins.
    void begin_frame(std::size_t region_count, bool origins = false);
    bool keeps_origins() const { return keeps_origins_; }

    /// Starts a slab. A region without words of the slab gets no segment.
    void begin_slab(std::uint16_t surface, std::uint32_t slab);

    /// Completes the segments.
    void end_frame();

    /// Sets the origin of the following primitives. begin_slab() resets it.
    void set_origin(const Origin& origin) { origin_ = origin; }

    /// Appends corners, which the caller writes. Their numbers start at corner_count().
    /// Throws std::invalid_argument beyond max_corners.
    GridVertex* add_corners(std::size_t count);
    std::size_t corner_count() const { return corners_.size(); }
    std::span<const GridVertex> corners() const { return corners_.values(); }

    /// Adds a triangle to the slab's segment of `region`.
    void add(std::size_t region, const NamedTriangle& triangle) {
        RegionProgram& program = open(region);
        *program.triangles.append(1) = triangle;
    }

    /// Appends `word_count` words to the slab's segment of `region`, which the caller writes. They
    /// are one primitive, which begins with SETENABS.
    std::uint32_t* append(std::size_t region, std::size_t word_count);

    std::span<const RegionProgram> regions() const { return {regions_.data(), region_count_}; }

  private:
    /// Returns the region's program, ready for a primitive of the current slab.
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
    std::vector<std::uint32_t> slab_of_;  ///< Serial of the slab of each region's last segment.
    Growing<GridVertex> corners_;
    std::size_t region_count_ = 0;
    std::uint16_t surface_ = 0;
    std::uint32_t slab_ = 0;
    std::uint32_t slab_serial_ = 0;  ///< Number of begin_slab() calls in the frame.
    Origin origin_;
    bool keeps_origins_ = false;
};

/// Limit of a frame, because corner numbers have 32 bits. No GP has memory for so many.
inline constexpr std::size_t max_corners = std::size_t{1} << 31;

/// Writes a region's stream.
///
/// grid   The grid of any view of the frame; all views have one size.
/// words  Receives word_count() words.
void write_words(const RegionPrograms& programs, std::size_t region, const RegionGrid& grid,
                 std::uint32_t* words);

}  // namespace pxpl5::gp
