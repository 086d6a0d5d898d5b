// Puts an executor into a given state by running a program.
#include <fmt/format.h>

#include <algorithm>
#include <bitset>

#include "isa/conformance/conformance_run.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::isa {
namespace {

using Kind = StateColumn::Kind;

/// Writes the program. Memory is scratch until the fields are set.
class SetUp {
  public:
    std::vector<std::uint32_t> words(const std::vector<StateTable>& given) {
        for (const Kind kind : {Kind::block, Kind::carry}) {
            each_value(given, kind, [&](const StateColumn& column, const Quadratic& value) {
                store(0, backing_block_bits, value);
                if (kind == Kind::carry) {
                    put({Op::mem_plus_mem, {0, 0, 1}});  // The carry of bit + bit is the bit.
                } else {
                    put({Op::bs_write, {0, column.a, 0}});
                    put({Op::bs_wait, {}});
                }
            });
        }
        put({Op::set_enabs, {}});
        put({Op::clear_mem, {0, 0, backing_block_bits}});
        each_value(given, Kind::field, [&](const StateColumn& column, const Quadratic& value) {
            store(column.a, column.n, value);
        });
        enables(given);
        return std::move(words_);
    }

  private:
    void put(Instruction in, const std::array<std::uint64_t, 6>& coefficients = {}) {
        words_.push_back(encode(in));
        for (int i = 0; i < info(in.op).words; ++i) {
            words_.push_back(static_cast<std::uint32_t>(coefficients[static_cast<std::size_t>(i)]));
        }
    }

    /// Enables the pixels of a row.
    void select(const PixelSelector& where) {
        const PixelRectangle& r = where.rectangle;
        const auto minus = [](int v) { return static_cast<std::uint64_t>(-std::int64_t{v}); };
        const auto plus = [](int v) { return static_cast<std::uint64_t>(v); };
        put({Op::set_enabs, {}});
        if (r != PixelRectangle{}) {
            put({Op::tree_ge_zero, {0, 0, 16}}, {1, 0, minus(r.x0)});
            put({Op::tree_lt_zero, {0, 0, 16}}, {1, 0, minus(r.x1 + 1)});
            put({Op::tree_ge_zero, {0, 0, 16}}, {0, 1, minus(r.y0)});
            put({Op::tree_ge_zero, {0, 0, 16}}, {0, minus(1), plus(r.y1)});
        }
        if (where.at_least_zero) {
            put({Op::quad_ge_zero, {0, 0, 64}}, where.at_least_zero->k);
        }
    }

    /// Stores the low n bits of `value` at m[a] of the enabled pixels.
    void store(std::uint32_t a, std::uint32_t n, const Quadratic& value) {
        if (!value.is_constant()) {
            return put({Op::quad_into_mem, {a, 0, n}}, value.k);
        }
        put({Op::const_into_mem, {a, 0, std::min(n, 32U)}}, {value.k[2]});
        if (n > 32) {
            put({Op::const_into_mem, {a + 32, 0, n - 32}}, {value.k[2] >> 32U});
        }
    }

    /// Calls action(where, column, value) for each value of a kind, in order.
    template <typename Action>
    static void each_row(const std::vector<StateTable>& given, Kind kind, const Action& action) {
        for (const StateTable& table : given) {
            for (const StateTable::Row& row : table.rows) {
                for (std::size_t i = 0; i < table.columns.size(); ++i) {
                    if (table.columns[i].kind == kind && row.values[i]) {
                        action(row.where, table.columns[i], *row.values[i]);
                    }
                }
            }
        }
    }

    /// Calls action(column, value) with the row's pixels enabled.
    template <typename Action>
    void each_value(const std::vector<StateTable>& given, Kind kind, const Action& action) {
        const PixelSelector* selected = nullptr;
        each_row(given, kind,
                 [&](const PixelSelector& where, const StateColumn& c, const Quadratic& value) {
                     if (selected != &where) {
                         select(where);
                         selected = &where;
                     }
                     action(c, value);
                 });
    }

    /// Runs last. If the enable bits differ, collects them in a free bit, which is 0 before and
    /// after: CLEARMEM clears the bit of exactly those pixels that MEMintoENAB enables.
    void enables(const std::vector<StateTable>& given) {
        bool differ = false, last = false;
        each_row(given, Kind::enable,
                 [&](const PixelSelector& where, const StateColumn&, const Quadratic& value) {
                     differ = differ || where.at_least_zero || !value.is_constant() ||
                              where.rectangle != PixelRectangle{};
                     last = (value.k[2] & 1) != 0;
                 });
        if (!differ) {
            return put({last ? Op::set_enabs : Op::clr_enabs, {}});
        }
        const std::uint32_t bit = free_bit(given);
        each_value(given, Kind::enable,
                   [&](const StateColumn&, const Quadratic& value) { store(bit, 1, value); });
        put({Op::mem_into_enab, {bit, 0, 0}});
        put({Op::clear_mem, {bit, 0, 1}});
    }

    static std::uint32_t free_bit(const std::vector<StateTable>& given) {
        std::bitset<memory_bits> used;
        for (const StateTable& table : given) {
            for (const StateColumn& column : table.columns) {
                for (std::uint32_t i = 0; column.kind == Kind::field && i < column.n; ++i) {
                    used.set(column.a + i);
                }
            }
        }
        for (std::uint32_t bit = memory_bits; bit-- > 0;) {
            if (!used.test(bit)) {
                return bit;
            }
        }
        throw std::invalid_argument(fmt::format(
            "the given fields use all {} bits of memory; the set-up of enable needs one free bit",
            memory_bits));
    }

    std::vector<std::uint32_t> words_;
};

}  // namespace

void set_up(const std::vector<StateTable>& given, Executor& executor) {
    const std::vector<std::uint32_t> words = SetUp().words(given);
    Controller controller;
    run(words, executor, controller);
}

}  // namespace pxpl5::isa
