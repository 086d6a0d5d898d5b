// Shares counted work out evenly, remainders going round.
#pragma once

#include <cstdint>

namespace pxpl5::host::timing {

/// A share of a segment or of a list.
struct Hand {
    std::size_t gp = 0;
    std::uint64_t primitives = 0, words = 0, cycles = 0;
};

/// Deals one list after the other; where one ends the next goes on.
class Deal {
  public:
    explicit Deal(std::size_t gps) : gps_(gps) {}

    /// Gives everyone primitives / gps of them, and what is left over to the next in turn. Words
    /// and cycles go with the primitives. Calls `give` with every share that is not empty; their
    /// sums are the whole. Words that belong to no primitive are one share.
    template <class Give>
    void operator()(const Hand& whole, Give give) {
        const std::uint64_t primitives = whole.primitives > 0 ? whole.primitives : 1;
        const std::uint64_t each = primitives / gps_, over = primitives % gps_;
        const std::uint64_t shares = each > 0 ? gps_ : over;
        std::uint64_t before = 0;
        Hand given;
        for (std::uint64_t i = 0; i < shares; ++i) {
            before += each + (i < over ? 1 : 0);
            const Hand next{0, before, part(whole.words, before, primitives),
                            part(whole.cycles, before, primitives)};
            give(Hand{(next_ + i) % gps_,
                      whole.primitives > 0 ? next.primitives - given.primitives : 0,
                      next.words - given.words, next.cycles - given.cycles});
            given = next;
        }
        next_ = (next_ + over) % gps_;
    }

    /// floor(amount * before / all), without running over.
    static std::uint64_t part(std::uint64_t amount, std::uint64_t before, std::uint64_t all) {
        return amount / all * before + amount % all * before / all;
    }

  private:
    std::size_t gps_;
    std::size_t next_ = 0;
};

}  // namespace pxpl5::host::timing
