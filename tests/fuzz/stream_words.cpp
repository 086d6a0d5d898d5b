#include "tests/fuzz/stream_words.hpp"

#include "isa/contract/triangle_shape.hpp"
#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::fuzz {

namespace {

using isa::Op;
namespace triangle = isa::triangle;

constexpr std::size_t max_words = 1024;

std::vector<std::uint32_t> raw_words(Bytes& bytes) {
    std::vector<std::uint32_t> words;
    while (!bytes.empty() && words.size() < max_words) {
        words.push_back(bytes.take<std::uint32_t>());
    }
    return words;
}

/// Builds a stream instruction by instruction.
class Builder {
  public:
    explicit Builder(Bytes& bytes) : bytes_(bytes) {}

    std::vector<std::uint32_t> build() {
        while (!bytes_.empty() && words_.size() < max_words) {
            const std::size_t choice = byte() % (isa::op_count + 1);
            begins_.push_back(words_.size());
            if (choice == isa::op_count) {
                add_triangle();
            } else {
                add(static_cast<Op>(choice));
            }
        }
        for (; open_loops_ > 0; --open_loops_) {
            begins_.push_back(words_.size());
            words_.push_back(isa::encode({Op::end_loop, {}}));
        }
        begins_.push_back(words_.size());
        for (const Jump& jump : jumps_) {
            const std::size_t last = begins_.size() - 1;
            const std::size_t to = jump.is_call ? jump.choice % begins_.size()
                                                : std::min(jump.from + 1 + jump.choice % 8, last);
            words_[jump.word] = static_cast<std::uint32_t>(begins_[to]);
        }
        return std::move(words_);
    }

  private:
    struct Jump {
        std::size_t word, from, choice;
        bool is_call;
    };

    std::size_t byte() { return bytes_.take<std::uint8_t>(); }

    /// A small, a large, an extreme or a sparse number.
    std::int32_t coefficient() {
        const auto first = bytes_.take<std::int8_t>();
        switch (static_cast<std::uint8_t>(first) & 3U) {
            case 0:
                return first >> 2;
            case 1:
                return bytes_.take<std::int16_t>();
            case 2:
                return bytes_.take<std::int32_t>();
            default:
                return static_cast<std::int32_t>((1U << (static_cast<unsigned>(first >> 2) & 31U)) -
                                                 (first < 0 ? 1U : 0U));
        }
    }

    /// An address at which `bits` fit.
    std::uint32_t address(std::uint32_t bits) {
        const std::size_t value = byte();
        return static_cast<std::uint32_t>(
            bits < isa::memory_bits ? value % (isa::memory_bits - bits + 1) : 0);
    }

    isa::Operands operands(const isa::OpInfo& row) {
        isa::Operands o;
        o.n = row.n_max == 0 ? 0 : 1 + static_cast<std::uint32_t>(byte() % row.n_max);
        if (row.pattern.a.mask != 0) {
            o.a = address(std::max(row.at_a(o), 1U));
        }
        if (row.pattern.b.mask != 0) {
            const bool is_address = row.b_role == isa::Role::address;
            o.b = is_address ? address(std::max(row.at_b(o), 1U))
                             : static_cast<std::uint32_t>(byte());
            o.b %= row.b_role == isa::Role::fraction ? isa::max_fraction_bits + 1
                   : row.b_role == isa::Role::block  ? isa::backing_blocks
                                                     : 256;
        }
        return o;
    }

    void add(Op op) {
        const isa::OpInfo& row = isa::info(op);
        if (op == Op::end_loop && open_loops_ == 0) {
            return;
        }
        isa::Operands o = operands(row);
        if (op == Op::loop) {
            o.b %= 5;
            ++open_loops_;
        }
        open_loops_ -= op == Op::end_loop ? 1 : 0;
        words_.push_back(isa::encode({op, o}));
        if (op == Op::call || op == Op::skip_if_none) {
            jumps_.push_back({words_.size(), begins_.size() - 1, byte(), op == Op::call});
        }
        for (int i = 0; i < row.words; ++i) {
            words_.push_back(static_cast<std::uint32_t>(coefficient()));
        }
        if (row.b_role == isa::Role::block) {
            words_.push_back(isa::encode({Op::bs_wait, {}}));
        }
    }

    /// A triangle as a GP sends it, which the fast executor runs as one step.
    void add_triangle() {
        std::array<std::uint32_t, triangle::word_count> words{};
        for (std::uint32_t& word : words) {
            word = static_cast<std::uint32_t>(coefficient());
        }
        words[triangle::at_enable] = triangle::enable_word;
        for (std::size_t k = 0; k < 3; ++k) {
            words.at(triangle::at_edge.at(k)) =
                triangle::edge_word(triangle::edge_widths.at(byte() % 3));
            words.at(triangle::at_normal.at(k)) = triangle::normal_words.at(k);
            words[triangle::at_z_store + 1 + k] = words[triangle::at_z_test + 1 + k];
        }
        words[triangle::at_z_test] = triangle::z_test_word;
        words[triangle::at_z_store] = triangle::z_store_word;
        words[triangle::at_surface] = triangle::surface_word(static_cast<std::uint32_t>(byte()));
        words_.insert(words_.end(), words.begin(), words.end());
    }

    Bytes& bytes_;
    std::vector<std::uint32_t> words_;
    std::vector<std::size_t> begins_;  ///< Word offsets of the instructions.
    std::vector<Jump> jumps_;
    int open_loops_ = 0;
};

}  // namespace

std::vector<std::uint32_t> stream_words(Bytes& bytes) {
    return bytes.take<std::uint8_t>() % 2 == 0 ? raw_words(bytes) : Builder(bytes).build();
}

}  // namespace pxpl5::fuzz
