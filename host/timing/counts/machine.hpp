// The modelled machine: every parameter with its unit, where it comes from, and its range.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host::timing {

/// Distribution of a surface's triangles over the GPs.
enum class Sharing : std::uint8_t {
    even,  ///< The display list is spread evenly over the GPs.
    own    ///< Each GP draws the slabs that it extracted.
};

/// Assignment of regions to Renderers.
enum class Assignment : std::uint8_t {
    first_free,     ///< The Master gives the next region to the Renderer that is free first.
    longest_first,  ///< Before the frame, by the regions' costs in the one before.
    round_robin,
    recorded  ///< The run's assignment; needs as many Renderers.
};

/// All numbers of the model. Names, units, ranges and provenance are in parameters().
struct Machine {
    // Counts, which are the topology's.
    std::uint32_t gps = 36, renderers = 16, frame_buffers = 1;
    Sharing share = Sharing::even;
    Assignment assignment = Assignment::first_free;

    double host_link_mb_s = 0, host_message_us = 0;
    double gp_clock_mhz = 0;
    double gp_message_us = 0;             ///< Software, to send or to take one.
    double gp_edge_cycles = 0;            ///< Extraction: an edge that is looked at.
    double gp_build_triangle_cycles = 0;  ///< Extraction: a triangle, its vertices and normals.
    double gp_gradient_cycles = 0;        ///< Loading: a voxel.
    double gp_list_triangle_words = 0;    ///< A triangle handed to another GP's display list.
    double gp_draw_primitive_cycles = 0;  ///< A frame: transform, cull, light, set up.
    double gp_emit_word_cycles = 0;       ///< A frame: a word put into a bin.
    double master_region_cycles = 0;      ///< Cycles to assign one region.
    double ring_channels = 0, ring_channel_mb_s = 0, ring_hop_ns = 0;
    double ring_header_words = 0, ring_message_words = 0;  ///< The longest body.
    double ring_fifo_words = 0;                            ///< Size of a receiving node's FIFO.
    double renderer_clock_mhz = 0;
    double frame_buffer_ports = 0;  ///< Ring nodes of one frame buffer.
    double frame_buffer_refresh_hz = 0;
    double frames_in_flight = 0;
};

struct Parameter {
    std::string_view name;  ///< "gp.edge_cycles": as in files and --set.
    std::string_view unit;
    double Machine::*value;
    double least = 0, most = 0;
    bool whole = false;  ///< Only whole numbers.
};

/// Every number of Machine but the counts, in the order of reports.
std::span<const Parameter> parameters();

/// The machine that a topology describes. A topology without a timing section has that of
/// paper-1993, with its own counts and ring. Throws RequestError (usage) that names a parameter
/// that is missing, unknown, of another unit, or out of range.
Machine machine_of(const Topology& topology);

}  // namespace pxpl5::host::timing
