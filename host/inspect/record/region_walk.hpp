// Walks through a region's programs one instruction at a time, as its Renderer did.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::host::inspect {

/// A pixel of a region, 0..127 each.
struct RegionPixel {
    int x = 0, y = 0;
    friend bool operator==(const RegionPixel&, const RegionPixel&) = default;
};

/// Address of an instruction in a region's programs.
struct Address {
    std::size_t part = 0;  ///< Index into the plan's parts.
    std::size_t word = 0;  ///< Within the part's words.
    auto operator<=>(const Address&) const = default;
};

/// "prologue", "shut-door", "open-door", "depths", "end"; "segment".
const char* kind_name(PartKind kind);

/// The regions of a frame that a selection names by region and by Renderer.
std::vector<const RecordedRegion*> selected_regions(const RecordedFrame& frame,
                                                    const Selection& selection);

/// "prologue+4", "gp-3 surface 0 slab 17+34", "shut-door surface 1+2", "open-door surface 1+0",
/// "depths+0", "end+12".
std::string to_text(const renderer::RegionPlan& plan, Address address);

/// One primitive of a segment: what lies between one SETENABS and the next.
struct Primitive {
    std::size_t part = 0;
    std::size_t number = 0;                      ///< In the region, over all segments, from 0.
    std::size_t first_word = 0, word_count = 0;  ///< Within the part.
    std::optional<bus::schema::Origin> origin;   ///< If it was recorded and there is a cell.
    bool is_of_scene = false;  ///< True for a primitive of an archive: it has no voxel cell.
    bool is_of_slice = false;  ///< True for a triangle of a slice plane: the same.
    int detail = 0;            ///< Above 0 for a simplified triangle: it has no voxel cell either.
    std::optional<bus::schema::Origin>
        square{};  ///< First voxel of a slice's triangle, if recorded.
    Address address() const { return {part, first_word}; }
};

/// All primitives of a region, in the order in which they run.
std::vector<Primitive> primitives_of(const RecordedFrame& frame, const RecordedRegion& region);

/// The primitive that holds the address; null for the Renderer's own programs.
const Primitive* primitive_at(std::span<const Primitive> primitives, Address address);

/// The coefficients of the instruction at `word`.
isa::Coefficients coefficients_behind(std::span<const std::uint32_t> words, std::size_t word);

class RegionWalk {
  public:
    /// Both outlive the walk; `executor` is as new.
    RegionWalk(const renderer::RegionPlan& plan, isa::Executor& executor);

    const renderer::RegionPlan& plan() const { return plan_; }
    bool done() const { return part_ == plan_.parts.size(); }
    /// Address of the next instruction. Not when done().
    Address at() const;
    bool is_part_begin() const;  ///< The next instruction is its part's first that runs.
    isa::Instruction next() const;
    isa::Coefficients coefficients() const;

    /// Runs one instruction. A part that cannot go on (isa::RunError) is left, as the Renderer
    /// does. Throws RequestError (bad_data) if all parts together repeat more instructions than one
    /// program may (isa::max_repeated_instructions): the programs of GPs and Renderers repeat none,
    /// and a crafted region of many looping parts would run for hours.
    void step();
    /// Runs to the end of the part under way, letting the executor run ahead.
    void run_part();

    const isa::RunCounts& counts() const {
        return counts_;
    }  ///< Counts of all instructions so far.

    /// Where the walk stands. The executor's pixels are kept apart.
    struct State {
        std::size_t part = 0;
        bool flag = true;  ///< The controller's.
        isa::Sequencer::State sequencer;
        isa::RunCounts counts;
    };
    State save() const;
    /// Goes on from a state of a walk of the same plan.
    void restore(const State& state);

  private:
    void enter();
    void set_limit();
    template <typename Act>
    void count(const Act& act);

    const renderer::RegionPlan& plan_;
    isa::Executor& executor_;
    isa::Controller controller_;
    std::size_t part_ = 0;
    std::optional<isa::Sequencer> sequencer_;  ///< Runs the current part.
    isa::RunCounts counts_;
    std::uint64_t words_ = 0;  ///< Number of words of all parts.
};

}  // namespace pxpl5::host::inspect
