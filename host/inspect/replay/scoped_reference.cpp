#include "host/inspect/replay/scoped_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "host/base/error.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "isa/program.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace shape = isa::triangle;
using isa::reference::Window;

constexpr int last_px = region_px - 1;

/// A x + B y + C, of which one bit is tested.
struct Edge {
    std::int64_t a = 0, b = 0, c = 0;

    /// The greatest value on a box: a plane has it in a corner.
    std::int64_t greatest(int x0, int y0, int x1, int y1) const {
        return a * (a > 0 ? x1 : x0) + b * (b > 0 ? y1 : y0) + c;
    }
};

/// The edge whose instruction is at `word`. One that can leave its n bits in the region, where
/// bit n-1 is not the sign, bounds nothing: 0 everywhere.
Edge edge_at(const std::uint32_t* word) {
    const auto coefficient = [&](int k) {
        return std::int64_t{static_cast<std::int32_t>(word[k])};
    };
    const Edge edge{coefficient(1), coefficient(2), coefficient(3)};
    const std::uint32_t n = isa::decode(word[0])->operands.n;
    const std::int64_t most = (std::abs(edge.a) + std::abs(edge.b)) * last_px + std::abs(edge.c);
    return most < std::int64_t{1} << (n - 1) ? edge : Edge{};
}

/// Grows a box by the pixels at which no edge is negative.
struct BoxFinder {
    std::array<Edge, 3> edges;
    int x0 = last_px + 1, y0 = last_px + 1, x1 = -1, y1 = -1;

    void add(int left, int top, int size) {
        const int right = left + size - 1, bottom = top + size - 1;
        if (left >= x0 && right <= x1 && top >= y0 && bottom <= y1) {
            return;  // Nothing in here makes the box larger.
        }
        for (const Edge& edge : edges) {
            if (edge.greatest(left, top, right, bottom) < 0) {
                return;
            }
        }
        if (size == 1) {
            x0 = std::min(x0, left);
            x1 = std::max(x1, left);
            y0 = std::min(y0, top);
            y1 = std::max(y1, top);
            return;
        }
        const int half = size / 2;
        add(left, top, half);
        add(left + half, top, half);
        add(left, top + half, half);
        add(left + half, top + half, half);
    }
};

}  // namespace

Window triangle_box(const std::uint32_t* words) {
    BoxFinder finder{{edge_at(words + shape::at_edge[0]), edge_at(words + shape::at_edge[1]),
                      edge_at(words + shape::at_edge[2])}};
    finder.add(0, 0, region_px);
    if (finder.x1 < finder.x0) {
        return {0, 0, 0, 0};
    }
    return {finder.x0, finder.y0, finder.x1 - finder.x0 + 1, finder.y1 - finder.y0 + 1};
}

ScopedReference::ScopedReference(std::uint64_t most_work) : most_work_(most_work) {
    reference_.set_readout([this](std::span<const std::uint32_t> words) { read_out(words); });
}

void ScopedReference::restore(const State& state) {
    reference_.restore(state.pixels);
    enabled_ = state.enabled;
    work_ = state.work;
}

void ScopedReference::run(isa::Instruction in, isa::Coefficients coefficients,
                          const Window& scope) {
    work_ += std::uint64_t{isa::info(in.op).cycles(in.operands)} *
             static_cast<std::uint64_t>(scope.width) * static_cast<std::uint64_t>(scope.height);
    if (work_ > most_work_) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("the reference executor has needed {} cycles of pixels for a region; "
                        "the limit is {}. The recorded programs may be crafted. To execute them "
                        "nevertheless, choose --executor fast",
                        work_, most_work_));
    }
    reference_.execute(in, coefficients);
}

void ScopedReference::execute(isa::Instruction in, isa::Coefficients coefficients) {
    enabled_ = {};
    run(in, coefficients, {});
}

isa::Taken ScopedReference::execute_ahead(std::span<const std::uint32_t> words) {
    isa::Taken taken;
    while (taken.words + shape::word_count <= words.size() &&
           shape::matches(words.data() + taken.words)) {
        run_triangle(words.data() + taken.words, taken);
    }
    reference_.set_scope({});
    return taken;
}

void ScopedReference::run_triangle(const std::uint32_t* words, isa::Taken& taken) {
    reference_.set_scope(enabled_);
    run({isa::Op::clr_enabs, {}}, {}, enabled_);
    enabled_ = triangle_box(words);
    reference_.set_scope(enabled_);
    for (std::size_t at = 0; at < shape::word_count;) {
        const isa::Instruction in = *isa::decode(words[at]);
        const auto count = static_cast<std::size_t>(isa::info(in.op).words);
        // int32_t is the signed type of uint32_t, so that reading one as the other is defined.
        run(in, {reinterpret_cast<const std::int32_t*>(words + at + 1), count}, enabled_);
        taken.cycles += isa::info(in.op).cycles(in.operands);
        at += 1 + count;
    }
    taken.words += shape::word_count;
    taken.instructions += shape::instruction_count;
}

}  // namespace pxpl5::host::inspect
