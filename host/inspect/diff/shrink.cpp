#include "host/inspect/diff/shrink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "host/base/error.hpp"
#include "isa/program.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();
constexpr std::size_t max_coefficients = 6;

/// An instruction that knows where it jumps to by number, not by place.
struct Item {
    isa::Instruction in;
    std::array<std::uint32_t, max_coefficients> coefficients{};
    std::size_t coefficient_count = 0;
    std::size_t id = 0;            ///< Place in the first program.
    std::size_t target = nowhere;  ///< id of the instruction jumped to; of a jump only.
    std::size_t group = 0;         ///< Number of its primitive.
};
using Items = std::vector<Item>;

bool jumps(isa::Op op) {
    return op == isa::Op::call || op == isa::Op::skip_if_none;
}

Items items_of(std::span<const std::uint32_t> words) {
    Items items;
    std::vector<std::size_t> id_at(words.size() + 1, nowhere);
    std::size_t group = 0;
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t count = isa::instruction_words(words[at]);
        Item item{*isa::decode(words[at]), {}, count - 1, items.size(), nowhere, 0};
        group += item.in.op == isa::Op::set_enabs ? 1 : 0;
        item.group = group;
        std::ranges::copy(words.subspan(at + 1, count - 1), item.coefficients.begin());
        id_at[at] = items.size();
        items.push_back(item);
        at += count;
    }
    id_at[words.size()] = items.size();
    for (Item& item : items) {
        if (jumps(item.in.op)) {
            item.target = id_at[item.coefficients[0]];
        }
    }
    return items;
}

/// The words; a jump whose target is gone goes to what stood behind it.
std::vector<std::uint32_t> words_of(const Items& items) {
    std::vector<std::size_t> starts;
    std::size_t size = 0;
    for (const Item& item : items) {
        starts.push_back(size);
        size += 1 + item.coefficient_count;
    }
    std::vector<std::uint32_t> words;
    words.reserve(size);
    for (const Item& item : items) {
        words.push_back(isa::encode(item.in));
        words.insert(
            words.end(), item.coefficients.begin(),
            item.coefficients.begin() + static_cast<std::ptrdiff_t>(item.coefficient_count));
        if (item.target != nowhere) {
            const auto behind = std::ranges::lower_bound(items, item.target, {}, &Item::id);
            words.back() = static_cast<std::uint32_t>(
                behind == items.end() ? size
                                      : starts[static_cast<std::size_t>(behind - items.begin())]);
        }
    }
    return words;
}

/// True if no instruction of these is the controller's business.
bool is_straight(const Items& items) {
    return std::ranges::none_of(
        items, [](const Item& item) { return (isa::info(item.in.op).effects & isa::flow) != 0; });
}

/// How many items lie before `word` of the program that they were made from.
std::size_t items_before(const Items& items, std::size_t word) {
    std::size_t at = 0, count = 0;
    for (; count < items.size() && at < word; ++count) {
        at += 1 + items[count].coefficient_count;
    }
    return count;
}

class Shrinker {
  public:
    Shrinker(std::span<const std::uint32_t> words, const Shows& shows)
        : shows_(shows), items_(items_of(words)) {}

    Shrunk run() {
        Shrunk shrunk;
        shrunk.instructions_before = items_.size();
        if (!try_items(items_)) {
            throw RequestError(ExitCode::failed,
                               "the program does not show what it is to be reduced to");
        }
        drop_jumps();
        drop([](const Item& item) { return item.group; });
        std::size_t count = 0;
        do {
            count = items_.size();
            drop([](const Item& item) { return item.id; });
            for (std::size_t i = 0; i < items_.size(); ++i) {
                simplify(i);
            }
            drop([](const Item& item) { return item.id; });
        } while (items_.size() < count);
        shrunk.words = words_of(items_);
        shrunk.instructions = items_.size();
        shrunk.tried = tried_;
        return shrunk;
    }

  private:
    bool try_items(const Items& items) {
        const std::vector<std::uint32_t> words = words_of(items);
        if (!isa::check(words).ok()) {
            return false;
        }
        ++tried_;
        return shows_(words);
    }

    /// Without a jump that depends on all pixels, one pixel can be run alone: see differ_at().
    void drop_jumps() {
        for (std::size_t i = 0; i < items_.size(); ++i) {
            if (items_[i].in.op == isa::Op::skip_if_none) {
                Items rest = items_;
                rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
                i -= accept(rest) ? 1 : 0;
            }
        }
    }

    /// Takes `items` for the program if they still show it.
    bool accept(const Items& items) {
        if (!try_items(items)) {
            return false;
        }
        items_ = items;
        return true;
    }

    /// Delta debugging in sweeps: drops stretches of units that are not needed, half of them at
    /// first, single ones at last. Units are the items of one key; keys ascend.
    template <typename Key>
    void drop(const Key& key) {
        for (std::size_t size = unit_count(key) / 2; size > 0; size /= 2) {
            for (std::size_t first = 0; first < unit_count(key);) {
                first += drop_units(first, first + size, key) ? 0 : size;
            }
        }
    }

    template <typename Key>
    std::size_t unit_count(const Key& key) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < items_.size(); ++i) {
            count += i == 0 || key(items_[i]) != key(items_[i - 1]) ? 1 : 0;
        }
        return count;
    }

    template <typename Key>
    bool drop_units(std::size_t first, std::size_t end, const Key& key) {
        Items rest;
        std::size_t unit = 0;
        for (std::size_t i = 0; i < items_.size(); ++i) {
            unit += i > 0 && key(items_[i]) != key(items_[i - 1]) ? 1 : 0;
            if (unit < first || unit >= end) {
                rest.push_back(items_[i]);
            }
        }
        return accept(rest);
    }

    // ---- coefficients and operands

    void simplify(std::size_t i) {
        if (items_[i].target == nowhere) {
            for (std::size_t k = 0; k < items_[i].coefficient_count; ++k) {
                lower(static_cast<std::int32_t>(items_[i].coefficients[k]),
                      [&](Items& items, std::int64_t value) {
                          items[i].coefficients[k] = static_cast<std::uint32_t>(value);
                      });
                lower_together(i, k);
            }
        }
        const isa::OpInfo& row = isa::info(items_[i].in.op);
        if (row.n_max != 0) {
            lower(items_[i].in.operands.n, [&](Items& items, std::int64_t value) {
                items[i].in.operands.n = static_cast<std::uint32_t>(value);
            });
        }
        if (row.pattern.b.mask != 0) {
            lower(items_[i].in.operands.b, [&](Items& items, std::int64_t value) {
                items[i].in.operands.b = static_cast<std::uint32_t>(value);
            });
        }
    }

    /// Likewise for all instructions with the same coefficients, which may have to be the same.
    void lower_together(std::size_t i, std::size_t k) {
        std::vector<std::size_t> same;
        for (std::size_t j = 0; j < items_.size(); ++j) {
            if (items_[j].coefficients == items_[i].coefficients) {
                same.push_back(j);
            }
        }
        if (same.size() > 1) {
            lower(static_cast<std::int32_t>(items_[i].coefficients[k]),
                  [&](Items& items, std::int64_t value) {
                      for (const std::size_t j : same) {
                          items[j].coefficients[k] = static_cast<std::uint32_t>(value);
                      }
                  });
        }
    }

    /// Brings a number nearer to 0: 0, halves, and for small ones one less.
    template <typename Set>
    void lower(std::int64_t value, const Set& set) {
        const auto attempt = [&](std::int64_t lower_value) {
            Items items = items_;
            set(items, lower_value);
            const bool taken = accept(items);
            value = taken ? lower_value : value;
            return taken;
        };
        if (value == 0 || attempt(0)) {
            return;
        }
        while (value / 2 != 0 && attempt(value / 2)) {
        }
        while (value > 1 && value <= max_single_steps && attempt(value - 1)) {
        }
    }

    /// Widths and the like are this small; single steps get nowhere with larger numbers.
    static constexpr std::int64_t max_single_steps = 64;
    const Shows& shows_;
    Items items_;
    std::size_t tried_ = 0;
};

}  // namespace

Shrunk shrink(std::span<const std::uint32_t> words, const Shows& shows) {
    return Shrinker(words, shows).run();
}

std::vector<std::uint32_t> whole_program(const renderer::RegionPlan& plan, const Divergence* last) {
    std::vector<std::uint32_t> program;
    for (std::size_t part = 0; part < plan.parts.size(); ++part) {
        if (last != nullptr && part > last->address.part) {
            break;
        }
        const renderer::Words words = plan.parts[part].segment.words;
        Items items = items_of(words);
        if (!items.empty() && items.back().in.op == isa::Op::eor) {
            items.pop_back();
        }
        if (std::ranges::any_of(items, [](const Item& i) { return i.in.op == isa::Op::eor; })) {
            throw RequestError(ExitCode::failed,
                               "a program that stops in its midst (EOR) cannot be one with others");
        }
        if (last != nullptr && part == last->address.part && is_straight(items)) {
            items.resize(std::min(items.size(),
                                  items_before(items, last->address.word) + last->instructions));
        }
        const auto offset = static_cast<std::uint32_t>(program.size());
        std::vector<std::uint32_t> moved = words_of(items);
        for (std::size_t at = 0; at < moved.size(); at += isa::instruction_words(moved[at])) {
            if (jumps(isa::decode(moved[at])->op)) {
                moved[at + 1] += offset;
            }
        }
        program.insert(program.end(), moved.begin(), moved.end());
    }
    return program;
}

renderer::RegionPlan plan_of_program(std::span<const std::uint32_t> words) {
    renderer::RegionPlan plan;
    renderer::RegionPlan::Part part;
    part.kind = PartKind::prologue;
    part.segment.words = words;
    plan.parts.push_back(part);
    return plan;
}

}  // namespace pxpl5::host::inspect
