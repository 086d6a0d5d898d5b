#include "isa/program.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isa/executor.hpp"

namespace pxpl5::isa {
namespace {

using Words = std::span<const std::uint32_t>;

/// A backing-store transfer before its BSWAIT.
struct Transfer {
    std::uint32_t field, block;
    std::size_t word;
};

/// A CALL or SKIPIFNONE. Checked at the end, when all instruction boundaries are known.
struct Jump {
    std::size_t word, target;
    std::size_t loop;  ///< Identity of the innermost enclosing LOOP; 0 outside loops.
    bool is_call;
};

/// An instruction as a possible target of jumps.
struct Landing {
    std::size_t word, loop;
};

bool overlap(std::uint32_t a, std::uint32_t bits_a, std::uint32_t b, std::uint32_t bits_b) {
    return bits_a != 0 && bits_b != 0 && a < b + bits_b && b < a + bits_a;
}

class Checker {
  public:
    explicit Checker(Words words) : words_(words) {}

    CheckResult check() {
        if (words_.size() > max_program_words) {
            fail(0, fmt::format("the program has {} words; the limit is {}", words_.size(),
                                max_program_words));
        }
        while (ok() && at_ < words_.size()) {
            instruction();
        }
        if (ok()) {
            end();
        }
        return std::move(result_);
    }

  private:
    bool ok() const { return !result_.error; }

    void fail(std::size_t word, std::string text) {
        if (ok()) {
            result_.error = ProgramError{word, std::move(text)};
        }
    }

    void instruction() {
        const std::uint32_t word = words_[at_];
        const std::optional<Instruction> in = decode(word);
        if (!in) {
            return fail(
                at_, fmt::format("word 0x{:08x} is not an instruction: operation byte 0x{:02x}{}",
                                 word, word >> op_byte_shift,
                                 row_of_op_byte[word >> op_byte_shift] == no_row
                                     ? " has no row"
                                     : " with bits set that must be 0"));
        }
        const OpInfo& row = info(in->op);
        const auto coefficients = static_cast<std::size_t>(row.words);
        if (words_.size() - at_ - 1 < coefficients) {
            return fail(at_,
                        fmt::format("{} needs {} coefficient words; the program has {} more words",
                                    row.name, coefficients, words_.size() - at_ - 1));
        }
        operands(row, in->operands);
        if (!open_.empty() || (row.effects & (flow | backing)) != 0) {
            transfers(in->op, row, in->operands);
        }
        if ((row.effects & flow) != 0) {
            control(in->op);
        }
        ++result_.facts.instructions;
        result_.facts.cycles += row.cycles(in->operands);
        at_ += 1 + coefficients;
    }

    void operands(const OpInfo& row, const Operands& o) {
        if (row.n_max != 0 && (o.n < 1 || o.n > row.n_max)) {
            return fail(
                at_, fmt::format("{}: width n is {}; it must be 1..{}", row.name, o.n, row.n_max));
        }
        field(row, "m[a]", o.a, row.at_a(o));
        field(row, "m[b]", o.b, row.at_b(o));
        if (row.b_role == Role::fraction && o.b > max_fraction_bits) {
            fail(at_, fmt::format("{}: fraction b is {}; the limit is {}", row.name, o.b,
                                  max_fraction_bits));
        }
        if (row.b_role == Role::block && o.b >= backing_blocks) {
            fail(at_, fmt::format("{}: block b is {}; the last is {}", row.name, o.b,
                                  backing_blocks - 1));
        }
    }

    void field(const OpInfo& row, std::string_view which, std::uint32_t address,
               std::uint32_t bits) {
        if (bits != 0 && address + bits > memory_bits) {
            fail(at_, fmt::format("{}: field {} is bits {}..{}; a pixel has {} bits", row.name,
                                  which, address, address + bits - 1, memory_bits));
        }
    }

    /// Checks the rules of BSREAD and BSWRITE: no instruction uses the field or block of a transfer
    /// before BSWAIT, and no transfer is open at a jump or at the edge of a loop.
    void transfers(Op op, const OpInfo& row, const Operands& o) {
        if (op == Op::bs_wait) {
            open_.clear();
            return;
        }
        for (const Transfer& t : open_) {
            if ((row.effects & flow) != 0) {
                return fail(at_, fmt::format("{} while block {} is under transfer since word {}; "
                                             "insert BSWAIT before it",
                                             row.name, t.block, t.word));
            }
            if (overlap(o.a, row.at_a(o), t.field, backing_block_bits) ||
                overlap(o.b, row.at_b(o), t.field, backing_block_bits)) {
                return fail(at_,
                            fmt::format("{} uses m[{} : {}), under transfer since word {}; "
                                        "insert BSWAIT before it",
                                        row.name, t.field, t.field + backing_block_bits, t.word));
            }
            if (row.b_role == Role::block && o.b == t.block) {
                return fail(at_, fmt::format("{} uses block {}, under transfer since word {}; "
                                             "insert BSWAIT before it",
                                             row.name, t.block, t.word));
            }
        }
        if (row.b_role == Role::block) {
            open_.push_back({o.a, o.b, at_});
        }
    }

    void control(Op op) {
        const std::size_t loop = loops_.empty() ? 0 : loops_.back() + 1;
        if (op == Op::loop) {
            open_loop();
        } else if (op == Op::end_loop) {
            close_loop();
        } else if (op == Op::call) {
            jumps_.push_back({at_, words_[at_ + 1], loop, true});
        } else if (op == Op::skip_if_none) {
            jumps_.push_back({at_, words_[at_ + 1], loop, false});
        } else if (op == Op::ret && loop != 0) {
            fail(at_, fmt::format("RET inside the LOOP of word {}", loops_.back()));
        }
    }

    void open_loop() {
        if (loops_.size() == max_loop_depth) {
            return fail(at_, fmt::format("LOOP at depth {}; the limit is {}", loops_.size() + 1,
                                         max_loop_depth));
        }
        loops_.push_back(at_);
        result_.facts.has_flow = true;
    }

    void close_loop() {
        if (loops_.empty()) {
            return fail(at_, "ENDLOOP without a LOOP before it");
        }
        loops_.pop_back();
    }

    void end() {
        if (!loops_.empty()) {
            return fail(loops_.back(), "LOOP without an ENDLOOP");
        }
        if (!open_.empty()) {
            return fail(open_.back().word,
                        fmt::format("block {} is still under transfer at the program's end",
                                    open_.back().block));
        }
        if (!jumps_.empty()) {
            result_.facts.has_flow = true;
            jumps();
        }
    }

    /// Returns all instructions and the end of the program.
    std::vector<Landing> landings() const {
        std::vector<Landing> landings;
        std::vector<std::size_t> loops{0};
        for (std::size_t at = 0; at < words_.size(); at += instruction_words(words_[at])) {
            const Op op = decode(words_[at])->op;
            landings.push_back({at, loops.back()});
            if (op == Op::loop) {
                loops.push_back(at + 1);
            } else if (op == Op::end_loop) {
                loops.pop_back();
            }
        }
        landings.push_back({words_.size(), 0});
        return landings;
    }

    void jumps() {
        const std::vector<Landing> all = landings();
        for (const Jump& jump : jumps_) {
            const auto found = std::ranges::lower_bound(all, jump.target, {}, &Landing::word);
            const std::string_view name = jump.is_call ? "CALL" : "SKIPIFNONE";
            if (found == all.end() || found->word != jump.target) {
                return fail(jump.word, fmt::format("{}: word {} is not an instruction of this "
                                                   "program of {} words",
                                                   name, jump.target, words_.size()));
            }
            if (!jump.is_call && jump.target <= jump.word) {
                return fail(jump.word, fmt::format("SKIPIFNONE at word {} goes back to word {}; it "
                                                   "must go ahead",
                                                   jump.word, jump.target));
            }
            if (found->loop != (jump.is_call ? 0 : jump.loop)) {
                return fail(jump.word,
                            fmt::format("{}: word {} is in another LOOP", name, jump.target));
            }
        }
    }

    Words words_;
    std::size_t at_ = 0;
    CheckResult result_;
    std::vector<Transfer> open_;      ///< At most 6: their fields do not overlap.
    std::vector<std::size_t> loops_;  ///< Word offset of each open LOOP.
    std::vector<Jump> jumps_;
};

}  // namespace

CheckResult check(Words words) {
    return Checker(words).check();
}

namespace {

std::uint32_t fit(const std::string& name, std::int64_t value, bool is_operand) {
    const std::int64_t low = is_operand ? 0 : INT32_MIN;
    const std::int64_t high = is_operand ? UINT8_MAX : std::int64_t{UINT32_MAX};
    if (value < low || value > high) {
        throw ParameterError(
            fmt::format("parameter ${} is {}; it must be {}..{}", name, value, low, high));
    }
    return static_cast<std::uint32_t>(value);
}

}  // namespace

std::vector<std::uint32_t> Program::bind(const Parameters& values) const {
    std::vector<std::uint32_t> bound = words;
    for (const Patch& patch : patches) {
        const auto value = values.find(patch.name);
        if (value == values.end()) {
            throw ParameterError(fmt::format("parameter ${} has no value", patch.name));
        }
        const std::uint32_t bits = fit(patch.name, value->second, patch.is_operand);
        if (patch.is_operand) {
            const std::optional<Instruction> in = decode(bound[patch.word]);
            bound[patch.word] |= bits << static_cast<unsigned>(info(in->op).pattern.b.shift);
        } else {
            bound[patch.word] = bits;
        }
    }
    for (const auto& [name, value] : values) {
        if (std::ranges::find(patches, name, &Patch::name) == patches.end()) {
            throw ParameterError(fmt::format("the program has no parameter ${}", name));
        }
    }
    return bound;
}

}  // namespace pxpl5::isa
