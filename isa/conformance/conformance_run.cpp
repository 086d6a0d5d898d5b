#include "isa/conformance/conformance_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>

#include "isa/sequencer.hpp"

namespace pxpl5::isa {
namespace {

using Kind = StateColumn::Kind;

/// Memory of one pixel, 64 bits per word.
struct Memory {
    std::array<std::uint64_t, memory_bits / 64 + 1> words{};

    static std::uint64_t mask(std::uint32_t n) {
        return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
    }
    std::uint64_t field(std::uint32_t a, std::uint32_t n) const {
        const std::size_t word = a / 64;
        const std::uint32_t shift = a % 64;
        const std::uint64_t low = words[word] >> shift;
        const bool crosses = shift + n > 64;
        return (crosses ? low | words[word + 1] << (64 - shift) : low) & mask(n);
    }
    void set_field(std::uint32_t a, std::uint32_t n, std::uint64_t value) {
        const std::size_t word = a / 64;
        const std::uint32_t shift = a % 64;
        value &= mask(n);
        words[word] = (words[word] & ~(mask(n) << shift)) | value << shift;
        if (shift + n > 64) {
            words[word + 1] =
                (words[word + 1] & ~(mask(n) >> (64 - shift))) | value >> (64 - shift);
        }
    }
};

/// The state of one pixel.
struct Pixel {
    Memory memory;
    bool enable = false, carry = false;
    std::map<std::uint32_t, std::uint32_t> blocks;  ///< The blocks that the case names.
    std::uint32_t readout = 0;
};

void set(const StateColumn& column, std::uint64_t value, Pixel& pixel) {
    switch (column.kind) {
        case Kind::field:
            pixel.memory.set_field(column.a, column.n, value);
            break;
        case Kind::enable:
            pixel.enable = (value & 1) != 0;
            break;
        case Kind::carry:
            pixel.carry = (value & 1) != 0;
            break;
        case Kind::block:
            pixel.blocks[column.a] = static_cast<std::uint32_t>(value);
            break;
        case Kind::readout:
            pixel.readout = static_cast<std::uint32_t>(value);
            break;
    }
}

void apply(const std::vector<StateTable>& tables, int x, int y, Pixel& pixel) {
    for (const StateTable& table : tables) {
        for (const StateTable::Row& row : table.rows) {
            for (std::size_t i = 0; row.where.selects(x, y) && i < row.values.size(); ++i) {
                if (row.values[i]) {
                    set(table.columns[i], row.values[i]->at(x, y), pixel);
                }
            }
        }
    }
}

/// Returns the backing-store blocks that the case or its program names.
std::vector<std::uint32_t> blocks_of(const ConformanceCase& test) {
    std::vector<std::uint32_t> blocks;
    for (const std::vector<StateTable>* tables : {&test.given, &test.expect}) {
        for (const StateTable& table : *tables) {
            for (const StateColumn& column : table.columns) {
                if (column.kind == Kind::block) {
                    blocks.push_back(column.a);
                }
            }
        }
    }
    const std::vector<std::uint32_t>& words = test.program.words;
    for (std::size_t at = 0; at < words.size(); at += instruction_words(words[at])) {
        const Instruction in = *decode(words[at]);
        if (info(in.op).b_role == Role::block) {
            blocks.push_back(in.operands.b);
        }
    }
    std::ranges::sort(blocks);
    blocks.erase(std::ranges::unique(blocks).begin(), blocks.end());
    return blocks;
}

bool has_readout(const std::vector<StateTable>& tables) {
    return std::ranges::any_of(tables, [](const StateTable& table) {
        return std::ranges::any_of(table.columns,
                                   [](const StateColumn& c) { return c.kind == Kind::readout; });
    });
}

std::string listed(const std::vector<std::uint32_t>& numbers) {
    std::string text;
    for (const std::uint32_t number : numbers) {
        text += (text.empty() ? "" : " ") + std::to_string(number);
    }
    return text;
}

class Comparison {
  public:
    Comparison(const ConformanceCase& test, Executor& executor, PixelRectangle area)
        : test_(test), executor_(executor), area_(area), blocks_(blocks_of(test)) {
        executor_.set_readout([this](std::span<const std::uint32_t> words) {
            readout_.assign(words.begin(), words.end());
        });
    }
    Comparison(const Comparison&) = delete;
    Comparison& operator=(const Comparison&) = delete;
    ~Comparison() { executor_.set_readout({}); }

    std::string first_difference(const std::function<void()>& before_run) {
        set_up(test_.given, executor_);
        if (std::string found = pixels(false); !found.empty()) {
            return "before the run " + found;
        }
        if (before_run) {
            before_run();
        }
        const std::string stopped = run();
        const std::string found = controller(stopped);
        return found.empty() ? pixels(true) : found;
    }

  private:
    /// Runs the program. Returns the error that stopped the run, or an empty text.
    std::string run() {
        controller_.on_signal = [this](std::uint32_t number) { signals_.push_back(number); };
        controller_.step_limit = 1'000'000;
        Sequencer sequencer(test_.program.words, executor_, controller_);
        std::string stopped;
        try {
            sequencer.run();
        } catch (const RunError& error) {
            stopped = error.what();
        }
        counts_ = sequencer.counts();
        return stopped;
    }

    std::string controller(const std::string& stopped) const {
        if (stopped.empty() != test_.stops.empty() ||
            stopped.find(test_.stops) == std::string::npos) {
            return fmt::format("the run stopped with '{}', expected '{}'", stopped, test_.stops);
        }
        if (signals_ != test_.signals) {
            return fmt::format("signals are [{}], expected [{}]", listed(signals_),
                               listed(test_.signals));
        }
        if (controller_.flag != test_.flag) {
            return fmt::format("flag is {:d}, expected {:d}", controller_.flag, test_.flag);
        }
        if (readout_.empty() == has_readout(test_.expect)) {
            return readout_.empty() ? "nothing was read out, expected a readout"
                                    : "pixels were read out, expected none";
        }
        if (test_.instructions.value_or(counts_.instructions) != counts_.instructions) {
            return fmt::format("the run took {} instructions, expected {}", counts_.instructions,
                               *test_.instructions);
        }
        if (test_.cycles.value_or(counts_.cycles) != counts_.cycles) {
            return fmt::format("the run took {} cycles, expected {}", counts_.cycles,
                               *test_.cycles);
        }
        return {};
    }

    std::string pixels(bool after) const {
        for (const PixelRectangle& r : compared_pixels(test_)) {
            for (int y = std::max(r.y0, area_.y0); y <= std::min(r.y1, area_.y1); ++y) {
                for (int x = std::max(r.x0, area_.x0); x <= std::min(r.x1, area_.x1); ++x) {
                    if (std::string found = pixel(x, y, after); !found.empty()) {
                        return fmt::format("pixel ({}, {}): {}", x, y, found);
                    }
                }
            }
        }
        return {};
    }

    std::string pixel(int x, int y, bool after) const {
        Pixel want;
        apply(test_.given, x, y, want);
        if (after) {
            apply(test_.expect, x, y, want);
        }
        if (std::string found = memory(x, y, want); !found.empty()) {
            return found;
        }
        if (executor_.enabled(x, y) != want.enable) {
            return fmt::format("enable is {:d}, expected {:d}", !want.enable, want.enable);
        }
        if (executor_.carry(x, y) != want.carry) {
            return fmt::format("carry is {:d}, expected {:d}", !want.carry, want.carry);
        }
        for (const std::uint32_t block : blocks_) {
            const std::uint32_t found = executor_.backing_block(x, y, block);
            if (found != want.blocks[block]) {
                return fmt::format("bs{} is 0x{:x}, expected 0x{:x}", block, found,
                                   want.blocks[block]);
            }
        }
        const auto index = static_cast<std::size_t>(y * region_px + x);
        if (after && !readout_.empty() && readout_[index] != want.readout) {
            return fmt::format("readout is 0x{:x}, expected 0x{:x}", readout_[index], want.readout);
        }
        return {};
    }

    /// Compares the fields of the case first, so that a difference uses their names.
    std::string memory(int x, int y, const Pixel& want) const {
        constexpr std::uint32_t part = 52;
        for (std::uint32_t a = 0; a < memory_bits; a += part) {
            const std::uint64_t found = executor_.field(x, y, a, part);
            const std::uint64_t expected = want.memory.field(a, part);
            if (found != expected) {
                const auto offset = static_cast<std::uint32_t>(std::countr_zero(found ^ expected));
                return named_field(x, y, want, a + offset);
            }
        }
        return {};
    }

    /// Returns the difference at `bit` as a difference of the case's field there, or of the bit.
    std::string named_field(int x, int y, const Pixel& want, std::uint32_t bit) const {
        StateColumn field{Kind::field, bit, 1};
        for (const std::vector<StateTable>* tables : {&test_.given, &test_.expect}) {
            for (const StateTable& table : *tables) {
                for (const StateColumn& c : table.columns) {
                    field = c.kind == Kind::field && bit >= c.a && bit < c.a + c.n ? c : field;
                }
            }
        }
        return fmt::format("m{}:{} is 0x{:x}, expected 0x{:x}", field.a, field.n,
                           executor_.field(x, y, field.a, field.n),
                           want.memory.field(field.a, field.n));
    }

    const ConformanceCase& test_;
    Executor& executor_;
    PixelRectangle area_;
    std::vector<std::uint32_t> blocks_;
    Controller controller_;
    RunCounts counts_;
    std::vector<std::uint32_t> signals_, readout_;
};

}  // namespace

std::vector<PixelRectangle> compared_pixels(const ConformanceCase& test) {
    return test.watch.empty() ? std::vector<PixelRectangle>{PixelRectangle{}} : test.watch;
}

std::string first_difference(const ConformanceCase& test, Executor& executor,
                             const PixelRectangle& area, const std::function<void()>& before_run) {
    return Comparison(test, executor, area).first_difference(before_run);
}

}  // namespace pxpl5::isa
