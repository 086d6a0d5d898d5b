#include "host/inspect/diff/stream_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "host/inspect/record/recorded_results.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

using Part = renderer::RegionPlan::Part;
using Kind = renderer::RegionPlan::Kind;

std::string stream_name(const Part& part) {
    switch (part.kind) {
        case Kind::prologue:
            return "prologue";
        case Kind::shut_door:
            return fmt::format("the door of surface {}, which shuts", part.segment.surface);
        case Kind::open_door:
            return fmt::format("the door of surface {}, which opens", part.segment.surface);
        case Kind::depths:
            return "program of depths";
        case Kind::end_of_region:
            return "end-of-region program";
        case Kind::segment:
            break;
    }
    return fmt::format("surface {}, slab {}", part.segment.surface, part.segment.slab);
}

/// Of the parts of a region, as they run: a surface's own lie together.
auto order(const Part& part) {
    const bool is_of_surface =
        part.kind == Kind::shut_door || part.kind == Kind::segment || part.kind == Kind::open_door;
    return std::make_tuple(is_of_surface ? Kind::segment : part.kind, part.segment.surface,
                           part.kind, part.segment.slab);
}

std::string instruction_at(renderer::Words words, std::size_t word) {
    if (word >= words.size()) {
        return "the stream's end";
    }
    const std::size_t count = isa::instruction_words(words[word]);
    const std::string text = isa::disassemble(words.subspan(word, count));
    const std::size_t first = text.find_first_not_of(' ');
    return text.substr(first, text.find_last_not_of(" \n") + 1 - first);
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
    const std::string text_a = instruction_at(in_a.segment.words, word),
                      text_b = instruction_at(in_b.segment.words, word);
    Difference d;
    d.level = "instruction";
    d.frame = frame.number;
    d.region = a.place.number;
    const std::string region = region_name(frame, a.place.number);
    d.text = fmt::format(
        "frame {}, {}, {}: programs differ at word {}\n  in A (gp-{})  {}\n  in B (gp-{})  {}",
        frame.number, region, stream_name(in_a), word, in_a.segment.gp, text_a, in_b.segment.gp,
        text_b);
    d.fields = {{"level", d.level},
                {"frame", std::int64_t{frame.number}},
                {"region", std::int64_t{a.place.number}},
                {"stream", stream_name(in_a)},
                {"word", static_cast<std::int64_t>(word)},
                {"a", text_a},
                {"b", text_b}};
    const auto add = [&](const char* run, const RecordedFrame& f, const RecordedRegion& r,
                         std::size_t part) {
        const std::vector<Primitive> primitives = primitives_of(f, r);
        const Primitive* primitive = primitive_at(primitives, {part, word});
        const std::string origin =
            primitive == nullptr ? "" : origin_text(*primitive, in_a.segment.slab);
        if (!origin.empty()) {
            d.text += fmt::format("\n  in {} it is of {}", run, origin);
            d.fields.push_back({std::string("origin in ") + run, origin});
        }
    };
    add("A", frame, a, part_a);
    add("B", frame_b, b, part_b);
    return d;
}

}  // namespace

Difference message_difference(std::uint32_t frame, const std::string& text, const Fields& fields) {
    Difference difference{"message", text, {{"level", std::string("message")}}, frame, {}};
    difference.fields.insert(difference.fields.end(), fields.begin(), fields.end());
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
            return message_difference(
                frame_a.number,
                fmt::format("frame {}, {}: only {} has a program of {} (gp-{}, {} words)",
                            frame_a.number, region_name(frame_a, a.place.number),
                            only_a ? "A" : "B", stream_name(part), part.segment.gp,
                            part.segment.words.size()),
                {{"region", std::int64_t{a.place.number}}, {"stream", stream_name(part)}});
        }
        if (!std::ranges::equal(in_a[i].segment.words, in_b[i].segment.words)) {
            return stream_difference(frame_a, a, i, frame_b, b, i);
        }
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
