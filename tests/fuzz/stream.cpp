// Instruction streams on both executors: a stream that check() accepts leaves the same bits,
// counts and faults in the reference and in the fast executor, and also if the fast executor runs
// ahead of the sequencer.
#include <fmt/format.h>

#include <map>
#include <set>
#include <vector>

#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/stream_words.hpp"

namespace pxpl5::fuzz {

namespace {

using isa::reference::Reference;
using isa::reference::Window;
using renderer::fast::Fast;

constexpr std::uint64_t step_limit = 200;
constexpr std::uint32_t part_bits = 52;
static_assert(isa::memory_bits % part_bits == 0);

void same(std::uint64_t fast, std::uint64_t reference, int x, int y, const char* item) {
    if (fast != reference) {
        require(false, fmt::format("pixel ({}, {}): {} is 0x{:x}, the reference has 0x{:x}", x, y,
                                   item, fast, reference));
    }
}

/// Calls back for each pixel of a window.
template <typename Take>
void each_pixel(const Window& window, const Take& take) {
    for (int y = window.y0; y < window.y0 + window.height; ++y) {
        for (int x = window.x0; x < window.x0 + window.width; ++x) {
            take(x, y);
        }
    }
}

/// Runs each instruction on the reference, which emulates a window, and on the fast executor.
class Both final : public isa::Executor {
  public:
    Both(Reference& reference, Fast& fast) : reference_(reference), fast_(fast) {
        reference_.set_readout(
            [this](auto pixels) { wanted_.assign(pixels.begin(), pixels.end()); });
        fast_.set_readout([this](auto pixels) { found_.assign(pixels.begin(), pixels.end()); });
    }

    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        reference_.execute(in, coefficients);
        fast_.execute(in, coefficients);
        if (isa::info(in.op).b_role == isa::Role::block) {
            blocks_.insert(in.operands.b);
        }
        if (in.op == isa::Op::pixels_to_fb) {
            each_pixel(reference_.window(), [&](int x, int y) {
                const auto at = static_cast<std::size_t>(y * region_px + x);
                same(found_.at(at), wanted_.at(at), x, y, "readout");
            });
        }
    }
    bool any_enabled() const override {
        const auto& enable = fast_.pixels().enable;
        const bool any = std::ranges::any_of(enable, [](std::uint8_t bits) { return bits != 0; });
        require(fast_.any_enabled() == any, "the OR of all enables");
        require(any || !reference_.any_enabled(), "the OR of the window's enables");
        return any;
    }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return fast_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return fast_.enabled(x, y); }
    bool carry(int x, int y) const override { return fast_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return fast_.backing_block(x, y, block);
    }

    void compare() const {
        each_pixel(reference_.window(), [this](int x, int y) {
            same(fast_.enabled(x, y), reference_.enabled(x, y), x, y, "enable");
            same(fast_.carry(x, y), reference_.carry(x, y), x, y, "carry");
            for (std::uint32_t a = 0; a < isa::memory_bits; a += part_bits) {
                same(fast_.field(x, y, a, part_bits), reference_.field(x, y, a, part_bits), x, y,
                     "memory");
            }
            for (const std::uint32_t block : blocks_) {
                same(fast_.backing_block(x, y, block), reference_.backing_block(x, y, block), x, y,
                     "backing store");
            }
        });
    }

  private:
    Reference& reference_;
    Fast& fast_;
    std::vector<std::uint32_t> wanted_, found_;
    std::set<std::uint32_t> blocks_;
};

/// The controller's part of a run.
struct Result {
    isa::RunCounts counts;
    bool flag = true;
    std::vector<std::uint32_t> signals;
    std::string fault;
};

/// The result of run(controller), which returns the counts.
template <typename Run>
Result result_of(const Run& run) {
    Result result;
    isa::Controller controller;
    controller.step_limit = step_limit;
    controller.on_signal = [&](std::uint32_t number) { result.signals.push_back(number); };
    try {
        result.counts = run(controller);
    } catch (const isa::RunError& error) {
        result.fault = error.what();
    }
    result.flag = controller.flag;
    return result;
}

bool is_step_limit(const Result& result) {
    return result.fault.find(" instructions; the limit is ") != std::string::npos;
}

/// All pixels and all blocks of two fast executors.
void compare_fast(const Fast& ahead, const Fast& stepped) {
    const Fast::State p = ahead.save(), q = stepped.save();
    require(p.pixels->enable == q.pixels->enable, "enables after running ahead");
    require(p.pixels->carry == q.pixels->carry, "carries after running ahead");
    for (std::size_t i = 0; i < p.pixels->blocks.size(); ++i) {
        const auto &a = p.pixels->blocks.at(i).columns, &b = q.pixels->blocks.at(i).columns;
        require(std::equal(a.begin(), a.end() - 1, b.begin()), "memory after running ahead");
        // Of the last column, only some bits are memory.
        constexpr std::uint32_t bits = (1U << isa::memory_bits % 32) - 1;
        for (std::size_t k = 0; k < a.back().size(); ++k) {
            require(((a.back()[k] ^ b.back()[k]) & bits) == 0, "memory after running ahead");
        }
    }
    // A block that was never written is 0, like one that was written with 0.
    using Words = renderer::hal::BackingStore::Words;
    const auto stored = [](const Fast::State& state) {
        std::map<std::uint32_t, const Words*> blocks;
        for (const auto& [number, words] : state.blocks) {
            if (std::ranges::any_of(words.at, [](std::uint32_t word) { return word != 0; })) {
                blocks[number] = &words;
            }
        }
        return blocks;
    };
    const auto in_p = stored(p), in_q = stored(q);
    const auto same_block = [](const auto& a, const auto& b) {
        return a.first == b.first && a.second->at == b.second->at;
    };
    require(std::ranges::equal(in_p, in_q, same_block), "backing store after running ahead");
}

void check_ahead(std::span<const std::uint32_t> words, VectorTarget target, const Result& stepped,
                 const Fast& fast) {
    Fast runs_ahead(target);
    const Result ahead = result_of(
        [&](isa::Controller& controller) { return isa::run(words, runs_ahead, controller); });
    require(is_step_limit(ahead) == is_step_limit(stepped), "the step limit when running ahead");
    if (is_step_limit(stepped)) {
        return;  // The two executors stop at different instructions.
    }
    require(ahead.fault == stepped.fault, "ahead: " + ahead.fault + "; else: " + stepped.fault);
    require(ahead.flag == stepped.flag, "flag after running ahead");
    require(ahead.signals == stepped.signals, "signals after running ahead");
    require(ahead.counts.instructions == stepped.counts.instructions, "count of instructions");
    require(ahead.counts.cycles == stepped.counts.cycles, "count of cycles");
    compare_fast(runs_ahead, fast);
}

}  // namespace

/// Input: a target, the place of the window, and the stream of stream_words().
bool accepts(Input input) {
    Bytes bytes(input);
    const auto targets = isa::available_targets();
    const auto target = targets[bytes.take<std::uint8_t>() % targets.size()];
    constexpr int width = 6, height = 4;
    const Window window{bytes.take<std::uint8_t>() % (region_px - width + 1),
                        bytes.take<std::uint8_t>() % (region_px - height + 1), width, height};
    const std::vector<std::uint32_t> words = stream_words(bytes);
    const isa::CheckResult checked = isa::check(words);
    if (!checked.ok()) {
        require(checked.error->word <= words.size() && !checked.error->text.empty(),
                "the place of an error in a stream");
        return false;
    }
    Reference reference(window);
    Fast fast(target);
    Both both(reference, fast);
    const Result stepped = result_of([&](isa::Controller& controller) {
        isa::Sequencer steps(words, both, controller);
        while (!steps.done()) {
            steps.step();
        }
        return steps.counts();
    });
    both.compare();
    if (!checked.facts.has_flow && stepped.fault.empty()) {
        require(stepped.counts.instructions <= checked.facts.instructions &&
                    stepped.counts.cycles <= checked.facts.cycles,
                "counts of a stream without jumps");
    }
    check_ahead(words, target, stepped, fast);
    return true;
}

}  // namespace pxpl5::fuzz
