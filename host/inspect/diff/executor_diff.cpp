#include "host/inspect/diff/executor_diff.hpp"

#include <algorithm>
#include <vector>

#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::host::inspect {

namespace {

using Part = renderer::RegionPlan::Part;

/// Primitives of one chunk, the middle size of piece.
constexpr std::size_t chunk_units = 64;

/// Words of a part that run in one go.
struct Piece {
    Address address;
    std::size_t word_count = 0, instructions = 0;
};

/// True if the words run from the first to the last, each once: they can be run in pieces.
bool is_straight(renderer::Words words) {
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        const isa::Instruction in = *isa::decode(words[at]);
        if ((isa::info(in.op).effects & isa::flow) != 0) {
            return false;
        }
    }
    return true;
}

std::size_t count_instructions(renderer::Words words) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        ++count;
    }
    return count;
}

/// The piece's words: from one SETENABS to the next.
std::vector<Piece> units_of(std::size_t part, renderer::Words words) {
    std::vector<Piece> units;
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t count = isa::instruction_words(words[at]);
        if (units.empty() || words[at] == isa::triangle::enable_word) {
            units.push_back({{part, at}, 0, 0});
        }
        units.back().word_count += count;
        units.back().instructions += 1;
        at += count;
    }
    return units;
}

/// `count` pieces from `first` on, as one.
Piece joined(const std::vector<Piece>& pieces, std::size_t first, std::size_t count) {
    Piece sum = pieces[first];
    for (std::size_t i = first + 1; i < first + count; ++i) {
        sum.word_count += pieces[i].word_count;
        sum.instructions += pieces[i].instructions;
    }
    return sum;
}

/// A search in one region. Every probe runs the region from its beginning on new executors.
class Search {
  public:
    Search(const renderer::RegionPlan& plan, const MakeExecutor& first, const MakeExecutor& second)
        : plan_(plan), make_first_(first), make_second_(second) {
        for (std::size_t part = 0; part < plan.parts.size(); ++part) {
            const renderer::Words words = plan.parts[part].segment.words;
            const std::vector<std::uint32_t> blocks = blocks_of(words);
            blocks_.insert(blocks_.end(), blocks.begin(), blocks.end());
            if (!words.empty()) {
                whole_.push_back({{part, 0}, words.size(), count_instructions(words)});
            }
        }
        std::ranges::sort(blocks_);
        blocks_.erase(std::ranges::unique(blocks_).begin(), blocks_.end());
    }

    std::optional<Divergence> run() {
        const std::optional<std::size_t> part = probe(whole_, 0);
        if (!part) {
            return std::nullopt;
        }
        const std::size_t number = whole_[*part].address.part;
        const std::vector<Piece> before(whole_.begin(),
                                        whole_.begin() + static_cast<std::ptrdiff_t>(*part));
        if (!is_straight(plan_.parts[number].segment.words)) {
            if (!single_steps(before, whole_[*part])) {
                probe_behind(before, {whole_[*part]});
                note(whole_[*part]);
            }
            return found_;
        }
        in_pieces(before, number);
        return found_;
    }

  private:
    /// Narrows a straight part down: chunks of primitives, primitives, instructions.
    void in_pieces(std::vector<Piece> before, std::size_t part) {
        const std::vector<Piece> units = units_of(part, plan_.parts[part].segment.words);
        std::vector<Piece> chunks;
        for (std::size_t i = 0; i < units.size(); i += chunk_units) {
            chunks.push_back(joined(units, i, std::min(chunk_units, units.size() - i)));
        }
        const std::optional<std::size_t> chunk = probe_behind(before, chunks);
        if (!chunk) {
            return note_together(before, units, 0, units.size());
        }
        before.insert(before.end(), chunks.begin(),
                      chunks.begin() + static_cast<std::ptrdiff_t>(*chunk));
        const std::size_t first = *chunk * chunk_units;
        const std::size_t count = std::min(chunk_units, units.size() - first);
        const auto begin = units.begin() + static_cast<std::ptrdiff_t>(first);
        const std::vector<Piece> in_chunk(begin, begin + static_cast<std::ptrdiff_t>(count));
        const std::optional<std::size_t> unit = probe_behind(before, in_chunk);
        if (!unit) {
            return note_together(before, units, first, count);
        }
        before.insert(before.end(), in_chunk.begin(),
                      in_chunk.begin() + static_cast<std::ptrdiff_t>(*unit));
        const Piece& piece = in_chunk[*unit];
        if (!single_steps(before, piece)) {
            probe_behind(before, {piece});
            note(piece);
        }
    }

    /// Pieces that differ only if run together: the fewest of them from the first one on.
    void note_together(const std::vector<Piece>& before, const std::vector<Piece>& units,
                       std::size_t first, std::size_t count) {
        std::size_t agree = 1, differ = count;
        while (differ - agree > 1) {
            const std::size_t middle = agree + (differ - agree) / 2;
            (probe_behind(before, {joined(units, first, middle)}) ? differ : agree) = middle;
        }
        const Piece piece = joined(units, first, differ);
        probe_behind(before, {piece});
        note(piece);
    }

    std::optional<std::size_t> probe_behind(const std::vector<Piece>& before,
                                            const std::vector<Piece>& pieces) {
        std::vector<Piece> all = before;
        all.insert(all.end(), pieces.begin(), pieces.end());
        const std::optional<std::size_t> at = probe(all, before.size());
        return at ? std::optional(*at - before.size()) : std::nullopt;
    }

    /// A plan that runs these pieces, each by itself.
    renderer::RegionPlan plan_of(const std::vector<Piece>& pieces) const {
        renderer::RegionPlan plan;
        for (const Piece& piece : pieces) {
            Part part = plan_.parts[piece.address.part];
            part.segment.words = part.segment.words.subspan(piece.address.word, piece.word_count);
            plan.parts.push_back(part);
        }
        return plan;
    }

    /// Runs the pieces on both executors and compares after each from `from` on: the first that
    /// leaves a difference, which is kept.
    std::optional<std::size_t> probe(const std::vector<Piece>& pieces, std::size_t from) {
        const auto first = make_first_(), second = make_second_();
        ExecutorPair pair(*first, *second);
        const renderer::RegionPlan plan = plan_of(pieces);
        RegionWalk first_walk(plan, *first), second_walk(plan, *second);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            first_walk.run_part();
            second_walk.run_part();
            if (i >= from && keep_difference(pair)) {
                return i;
            }
        }
        return std::nullopt;
    }

    /// Runs `before`, then the instructions of `piece` one by one. False if no difference shows.
    bool single_steps(const std::vector<Piece>& before, const Piece& piece) {
        const auto first = make_first_(), second = make_second_();
        ExecutorPair pair(*first, *second);
        std::vector<Piece> pieces = before;
        pieces.push_back(piece);
        const renderer::RegionPlan plan = plan_of(pieces);
        RegionWalk first_walk(plan, *first), second_walk(plan, *second);
        for (std::size_t i = 0; i < before.size(); ++i) {
            first_walk.run_part();
            second_walk.run_part();
        }
        while (!first_walk.done() && !second_walk.done() && first_walk.at() == second_walk.at()) {
            const std::size_t word = piece.address.word + first_walk.at().word;
            first_walk.step();
            second_walk.step();
            if (keep_difference(pair)) {
                note({{piece.address.part, word}, 1, 1});
                return true;
            }
        }
        return false;
    }

    bool keep_difference(const ExecutorPair& pair) {
        const std::optional<StateBit> bit = pair.difference(blocks_);
        if (bit) {
            last_ = {{}, 1, *bit, value_at(pair, false, *bit), value_at(pair, true, *bit)};
        }
        return bit.has_value();
    }

    void note(const Piece& piece) {
        found_ = last_;
        found_->address = piece.address;
        found_->instructions = piece.instructions;
    }

    const renderer::RegionPlan& plan_;
    const MakeExecutor &make_first_, &make_second_;
    std::vector<Piece> whole_;
    std::vector<std::uint32_t> blocks_;
    Divergence last_;
    std::optional<Divergence> found_;
};

}  // namespace

std::optional<Divergence> first_divergence(const renderer::RegionPlan& plan,
                                           const MakeExecutor& make_first,
                                           const MakeExecutor& make_second) {
    return Search(plan, make_first, make_second).run();
}

}  // namespace pxpl5::host::inspect
