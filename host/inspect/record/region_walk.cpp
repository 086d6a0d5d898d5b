#include "host/inspect/record/region_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "host/base/error.hpp"
#include "ringbus/rules/slice_planes.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using Kind = PartKind;

constexpr std::uint32_t primitive_word = isa::encode({isa::Op::set_enabs, {}});

/// The side table of one GP for one region; null if it was not recorded.
const schema::RegionProgram* program_of(const RecordedFrame& frame, const RecordedRegion& region,
                                        std::uint32_t gp) {
    const bus::Message& message = frame.inputs.at(region.renderer).programs.at(gp);
    for (const auto* program : *message.as<schema::RegionPrograms>()->regions()) {
        if (program->region() == region.place.number) {
            return program;
        }
    }
    return nullptr;
}

/// Primitives that begin in words[0 .. end).
std::size_t count_primitives(const schema::RegionProgram& program, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < end;) {
        const std::uint32_t word = program.words()->Get(static_cast<std::uint32_t>(at));
        count += word == primitive_word ? 1 : 0;
        at += std::max<std::size_t>(isa::instruction_words(word), 1);
    }
    return count;
}

/// Adds the primitives of one segment.
void add_primitives(const RecordedFrame& frame, const RecordedRegion& region, std::size_t part,
                    std::vector<Primitive>& primitives) {
    const renderer::Segment& segment = region.plan.parts[part].segment;
    const schema::RegionProgram* program = program_of(frame, region, segment.gp);
    const auto* origins = program == nullptr ? nullptr : program->origins();
    std::size_t origin = origins == nullptr ? 0 : count_primitives(*program, segment.first_word);
    const std::size_t first = primitives.size();
    const auto& surfaces = *frame.draw().surfaces();
    const int detail =
        segment.surface < surfaces.size() ? surfaces.Get(segment.surface)->detail() : 0;
    const bool is_of_slice = bus::plane_at(frame.draw(), segment.surface) != nullptr;
    for (std::size_t at = 0; at < segment.words.size();
         at += isa::instruction_words(segment.words[at])) {
        if (segment.words[at] != primitive_word) {
            continue;
        }
        Primitive primitive{part,  primitives.size(), at,    0, std::nullopt,
                            false, is_of_slice,       detail};
        if (origins != nullptr && origin < origins->size()) {
            const schema::Origin& from = *origins->Get(static_cast<std::uint32_t>(origin++));
            const bool has_cell = from.inside() != 0;  // No cell without a corner inside is cut.
            primitive.is_of_scene = !has_cell && !is_of_slice && detail == 0;
            if (has_cell) {
                primitive.origin = from;
            } else if (is_of_slice) {
                primitive.square = from;
            }
        }
        primitives.push_back(primitive);
    }
    for (std::size_t i = first; i < primitives.size(); ++i) {
        const std::size_t end =
            i + 1 < primitives.size() ? primitives[i + 1].first_word : segment.words.size();
        primitives[i].word_count = end - primitives[i].first_word;
    }
}

}  // namespace

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::prologue:
            return "prologue";
        case Kind::shut_door:
            return "shut-door";
        case Kind::open_door:
            return "open-door";
        case Kind::depths:
            return "depths";
        case Kind::end_of_region:
            return "end";
        case Kind::segment:
            break;
    }
    return "segment";
}

std::vector<const RecordedRegion*> selected_regions(const RecordedFrame& frame,
                                                    const Selection& selection) {
    std::vector<const RecordedRegion*> regions;
    for (const auto& [number, region] : frame.regions) {
        if (selection.has_region(number, region.place.column, region.place.row) &&
            selection.has_renderer(region.renderer)) {
            regions.push_back(&region);
        }
    }
    return regions;
}

std::string to_text(const renderer::RegionPlan& plan, Address address) {
    const renderer::RegionPlan::Part& part = plan.parts[address.part];
    const renderer::Segment& s = part.segment;
    if (part.kind == Kind::segment) {
        return fmt::format("gp-{} surface {} slab {}+{}", s.gp, s.surface, s.slab, address.word);
    }
    const bool is_door = part.kind == Kind::shut_door || part.kind == Kind::open_door;
    return fmt::format("{}{}+{}", kind_name(part.kind),
                       is_door ? fmt::format(" surface {}", s.surface) : "", address.word);
}

std::vector<Primitive> primitives_of(const RecordedFrame& frame, const RecordedRegion& region) {
    std::vector<Primitive> primitives;
    for (std::size_t part = 0; part < region.plan.parts.size(); ++part) {
        if (region.plan.parts[part].kind == Kind::segment) {
            add_primitives(frame, region, part, primitives);
        }
    }
    return primitives;
}

const Primitive* primitive_at(std::span<const Primitive> primitives, Address address) {
    const auto behind =
        std::upper_bound(primitives.begin(), primitives.end(), address,
                         [](Address a, const Primitive& p) { return a < p.address(); });
    if (behind == primitives.begin()) {
        return nullptr;
    }
    const Primitive& candidate = *std::prev(behind);
    return candidate.part == address.part &&
                   address.word < candidate.first_word + candidate.word_count
               ? &candidate
               : nullptr;
}

isa::Coefficients coefficients_behind(std::span<const std::uint32_t> words, std::size_t word) {
    const auto behind = words.subspan(word + 1, isa::instruction_words(words[word]) - 1);
    // int32_t is the signed type of uint32_t, so that reading one as the other is defined.
    return {reinterpret_cast<const std::int32_t*>(behind.data()), behind.size()};
}

RegionWalk::RegionWalk(const renderer::RegionPlan& plan, isa::Executor& executor)
    : plan_(plan), executor_(executor) {
    for (const renderer::RegionPlan::Part& part : plan.parts) {
        words_ += part.segment.words.size();
    }
    enter();
}

/// Lets the part under way run to its own limit or to that of the region.
void RegionWalk::set_limit() {
    const std::uint64_t before = counts_.instructions - sequencer_->counts().instructions;
    const std::size_t words = plan_.parts[part_].segment.words.size();
    controller_.step_limit =
        std::min(isa::usual_step_limit(words), isa::usual_step_limit(words_) - before);
}

/// Goes to the next part that holds an instruction.
void RegionWalk::enter() {
    for (; part_ < plan_.parts.size(); ++part_) {
        const renderer::Words words = plan_.parts[part_].segment.words;
        if (!words.empty()) {
            sequencer_.emplace(words, executor_, controller_);
            set_limit();
            return;
        }
    }
    sequencer_.reset();
}

RegionWalk::State RegionWalk::save() const {
    return {part_, controller_.flag, sequencer_ ? sequencer_->state() : isa::Sequencer::State{},
            counts_};
}

void RegionWalk::restore(const State& state) {
    part_ = state.part;
    controller_.flag = state.flag;
    counts_ = state.counts;
    enter();  // Stays at this part, which has an instruction, unless all is done.
    if (sequencer_) {
        sequencer_->restore(state.sequencer);
        set_limit();
    }
}

Address RegionWalk::at() const {
    assert(!done());
    return {part_, sequencer_->at()};
}

bool RegionWalk::is_part_begin() const {
    assert(!done());
    return sequencer_->counts().instructions == 0;
}

isa::Instruction RegionWalk::next() const {
    return *isa::decode(plan_.parts[part_].segment.words[sequencer_->at()]);
}

isa::Coefficients RegionWalk::coefficients() const {
    return coefficients_behind(plan_.parts[part_].segment.words, sequencer_->at());
}

/// Calls `act` with the part's sequencer, counts what ran, and goes on behind a part that is done
/// or cannot go on.
template <typename Act>
void RegionWalk::count(const Act& act) {
    assert(!done());
    const isa::RunCounts before = sequencer_->counts();
    bool over = false;
    try {
        act(*sequencer_);
        over = sequencer_->done();
    } catch (const isa::RunError&) {
        over = true;  // What ran has run; the Renderer leaves the rest out, too.
    }
    counts_.instructions += sequencer_->counts().instructions - before.instructions;
    counts_.cycles += sequencer_->counts().cycles - before.cycles;
    if (const std::uint64_t limit = isa::usual_step_limit(words_); counts_.instructions > limit) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: the region's programs executed {} instructions; the limit is {}: {} "
                        "words, and {} repeated instructions. A machine records no program that "
                        "repeats instructions, so the trace may be crafted",
                        to_text(plan_, {part_, 0}), counts_.instructions, limit, words_,
                        isa::max_repeated_instructions));
    }
    if (over) {
        ++part_;
        enter();
    }
}

void RegionWalk::step() {
    count([](isa::Sequencer& sequencer) { sequencer.step(); });
}

void RegionWalk::run_part() {
    count([](isa::Sequencer& sequencer) { sequencer.run(); });
}

}  // namespace pxpl5::host::inspect
