#include "host/inspect/listing/region_listing.hpp"

#include <fmt/format.h>

#include "host/base/answer.hpp"
#include "host/inspect/listing/enabled_pixels.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "host/inspect/replay/executors.hpp"
#include "isa/disassemble.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

namespace {

using Kind = PartKind;

constexpr const char* no_part = "";

/// "120 -> 16384"; one number if nothing changed.
std::string change(std::size_t before, std::size_t after) {
    return before == after ? fmt::format("{:>5}         ", before)
                           : fmt::format("{:>5} -> {:>5}", before, after);
}

class Lister {
  public:
    Lister(const RecordedFrame& frame, const RecordedRegion& region, const RegionListing& options,
           TextOutput& output)
        : options_(options),
          plan_(region.plan),
          primitives_(primitives_of(frame, region)),
          walk_(region.plan, executor_),
          place_(region.place),
          output_(output) {
        prepare(region, executor_);
    }

    ListedLines run() {
        while (!walk_.done()) {
            const Address at = walk_.at();
            if (!has_part(options_.selection, plan_.parts[at.part])) {
                walk_.run_part();
            } else if (!options_.selection.has_op(walk_.next().op)) {
                walk_.step();
            } else if (lines_.listed == options_.max_lines) {
                walk_.step();
                ++lines_.left_out;
            } else {
                list(at);
            }
        }
        return lines_;
    }

  private:
    void headings(Address at) {
        if (at.part != part_) {
            part_ = at.part;
            output_.put(part_heading(plan_.parts[at.part]));
        }
        const Primitive* primitive = primitive_at(primitives_, at);
        if (primitive != nullptr && primitive != primitive_) {
            output_.put(primitive_heading(*primitive, plan_));
        }
        primitive_ = primitive;
    }

    /// The pixel whose values the instruction's line shows.
    std::optional<RegionPixel> shown_pixel(isa::Instruction in) const {
        if (options_.pixel) {
            return options_.pixel;
        }
        const std::uint16_t effects = isa::info(in.op).effects;
        if ((effects & isa::mem) == 0) {
            return std::nullopt;
        }
        return (effects & isa::all) != 0 ? RegionPixel{} : first_enabled(executor_.pixels());
    }

    std::string place_text(RegionPixel pixel) const {
        return options_.pixel
                   ? no_part
                   : fmt::format("({}, {}) ", pixel.x + place_.x0_px, pixel.y + place_.y0_px);
    }

    void list(Address at) {
        headings(at);
        const isa::Instruction in = walk_.next();
        const std::string text = isa::disassemble(in, walk_.coefficients());
        const std::uint32_t word = plan_.parts[at.part].segment.words[at.word];
        const std::size_t before = enabled_count(executor_.pixels());
        const std::optional<RegionPixel> pixel = shown_pixel(in);
        std::optional<InstructionValues> values;
        if (pixel) {
            values.emplace(in, walk_.coefficients(), *pixel, executor_);
        }
        walk_.step();
        std::string value = values ? values->text(executor_) : "";
        value = value.empty() ? value : place_text(*pixel) + value;
        if (in.op == isa::Op::any_enab) {
            value = fmt::format("flag = {}", walk_.save().flag ? 1 : 0);
        }
        output_.line(fmt::format("{:>7}  {:08x}  {:>6}  {}  {:<40}  {}", at.word, word,
                                 isa::info(in.op).cycles(in.operands),
                                 change(before, enabled_count(executor_.pixels())), value, text));
        ++lines_.listed;
    }

    const RegionListing& options_;
    const renderer::RegionPlan& plan_;
    std::vector<Primitive> primitives_;
    renderer::fast::Fast executor_;
    RegionWalk walk_;
    const RegionPlace& place_;
    TextOutput& output_;
    std::optional<std::size_t> part_;
    const Primitive* primitive_ = nullptr;
    ListedLines lines_;
};

}  // namespace

bool has_part(const Selection& selection, const renderer::RegionPlan::Part& part) {
    const renderer::Segment& s = part.segment;
    return selection.has_part(part.kind == Kind::segment, s.gp, s.surface, s.slab);
}

std::string part_heading(const renderer::RegionPlan::Part& part) {
    const renderer::Segment& s = part.segment;
    switch (part.kind) {
        case Kind::prologue:
            return fmt::format("\n; prologue: {} words\n", grouped(s.words.size()));
        case Kind::shut_door:
            return fmt::format("\n; surface {} is transparent, its screen door shuts: {} words\n",
                               s.surface, grouped(s.words.size()));
        case Kind::open_door:
            return fmt::format("\n; the screen door of surface {} opens again: {} words\n",
                               s.surface, grouped(s.words.size()));
        case Kind::depths:
            return fmt::format("\n; depths: {} words\n", grouped(s.words.size()));
        case Kind::end_of_region:
            return fmt::format("\n; end of region: {} words\n", grouped(s.words.size()));
        case Kind::segment:
            break;
    }
    return fmt::format("\n; gp-{}, surface {}, slab {}: {} words, from word {} of its stream\n",
                       s.gp, s.surface, s.slab, grouped(s.words.size()), s.first_word);
}

std::string primitive_heading(const Primitive& primitive, const renderer::RegionPlan& plan) {
    std::string text = fmt::format("; primitive {}", primitive.number);
    if (primitive.origin) {
        const bus::schema::Origin& from = *primitive.origin;
        text +=
            fmt::format(": cell ({}, {}, {}), case 0x{:02x}, triangle {}", from.i(), from.j(),
                        plan.parts[primitive.part].segment.slab, from.inside(), from.triangle());
        text += from.joined() == 0 ? "" : fmt::format(", faces joined 0x{:02x}", from.joined());
        text += from.piece() == 0 ? "" : fmt::format(", piece {} of the clipped", from.piece());
    }
    return text + "\n";
}

std::string listing_legend(bool pixel_is_chosen) {
    std::string text =
        "; word     place in its part's words; raw: the instruction word; cycles: modelled, 40 "
        "MHz\n"
        "; enabled  pixels of the region (of 16384) that are enabled, before -> after\n";
    text += pixel_is_chosen
                ? "; value    at the chosen pixel: the field before -> after; or what a test "
                  "compared: Q, "
                  "the tree's\n;          value, or T, its low bits without the fraction\n"
                : "; value    of the field written, before -> after, at the first pixel that was "
                  "enabled\n";
    return text + "; primitive: from one SETENABS to the next; its voxel cell is (i, j, k)\n";
}

ListedLines list_region(const RecordedFrame& frame, const RecordedRegion& region,
                        const RegionListing& options, TextOutput& output) {
    output.line(
        fmt::format("\n; frame {}, region {} (column {}, row {}{}), pixels from ({}, {}), "
                    "renderer-{}",
                    frame.number, region.place.number, region.place.column, region.place.row,
                    region.place.view == 0 ? "" : ", second view", region.place.x0_px,
                    region.place.y0_px, region.renderer));
    for (const renderer::SegmentFault& fault : region.plan.faults) {
        output.line(fmt::format("; left out: gp-{}, surface {}, slab {}: {}", fault.gp,
                                fault.surface, fault.slab, fault.reason));
    }
    output.line(fmt::format("{:>7}  {:<8}  {:>6}  {:<14}  {:<40}  {}", ";  word", "raw", "cycles",
                            "enabled", "value", "instruction"));
    return Lister(frame, region, options, output).run();
}

}  // namespace pxpl5::host::inspect
