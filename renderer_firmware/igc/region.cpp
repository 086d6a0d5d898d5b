#include "renderer_firmware/igc/region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace pxpl5::renderer {

namespace {

void add(isa::RunCounts& sum, const isa::RunCounts& more) {
    sum.instructions += more.instructions;
    sum.cycles += more.cycles;
}

auto place(const Segment& s) {
    return std::tie(s.surface, s.slab);
}

SegmentFault fault(const Segment& s, std::string reason) {
    return {s.surface, s.slab, s.gp, std::move(reason)};
}

/// True if a checked program uses the backing store.
bool uses_backing_store(Words words) {
    if (only_triangles(words)) {
        return false;
    }
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        if ((isa::info(isa::decode(words[at])->op).effects & isa::backing) != 0) {
            return true;
        }
    }
    return false;
}

/// Counts the primitives: each of them has exactly one SETENABS.
std::uint32_t count_primitives(Words words) {
    std::uint32_t count = 0;
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        count += isa::decode(words[at])->op == isa::Op::set_enabs ? 1 : 0;
    }
    return count;
}

/// The facts about a part before it runs.
PartCounts counts_of(const RegionPlan::Part& part) {
    PartCounts counts;
    counts.kind = part.kind;
    counts.surface = part.segment.surface;
    counts.slab = part.segment.slab;
    if (part.kind == PartKind::segment) {
        counts.primitives = count_primitives(part.segment.words);
        counts.words = static_cast<std::uint32_t>(part.segment.words.size());
    }
    return counts;
}

/// Adds parts to a plan, and doors around the segments of transparent surfaces.
class Planner {
  public:
    explicit Planner(const RegionFrame& frame) : frame_(frame) {}

    RegionPlan plan(std::span<const Segment> segments) {
        add(PartKind::prologue, frame_.prologue);
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const Segment& s = segments[i];
            if (i > 0 && place(segments[i - 1]) == place(s)) {
                plan_.faults.push_back(
                    fault(s, fmt::format("GP {} has already drawn this surface and slab",
                                         segments[i - 1].gp)));
            } else if (const std::optional<isa::ProgramError> error = Igc::check(s.words)) {
                plan_.faults.push_back(
                    fault(s, fmt::format("word {}: {}", error->word, error->text)));
            } else if (frame_.holds_sums && uses_backing_store(s.words)) {
                plan_.faults.push_back(
                    fault(s, "it uses the backing store, which holds the picture's sums"));
            } else {
                add_segment(s);
            }
        }
        leave_door();
        if (!frame_.depths.empty() && draws(segments)) {
            add(PartKind::depths, frame_.depths);
        }
        add(PartKind::end_of_region, frame_.end_of_region);
        return std::move(plan_);
    }

  private:
    /// Adds one of the Renderer's own programs.
    void add(PartKind kind, Words words, std::uint32_t surface = 0) {
        RegionPlan::Part part;
        part.kind = kind;
        part.segment.surface = surface;
        part.segment.words = words;
        plan_.parts.push_back(part);
    }

    void add_segment(const Segment& s) {
        if (door_ != nullptr && door_->surface != s.surface) {
            leave_door();
        }
        if (door_ == nullptr) {
            const auto found = std::ranges::find(frame_.doors, s.surface, &Door::surface);
            if (found != frame_.doors.end()) {
                door_ = &*found;
                add(PartKind::shut_door, door_->shut, s.surface);
            }
        }
        plan_.parts.push_back({PartKind::segment, s});
    }

    void leave_door() {
        if (door_ != nullptr) {
            add(PartKind::open_door, door_->open, door_->surface);
        }
        door_ = nullptr;
    }

    const RegionFrame& frame_;
    const Door* door_ = nullptr;  ///< The shut door, if any.
    RegionPlan plan_;
};

}  // namespace

bool draws(std::span<const Segment> segments) {
    return std::ranges::any_of(segments, [](const Segment& s) { return !s.words.empty(); });
}

void check_own(const RegionFrame& frame) {
    const auto check = [](const char* name, Words words) {
        if (const std::optional<isa::ProgramError> error = Igc::check(words)) {
            throw std::logic_error(fmt::format("{}, word {}: {}", name, error->word, error->text));
        }
    };
    check("prologue", frame.prologue);
    check("end-of-region program", frame.end_of_region);
    check("program of depths", frame.depths);
    for (const Door& door : frame.doors) {
        check("program that shuts a door", door.shut);
        check("program that opens a door", door.open);
    }
}

RegionPlan plan_region(const RegionFrame& frame, std::vector<Segment> segments) {
    std::sort(segments.begin(), segments.end(), [](const Segment& p, const Segment& q) {
        return std::tie(p.surface, p.slab, p.gp) < std::tie(q.surface, q.slab, q.gp);
    });
    return Planner(frame).plan(segments);
}

RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments, const PartWatcher& before_part,
                         Counting counting) {
    RegionPlan plan = plan_region(frame, std::move(segments));
    RegionResult result{{}, std::move(plan.faults), {}};
    Igc igc(executor);
    for (const RegionPlan::Part& part : plan.parts) {
        if (before_part) {
            before_part(part.kind);
        }
        const Outcome outcome =
            counting == Counting::whole_region
                ? igc.run_checked(part.segment.words)
                : igc.run_counted(part.segment.words,
                                  result.parts.emplace_back(counts_of(part)).executed);
        add(result.counts, outcome.counts);
        if (outcome.error) {
            result.faults.push_back(
                fault(part.segment,
                      fmt::format("word {}: {}", outcome.error->word, outcome.error->text)));
        }
    }
    return result;
}

}  // namespace pxpl5::renderer
