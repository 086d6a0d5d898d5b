#include "host/inspect/why/pixel_history.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/inspect/listing/instruction_values.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "isa/contract/screen_door.hpp"
#include "isa/disassemble.hpp"
#include "isa/reference/reference.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace layout = isa::region;
using Kind = PartKind;

/// Each store takes some hundred bytes. A pixel of a drawn frame has a few thousand at most, but a
/// loop in a damaged stream may have millions.
constexpr std::size_t max_stores = 100'000;

/// An executor that passes everything on to another.
template <typename Inner>
class Passing : public isa::Executor {
  public:
    explicit Passing(const auto&... arguments) : inner_(arguments...) {}
    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        inner_.execute(in, coefficients);
    }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return inner_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return inner_.enabled(x, y); }
    bool carry(int x, int y) const override { return inner_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return inner_.backing_block(x, y, block);
    }

  protected:
    Inner inner_;
};

/// The whole region on the fast executor. Keeps the answers to ANYENAB.
class Answering final : public Passing<renderer::fast::Fast> {
  public:
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override {
        return inner_.execute_ahead(words);
    }
    bool any_enabled() const override {
        answers.push_back(inner_.any_enabled());
        return answers.back();
    }

    mutable std::vector<bool> answers;
};

/// One pixel on the reference executor, in a region with the given answers to ANYENAB.
class OnePixel final : public Passing<isa::reference::Reference> {
  public:
    OnePixel(int x, int y, std::vector<bool> answers)
        : Passing(isa::reference::Window{x, y, 1, 1}), x_(x), y_(y), answers_(std::move(answers)) {
        inner_.set_readout([this](std::span<const std::uint32_t> sent) {
            color = sent[static_cast<std::size_t>(y_ * region_px + x_)];
        });
    }
    bool any_enabled() const override {
        if (next_answer_ == answers_.size()) {
            throw RequestError(ExitCode::bad_data,
                               "the region asks ANYENAB more often for one pixel than for all");
        }
        return answers_[next_answer_++];
    }
    using Passing::enabled;
    bool enabled() const { return enabled(x_, y_); }
    PixelState state() const {
        const auto of = [this](layout::Field f) {
            return static_cast<std::uint32_t>(field(x_, y_, f.address, f.width));
        };
        const auto is_signed = [&](layout::Field f) {
            const int value = static_cast<int>(of(f)), half = 1 << (f.width - 1);
            return value >= half ? value - 2 * half : value;
        };
        return {
            enabled(),
            of(layout::surface),
            of(layout::z),
            {is_signed(layout::normal_x), is_signed(layout::normal_y), is_signed(layout::normal_z)},
            of(layout::rgb)};
    }

    std::uint32_t bits(std::uint32_t address, std::uint32_t width) const {
        return static_cast<std::uint32_t>(field(x_, y_, address, width));
    }

    std::uint32_t color = 0;  ///< Word that was read out.

  private:
    int x_, y_;
    std::vector<bool> answers_;
    mutable std::size_t next_answer_ = 0;
};

/// A triangle's plane against the depth that is there.
bool is_plane_depth_test(isa::Instruction in) {
    const isa::OpInfo& row = isa::info(in.op);
    return row.effects == isa::enable && in.operands.a == layout::z.address &&
           in.operands.n == layout::z.width && row.b_role == isa::Role::fraction;
}

/// A depth computed in the pixel, a sphere's, against the one that is there.
bool is_own_depth_test(isa::Instruction in) {
    return in.op == isa::Op::mem_lt_mem && in.operands.b == layout::z.address &&
           in.operands.n == layout::z.width;
}

bool stores(isa::Instruction in, bool enabled) {
    const isa::OpInfo& row = isa::info(in.op);
    return (row.effects & isa::mem) != 0 && (enabled || (row.effects & isa::all) != 0);
}

/// Steps through the region and takes notes.
class Historian {
  public:
    Historian(const RecordedRegion& region, PixelHistory& history, OnePixel& pixel)
        : plan_(region.plan), history_(history), pixel_(pixel), walk_(region.plan, pixel) {}

    void run() {
        while (!walk_.done()) {
            step();
        }
        leave_primitive();
        history_.color = pixel_.color;
        history_.instructions = walk_.counts().instructions;
    }

  private:
    void step() {
        const Address at = walk_.at();
        const Kind kind = plan_.parts[at.part].kind;
        enter(at, kind);
        const isa::Instruction in = walk_.next();
        const bool enabled = pixel_.enabled();
        if (kind == Kind::segment && enabled && is_own_depth_test(in)) {
            visit().z = pixel_.bits(in.operands.a, in.operands.n);
        }
        if (kind == Kind::segment && enabled && is_plane_depth_test(in)) {
            visit().z = static_cast<std::uint32_t>(
                (form_of(walk_.coefficients(), {history_.x_in_region(), history_.y_in_region()}) >>
                 in.operands.b) &
                layout::z_far);
        }
        // What a sphere or a door computes on the way in scratch memory shows nothing.
        const bool is_scratch = kind != Kind::prologue && kind != Kind::end_of_region &&
                                in.operands.a >= layout::scratch;
        if (!stores(in, enabled) || is_scratch) {
            walk_.step();
            if (in.op == isa::Op::enab_into_mem && kind == Kind::shut_door && enabled) {
                history_.shut_surfaces.push_back(plan_.parts[at.part].segment.surface);
            }
            return;
        }
        PixelWrite write{at,
                         walk_.counts().instructions,
                         isa::disassemble(in, walk_.coefficients()),
                         pixel_.state(),
                         {}};
        walk_.step();
        write.after = pixel_.state();
        if (++stores_ > max_stores) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("pixel ({}, {}) is stored more than {} times in its "
                                           "region: the recorded stream is damaged",
                                           history_.x, history_.y, max_stores));
        }
        list_of(kind).push_back(std::move(write));
    }

    /// Notes where a primitive, one of the Renderer's own programs, or the end of the region
    /// begins.
    void enter(Address at, Kind kind) {
        while (next_ < history_.primitives.size() && history_.primitives[next_].address() <= at) {
            leave_primitive();
            current_ = next_++;
            before_ = pixel_.state();
        }
        if (kind != Kind::segment) {
            leave_primitive();
        }
        if (kind == Kind::end_of_region && !drawn_) {
            drawn_ = true;
            history_.drawn = pixel_.state();
        }
    }

    void leave_primitive() {
        if (visiting_) {
            history_.visits.back().after = pixel_.state();
        }
        visiting_ = false;
    }

    PixelVisit& visit() {
        if (!visiting_) {
            visiting_ = true;
            const Primitive& primitive = history_.primitives[current_];
            history_.visits.push_back({current_,
                                       std::nullopt,
                                       before_,
                                       {},
                                       {},
                                       plan_.parts[primitive.part].segment.surface});
        }
        return history_.visits.back();
    }

    std::vector<PixelWrite>& list_of(Kind kind) {
        switch (kind) {
            case Kind::prologue:
                return history_.prologue;
            case Kind::shut_door:
            case Kind::open_door:
                return history_.doors;
            case Kind::depths:
            case Kind::end_of_region:
                return history_.end_of_region;
            case Kind::segment:
                break;
        }
        return visit().writes;
    }

    const renderer::RegionPlan& plan_;
    PixelHistory& history_;
    OnePixel& pixel_;
    RegionWalk walk_;
    std::size_t next_ = 0, current_ = 0;  ///< Primitives: to come, under way.
    std::size_t stores_ = 0;
    PixelState before_;  ///< State before the current primitive.
    bool visiting_ = false, drawn_ = false;
};

}  // namespace

const PixelVisit* PixelHistory::shown() const {
    for (std::size_t i = visits.size(); i-- > 0;) {
        if (!visits[i].writes.empty()) {
            return &visits[i];
        }
    }
    return nullptr;
}

bool PixelHistory::is_shut_out(const PixelVisit& visit) const {
    return visit.writes.empty() &&
           std::ranges::find(shut_surfaces, visit.surface) != shut_surfaces.end();
}

PixelHistory history_of(const RecordedFrame& frame, const RecordedRegion& region, int x, int y) {
    PixelHistory history;
    history.x = x;
    history.y = y;
    history.place = region.place;
    history.primitives = primitives_of(frame, region);
    Answering whole;
    for (RegionWalk walk(region.plan, whole); !walk.done();) {
        walk.run_part();
    }
    OnePixel pixel(history.x_in_region(), history.y_in_region(), std::move(whole.answers));
    Historian(region, history, pixel).run();
    const std::optional<RecordedTile> tile = tile_of(frame, region.place.number);
    if (tile && !tile->pixels.empty()) {
        history.sent = tile->pixels[static_cast<std::size_t>(history.y_in_region() * region_px +
                                                             history.x_in_region())];
    }
    return history;
}

}  // namespace pxpl5::host::inspect
