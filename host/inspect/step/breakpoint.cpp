#include "host/inspect/step/breakpoint.hpp"
#include "isa/contract/region_layout.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

namespace pxpl5::host::inspect {

namespace {

template <typename... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

std::uint64_t z_of(const RegionStepper& at, int x, int y) {
    return at.executor().field(x, y, isa::region::z.address, isa::region::z.width);
}

bool writes(const RegionStepper& at, int x, int y) {
    const isa::OpInfo& row = isa::info(at.walk().next().op);
    return (row.effects & isa::mem) != 0 &&
           ((row.effects & isa::all) != 0 || at.executor().enabled(x, y));
}

bool is_cell(const Primitive& primitive, const renderer::RegionPlan& plan,
             const PrimitiveBreak::Cell& cell) {
    return primitive.origin && primitive.origin->i() == cell.i && primitive.origin->j() == cell.j &&
           plan.parts[primitive.part].segment.slab == cell.k;
}

/// True if the next instruction begins a primitive of that kind.
bool begins(const PrimitiveBreak& wanted, const RegionStepper& at,
            std::span<const Primitive> primitives) {
    const Address address = at.walk().at();
    const Primitive* primitive = primitive_at(primitives, address);
    return primitive != nullptr && primitive->address() == address &&
           (!wanted.number || *wanted.number == primitive->number) &&
           (!wanted.cell || is_cell(*primitive, at.walk().plan(), *wanted.cell));
}

}  // namespace

std::string to_text(const Break& breakpoint) {
    return std::visit(
        Overloaded{[](const OpBreak& b) { return fmt::format("op {}", b.pattern); },
                   [](const AddressBreak& b) {
                       return fmt::format("region {}, part {}+{}", b.region, b.address.part,
                                          b.address.word);
                   },
                   [](const PrimitiveBreak& b) {
                       return b.cell ? fmt::format("cell {},{},{}", b.cell->i, b.cell->j, b.cell->k)
                              : b.number ? fmt::format("primitive {}", *b.number)
                                         : std::string("any primitive");
                   },
                   [](const PartBreak&) { return std::string("any part"); },
                   [](const PixelBreak& b) { return fmt::format("pixel {} {} written", b.x, b.y); },
                   [](const DepthBreak& b) {
                       return fmt::format("z of pixel {} {} falls below {}", b.x, b.y, b.below);
                   },
                   [](const EmptyBreak&) { return std::string("no pixel is enabled any more"); }},
        breakpoint);
}

Watch::Watch(std::span<const Break> breaks, const RecordedFrame& frame,
             const RecordedRegion& region, std::span<const Primitive> primitives)
    : breaks_(breaks), frame_(frame), place_(region.place), primitives_(primitives) {
    for (std::size_t i = 0; i < breaks.size(); ++i) {
        if (const std::optional<Watched> one = watched(i)) {
            watched_.push_back(*one);
        }
    }
}

/// The breakpoint in this region; nothing if it cannot stop here.
std::optional<Watch::Watched> Watch::watched(std::size_t index) const {
    Watched watched{index};
    bool possible = true;
    const auto pixel = [&](int x, int y) {
        watched.x = x - place_.x0_px;
        watched.y = y - place_.y0_px;
        possible = frame_.contains(x, y) && frame_.region_at(x, y).number == place_.number;
    };
    std::visit(Overloaded{[&](const OpBreak& b) {
                              for (std::size_t op = 0; op < isa::op_count; ++op) {
                                  const std::string name(isa::op_table[op].name);
                                  watched.ops[op] =
                                      fnmatch(b.pattern.c_str(), name.c_str(), FNM_CASEFOLD) == 0;
                              }
                          },
                          [&](const AddressBreak& b) { possible = b.region == place_.number; },
                          [&](const PixelBreak& b) { pixel(b.x, b.y); },
                          [&](const DepthBreak& b) { pixel(b.x, b.y); }, [](const auto&) {}},
               breaks_[index]);
    return possible ? std::optional(watched) : std::nullopt;
}

void Watch::before(const RegionStepper& at) {
    any_enabled_ = at.executor().any_enabled();
    for (Watched& w : watched_) {
        const Break& b = breaks_[w.index];
        if (std::holds_alternative<PixelBreak>(b)) {
            w.wrote = writes(at, w.x, w.y);
        } else if (std::holds_alternative<DepthBreak>(b)) {
            w.z = z_of(at, w.x, w.y);
        }
    }
}

bool Watch::holds(const Watched& w, const RegionStepper& at) const {
    const bool is_begin = at.executed() == 0, is_end = at.done();
    return std::visit(
        Overloaded{[&](const OpBreak&) {
                       return !is_end && w.ops[static_cast<std::size_t>(at.walk().next().op)];
                   },
                   [&](const AddressBreak& b) { return !is_end && at.walk().at() == b.address; },
                   [&](const PrimitiveBreak& b) { return !is_end && begins(b, at, primitives_); },
                   [&](const PartBreak&) { return !is_end && at.walk().is_part_begin(); },
                   [&](const PixelBreak&) { return !is_begin && w.wrote; },
                   [&](const DepthBreak& b) {
                       return !is_begin && w.z >= b.below && z_of(at, w.x, w.y) < b.below;
                   },
                   [&](const EmptyBreak&) {
                       return !is_begin && any_enabled_ && !at.executor().any_enabled();
                   }},
        breaks_[w.index]);
}

std::optional<std::size_t> Watch::after(const RegionStepper& at) const {
    for (const Watched& w : watched_) {
        if (holds(w, at)) {
            return w.index;
        }
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
