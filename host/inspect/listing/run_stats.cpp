#include "host/inspect/listing/run_stats.hpp"

#include <fmt/format.h>

#include <memory>

#include "host/inspect/record/recorded_results.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "host/inspect/record/selected_messages.hpp"
#include "isa/instruction_counts.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "ringbus/channel_model.hpp"

namespace pxpl5::host::inspect {

namespace {

using Kind = PartKind;

std::size_t index_of(isa::Op op) {
    return static_cast<std::size_t>(op);
}

/// Words on the modelled ring: the header and whole words of the body.
std::uint64_t ring_words(std::uint64_t body_bytes) {
    constexpr bus::RingParameters ring;
    return ring.header_words + (body_bytes + ring.word_bytes - 1) / ring.word_bytes;
}

void count_once(PartCounts& part, isa::Instruction in) {
    OpCount& count = part.ops[index_of(in.op)];
    ++count.instructions;
    count.cycles += isa::info(in.op).cycles(in.operands);
}

void count_text(PartCounts& part, renderer::Words words, bool as_executed) {
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        const isa::Instruction in = *isa::decode(words[at]);
        part.ops[index_of(in.op)].words += isa::instruction_words(words[at]);
        if (as_executed) {
            count_once(part, in);
        }
    }
}

PartCounts counts_of(const RecordedFrame& frame, const RecordedRegion& region,
                     const renderer::RegionPlan::Part& part) {
    const renderer::Segment& s = part.segment;
    return {frame.number,
            region.place.number,
            region.renderer,
            part.kind,
            s.gp,
            s.surface,
            s.slab,
            0,
            {}};
}

/// Compares the counts with the counts that the Renderer reported.
void compare(const RecordedFrame& frame, std::uint32_t region, std::span<const PartCounts> parts,
             RunStats& stats) {
    ++stats.regions;
    const std::optional<RecordedTile> tile = tile_of(frame, region);
    if (!tile) {
        return;
    }
    ++stats.told;
    OpCount sum;
    for (const PartCounts& part : parts) {
        sum += part.total();
    }
    if (sum.instructions != tile->counts.instructions || sum.cycles != tile->counts.cycles) {
        stats.differences.push_back(fmt::format(
            "frame {}, region {}: counted {} instructions and {} cycles, but the Renderer reported "
            "{} and {}",
            frame.number, region, sum.instructions, sum.cycles, tile->counts.instructions,
            tile->counts.cycles));
    }
}

void keep_selected(const Selection& selection, std::vector<PartCounts> parts, RunStats& stats) {
    for (PartCounts& part : parts) {
        if (!selection.has_part(part.is_segment(), part.gp, part.surface, part.slab)) {
            continue;
        }
        for (std::size_t op = 0; op < isa::op_count && !selection.ops.empty(); ++op) {
            if (!selection.has_op(static_cast<isa::Op>(op))) {
                part.ops[op] = {};
            }
        }
        stats.parts.push_back(part);
    }
}

}  // namespace

OpCount& OpCount::operator+=(const OpCount& other) {
    instructions += other.instructions;
    cycles += other.cycles;
    words += other.words;
    return *this;
}

MessageCount& MessageCount::operator+=(const MessageCount& other) {
    messages += other.messages;
    bytes += other.bytes;
    words += other.words;
    return *this;
}

OpCount PartCounts::total() const {
    OpCount sum;
    for (const OpCount& count : ops) {
        sum += count;
    }
    return sum;
}

std::vector<PartCounts> count_region(const RecordedFrame& frame, const RecordedRegion& region) {
    std::vector<PartCounts> parts;
    const auto executor = std::make_unique<renderer::fast::Fast>();
    RegionWalk walk(region.plan, *executor);
    for (const renderer::RegionPlan::Part& part : region.plan.parts) {
        PartCounts& counts = parts.emplace_back(counts_of(frame, region, part));
        const bool straight = isa::runs_straight(part.segment.words);
        count_text(counts, part.segment.words, straight);
        const std::size_t at = parts.size() - 1;
        while (!walk.done() && walk.at().part == at) {
            if (straight) {
                walk.run_part();
            } else {
                count_once(counts, walk.next());
                walk.step();
            }
        }
    }
    for (const Primitive& primitive : primitives_of(frame, region)) {
        ++parts[primitive.part].primitives;
    }
    return parts;
}

RunStats stats_of(const RecordedRun& run, const Selection& selection) {
    RunStats stats;
    for (const std::uint32_t number : run.frames()) {
        if (!selection.has_frame(number)) {
            continue;
        }
        const RecordedFrame frame = run.frame(number);
        for (const RecordedRegion* region : selected_regions(frame, selection)) {
            std::vector<PartCounts> parts = count_region(frame, *region);
            compare(frame, region->place.number, parts, stats);
            keep_selected(selection, std::move(parts), stats);
        }
        for (const std::string& reason : frame.missing) {
            stats.missing.push_back(fmt::format("frame {}: {}", number, reason));
        }
    }
    for (const MessageRef& message : select_messages(run, selection)) {
        const bus::schema::Header& header = message.header();
        stats.messages[{message.at().kind(), header.source(), header.destination(),
                        header.channel()}] +=
            {1, header.body_bytes(), ring_words(header.body_bytes())};
    }
    return stats;
}

}  // namespace pxpl5::host::inspect
