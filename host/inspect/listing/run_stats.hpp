// Counts of a recorded run: what Renderers executed, and what travelled.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct OpCount {
    std::uint64_t instructions = 0;  ///< Executed.
    std::uint64_t cycles = 0;        ///< Modelled, 40 MHz.
    std::uint64_t words = 0;         ///< In the stream: a loop's body counts once.
    OpCount& operator+=(const OpCount& other);
    friend bool operator==(const OpCount&, const OpCount&) = default;
};

/// Counts of one part of a region's programs.
struct PartCounts {
    std::uint32_t frame = 0, region = 0, renderer = 0;
    PartKind kind{};
    std::uint32_t gp = 0, surface = 0, slab = 0;  ///< Valid for a segment.
    std::uint64_t primitives = 0;
    std::array<OpCount, isa::op_count> ops{};

    bool is_segment() const { return kind == PartKind::segment; }
    OpCount total() const;
};

/// Counts every part of a region, in order. Executes parts whose flow depends on pixels.
std::vector<PartCounts> count_region(const RecordedFrame& frame, const RecordedRegion& region);

struct MessageCount {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;  ///< Size of the bodies.
    std::uint64_t words = 0;  ///< On the ring, its headers included (ringbus/channel_model.hpp).
    MessageCount& operator+=(const MessageCount& other);
};

/// Messages of one kind that went one way, over one channel of the modelled ring.
struct MessageWay {
    bus::Body kind{};
    bus::NodeId source = 0, destination = 0;
    std::uint16_t channel = 0;
    auto operator<=>(const MessageWay&) const = default;
};
using MessageCounts = std::map<MessageWay, MessageCount>;

struct RunStats {
    std::vector<PartCounts> parts;
    MessageCounts messages;
    std::uint64_t regions = 0, told = 0;   ///< told: regions with counts of their Renderer.
    std::vector<std::string> differences;  ///< From the counts of Renderers, a sentence each.
    std::vector<std::string> missing;      ///< Reasons for missing counts, a sentence each.
};

/// Counts what is selected: frames, regions, Renderers; GPs, surfaces and slabs leave out the other
/// segments, and then prologue and end of region too; instructions and kinds of message.
RunStats stats_of(const RecordedRun& run, const Selection& selection);

}  // namespace pxpl5::host::inspect
