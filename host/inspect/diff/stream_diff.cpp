#include "host/inspect/diff/stream_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "host/inspect/record/recorded_results.hpp"

namespace pxpl5::host::inspect {

namespace {

using Part = renderer::RegionPlan::Part;
using Kind = PartKind;

std::string stream_name(const Part& part) {
    switch (part.kind) {
        case Kind::shut_door:
            return fmt::format("program that shuts the door of surface {}", part.segment.surface);
        case Kind::open_door:
            return fmt::format("program that opens the door of surface {}", part.segment.surface);
        case Kind::depths:
            return "depth program";
        case Kind::end_of_region:
            return "end-of-region program";
        case Kind::prologue:
            return "prologue";
        case Kind::segment:
            break;
    }
    return fmt::format("surface {}, slab {}", part.segment.surface, part.segment.slab);
}

/// The order in which parts run: the parts of one surface follow each other.
auto order(const Part& part) {
    const bool is_of_surface =
        part.kind == Kind::shut_door || part.kind == Kind::segment || part.kind == Kind::open_door;
    return std::make_tuple(is_of_surface ? Kind::segment : part.kind, part.segment.surface,
                           part.kind, part.segment.slab);
}

/// Word of the instruction that holds the first differing word.
std::size_t differing_instruction(renderer::Words a, renderer::Words b) {
    const std::size_t word = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
    std::size_t at = 0;
    while (at < word && at + isa::instruction_words(a[at]) <= word) {
        at += isa::instruction_words(a[at]);
    }
    return at;
}

Difference stream_difference(const RecordedFrame& frame, const RecordedRegion& a,
                             std::size_t part_a, const RecordedFrame& frame_b,
                             const RecordedRegion& b, std::size_t part_b) {
    const Part &in_a = a.plan.parts[part_a], &in_b = b.plan.parts[part_b];
    const std::size_t word = differing_instruction(in_a.segment.words, in_b.segment.words);
    const std::string text_a = instruction_text(in_a.segment.words, word),
                      text_b = instruction_text(in_b.segment.words, word);
    Difference d{"instruction", {}, frame.number, a.place.number};
    d.answer
        .line(fmt::format("frame {}, {}, {}: programs differ at word {}", frame.number,
                          region_name(frame, a.place.number), stream_name(in_a), word))
        .line(fmt::format("  in A (gp-{})  {}", in_a.segment.gp, text_a))
        .line(fmt::format("  in B (gp-{})  {}", in_b.segment.gp, text_b))
        .data("level", d.level)
        .data("frame", frame.number)
        .data("region", a.place.number)
        .data("stream", stream_name(in_a))
        .data("word", word)
        .data("a", text_a)
        .data("b", text_b);
    const auto add = [&](const std::string& run, const RecordedFrame& f, const RecordedRegion& r,
                         std::size_t part) {
        const std::vector<Primitive> primitives = primitives_of(f, r);
        const Primitive* primitive = primitive_at(primitives, {part, word});
        const std::string provenance =
            primitive == nullptr ? "" : provenance_text(*primitive, in_a.segment.slab);
        if (!provenance.empty()) {
            d.answer.line(fmt::format("  in {} the instruction belongs to {}", run, provenance))
                .data("provenance in " + run, provenance);
        }
    };
    add("A", frame, a, part_a);
    add("B", frame_b, b, part_b);
    return d;
}

}  // namespace

Difference message_difference(std::uint32_t frame, const std::string& text) {
    Difference difference{"message", {}, frame, {}};
    difference.answer.line(text).data("level", difference.level);
    return difference;
}

std::optional<Difference> compare_streams(const RecordedFrame& frame_a, const RecordedRegion& a,
                                          const RecordedFrame& frame_b, const RecordedRegion& b) {
    const auto &in_a = a.plan.parts, &in_b = b.plan.parts;
    for (std::size_t i = 0; i < std::max(in_a.size(), in_b.size()); ++i) {
        if (i >= in_a.size() || i >= in_b.size() || order(in_a[i]) != order(in_b[i])) {
            const bool only_a =
                i >= in_b.size() || (i < in_a.size() && order(in_a[i]) < order(in_b[i]));
            const Part& part = only_a ? in_a[i] : in_b[i];
            Difference difference = message_difference(
                frame_a.number,
                fmt::format("frame {}, {}: only {} has this program: {} (gp-{}, {} words)",
                            frame_a.number, region_name(frame_a, a.place.number),
                            only_a ? "A" : "B", stream_name(part), part.segment.gp,
                            part.segment.words.size()));
            difference.answer.data("region", a.place.number).data("stream", stream_name(part));
            return difference;
        }
        if (!std::ranges::equal(in_a[i].segment.words, in_b[i].segment.words)) {
            return stream_difference(frame_a, a, i, frame_b, b, i);
        }
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
