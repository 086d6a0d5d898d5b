#include "isa/isa_md.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::isa {
namespace {

/// Titles by the top four bits of the operation byte.
constexpr std::array<std::string_view, 6> group_titles = {"Enable",     "Tree",    "Memory",
                                                          "Arithmetic", "Backing", "Control"};

std::size_t group_of(const OpInfo& row) {
    return row.pattern.fixed_bits >> (op_byte_shift + 4);
}

std::string_view source_name(Source source) {
    return source == Source::published ? "published"
           : source == Source::derived ? "derived"
                                       : "designed";
}

std::string_view coefficients(const OpInfo& row) {
    return row.words == 0 ? "" : row.words == 1 ? " K" : row.words == 3 ? " A B C" : " A B C D E F";
}

/// The row's text with plain letters for its operands: "TREEgeZERO :n".
std::string plain_text(const OpInfo& row) {
    std::string out;
    for (const char c : row.text) {
        if (c != '{' && c != '}') {
            out += c;
        }
    }
    return out;
}

std::string effects_text(const OpInfo& row) {
    constexpr std::pair<Effects, std::string_view> names[] = {
        {mem, "memory"},      {carry, "carry"}, {enable, "enable"}, {flag, "flag"},
        {backing, "backing"}, {port, "port"},   {flow, "flow"}};
    std::string out;
    for (const auto& [bit, name] : names) {
        if ((row.effects & bit) != 0) {
            out += out.empty() ? "" : ", ";
            out += name;
        }
    }
    out = out.empty() ? "nothing" : out;
    return (row.effects & all) != 0 ? out + " (every pixel)" : out;
}

void put_row(std::string& out, const OpInfo& row) {
    const Operands narrow{0, 0, 1}, wide{0, 0, row.n_max};
    fmt::format_to(std::back_inserter(out),
                   "### `{}{}`\n\n{}\n\n`{}`{}\n\nChanges: {}. Cycles: `{}`{}. Source: {}.\n\n",
                   plain_text(row), coefficients(row), row.doc, row.picture,
                   row.n_max == 0 ? "" : fmt::format(", n is 1..{}", row.n_max), effects_text(row),
                   row.cycles_text,
                   row.n_max == 0 ? ""
                                  : fmt::format(" ({} for n = 1, {} for n = {}; b = 0)",
                                                row.cycles(narrow), row.cycles(wide), row.n_max),
                   source_name(row.source));
}

constexpr std::string_view head = R"(# The Renderer's instruction set

Made from `instructions.def` by `cmake --build BUILD --target isa_doc`; do not edit. What the
machine is, is told in `README.md`. No public source holds the original instruction list of
Pixel-Planes 5: this one is designed in its manner. `published` rows have a name or a meaning that
a public text gives, `derived` rows follow from published facts, `designed` rows are ours. All
cycle counts are ours.

## Words

A program is a row of 32-bit words: an instruction word, then its coefficients. The top byte of an
instruction word tells the row; the letters of a bit picture are its operands, `-` must be 0.

| in the text | means |
|---|---|
| `ma`, `mb` | a field of pixel memory that begins at bit a, b |
| `:n` | its width in bits |
| `>>b` | the fraction bits that the tree's result drops, 0..63 |
| `#b` | a number, 0..255 |
| `bsb` | block b of the backing store, 0..127 |
| `A B C`, `A B C D E F`, `K` | coefficient words, signed |

Q = A x + B y + C (+ D x^2 + E x y + F y^2) is exact in 64 bits; T = floor(Q / 2^b). Fields are
unsigned unless the sentence says signed; low bits are two's complement. Where fields overlap,
sources are read whole before the result is written. E is a pixel's enable bit; a test clears it
where it fails. A disabled pixel changes nothing, except where a row says "every pixel".

)";

}  // namespace

std::string isa_markdown() {
    std::string out(head);
    fmt::format_to(
        std::back_inserter(out),
        "Limits: {} bits of memory and {} blocks of {} bits a pixel; LOOP {} deep, CALL {} "
        "deep; {} words a program.\n\n",
        memory_bits, backing_blocks, backing_block_bits, max_loop_depth, max_call_depth,
        max_program_words);
    for (std::size_t group = 0; group < group_titles.size(); ++group) {
        fmt::format_to(std::back_inserter(out), "## {}\n\n", group_titles[group]);
        for (const OpInfo& row : op_table) {
            if (group_of(row) == group) {
                put_row(out, row);
            }
        }
    }
    out.pop_back();
    return out;
}

}  // namespace pxpl5::isa
