// Selects a part of a run. All inspection commands share the syntax.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "isa/instruction.hpp"

namespace pxpl5::host::inspect {

/// Numbers from..to, both included.
struct Range {
    std::uint32_t from = 0, to = 0;
    bool contains(std::uint32_t n) const { return n >= from && n <= to; }
};

/// Given texts: --frame 3-5 --region 2,1 --gp 7 --renderer 0 --surface 1 --slab 10-12 --op 'TREE*'.
/// An empty option selects all; several ranges are separated by blanks or repeated options.
struct SelectionText {
    std::vector<std::string> frame, region, gp, renderer, surface, slab, op, kind;
};

/// A selection that can be asked.
struct Selection {
    /// One region, by its number or by column and row, of any view.
    struct Region {
        std::optional<std::uint32_t> number;
        int column = 0, row = 0;
    };
    std::vector<Range> frames, gps, renderers, surfaces, slabs;
    std::vector<Region> regions;
    std::vector<std::string> ops;    ///< Patterns with * and ? on an instruction's name.
    std::vector<std::string> kinds;  ///< Patterns on a message's kind, e.g. Region*.

    bool has_frame(std::uint32_t n) const { return has(frames, n); }
    bool has_gp(std::uint32_t n) const { return has(gps, n); }
    bool has_renderer(std::uint32_t n) const { return has(renderers, n); }
    bool has_surface(std::uint32_t n) const { return has(surfaces, n); }
    bool has_slab(std::uint32_t n) const { return has(slabs, n); }
    bool has_region(std::uint32_t number, int column, int row) const;
    /// True if a part of a region is selected: a segment by its GP, surface and slab; any other
    /// part if the selection names none of the three.
    bool has_part(bool is_segment, std::uint32_t gp, std::uint32_t surface,
                  std::uint32_t slab) const {
        return is_segment ? has_gp(gp) && has_surface(surface) && has_slab(slab)
                          : gps.empty() && surfaces.empty() && slabs.empty();
    }
    bool has_op(isa::Op op) const;
    bool has_kind(std::string_view kind) const;

  private:
    static bool has(const std::vector<Range>& ranges, std::uint32_t n);
};

/// Throws RequestError (usage) naming option, text and what is expected.
Selection parse_selection(const SelectionText& text);

}  // namespace pxpl5::host::inspect
