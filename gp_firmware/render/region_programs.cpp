#include "gp_firmware/render/region_programs.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cstring>
#include <stdexcept>

#include "gp_firmware/render/set_up_triangles.hpp"
#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::gp {

namespace shape = isa::triangle;

std::size_t RegionProgram::word_count() const {
    return triangles.size() * shape::word_count + raw_words.size();
}

void RegionPrograms::begin_frame(std::size_t region_count, bool origins) {
    if (regions_.size() < region_count) {
        regions_.resize(region_count);
    }
    region_count_ = region_count;
    keeps_origins_ = origins;
    for (RegionProgram& region : regions_) {
        region.triangles.clear();
        region.raw_words.clear();
        region.raws.clear();
        region.segments.clear();
        region.origins.clear();
    }
    corners_.clear();
    slab_serial_ = 0;
    slab_of_.assign(region_count, 0);
}

void RegionPrograms::begin_slab(std::uint16_t surface, std::uint32_t slab) {
    surface_ = surface;
    slab_ = slab;
    ++slab_serial_;
    origin_ = {};
}

void RegionPrograms::begin_segment(std::size_t region) {
    assert(region < region_count_);
    RegionProgram& program = regions_[region];
    const auto first_word = static_cast<std::uint32_t>(program.word_count());
    if (!program.segments.empty()) {
        Segment& before = program.segments.back();
        before.word_count = first_word - before.first_word;
    }
    slab_of_[region] = slab_serial_;
    program.segments.push_back({surface_, slab_, first_word, 0});
}

void RegionPrograms::end_frame() {
    for (std::size_t region = 0; region < region_count_; ++region) {
        RegionProgram& program = regions_[region];
        if (!program.segments.empty()) {
            Segment& last = program.segments.back();
            last.word_count = static_cast<std::uint32_t>(program.word_count()) - last.first_word;
        }
    }
}

GridVertex* RegionPrograms::add_corners(std::size_t count) {
    if (count > max_corners - corners_.size()) {
        throw std::invalid_argument(fmt::format("{} and {} corners in one frame; {} at most",
                                                corners_.size(), count, max_corners));
    }
    return corners_.append(count);
}

std::uint32_t* RegionPrograms::append(std::size_t region, std::size_t word_count) {
    RegionProgram& program = open(region);
    if (program.raws.empty() || program.raws.back().triangles_before != program.triangles.size()) {
        program.raws.push_back({program.triangles.size(), 0});
    }
    program.raws.back().word_count += word_count;
    return program.raw_words.append(word_count);
}

void write_words(const RegionPrograms& programs, std::size_t region, const RegionGrid& grid,
                 std::uint32_t* words) {
    const RegionProgram& program = programs.regions()[region];
    const int in_view = static_cast<int>(region) % grid.count();
    const RegionPlace place{in_view % grid.columns * region_px, in_view / grid.columns * region_px};
    std::size_t done = 0;
    const auto set_up_until = [&](std::size_t end) {
        set_up_triangles(program.triangles.values().subspan(done, end - done), programs.corners(),
                         place, words);
        words += (end - done) * shape::word_count;
        done = end;
    };
    const std::uint32_t* raw = program.raw_words.data();
    for (const RawRun& run : program.raws) {
        set_up_until(run.triangles_before);
        std::memcpy(words, raw, run.word_count * sizeof(std::uint32_t));
        words += run.word_count;
        raw += run.word_count;
    }
    set_up_until(program.triangles.size());
}

}  // namespace pxpl5::gp
