#include "isa/isa_md.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "isa/assemble.hpp"
#include "isa/executor.hpp"
#include "isa/program.hpp"

namespace pxpl5::isa {
namespace {

/// A group of instructions, with an example of their use.
struct Group {
    std::string_view title, example;
};

/// Ordered by the top four bits of the operation byte.
constexpr std::array<Group, 6> groups = {{
    {"Enable", R"(; Enables the pixels with bit m3 set, except those with bit m4 set.
SETENABS
ENABandeqMEM m3
ENABandeqNOTMEM m4
)"},
    {"Tree",
     R"(; Stores 2 x - y + 100 where it is less than m8:24. The coefficients have 8 fraction bits.
SETENABS
TREEltMEM m8:24 >>8  512 -256 25600
TREEintoMEM m8:24 >>8  512 -256 25600
)"},
    {"Memory", R"(; Copies m0:16 to m32:16, then stores 255 where the copy is 1000 or more.
SETENABS
MEMintoMEM m0 m32:16
MEMgeCONST m32:16  1000
IMMintoMEM m32:16 #255
)"},
    {"Arithmetic", R"(; Stores the length of the vector (m0:16, m16:16) at m64:16.
SETENABS
MULCONST m32:16 m0  1           ; m32:32 = m0, sign-extended to 32 bits
MULMEMsigned m32:16 m0          ; m32:32 = m0 * m0
MULCONST m64:16 m16  1
MULMEMsigned m64:16 m16
MEMpluseqMEM m64:32 m32
SQRTMEM m64:32
)"},
    {"Backing", R"(; Saves m0:32 in block 5 of the backing store and loads block 6 to m32:32.
SETENABS
BSWRITE m0 bs5
BSREAD m32 bs6
BSWAIT                          ; m0, m32 and both blocks may be used again
)"},
    {"Control",
     R"(; Adds 3 four times where m0:8 is 7, and skips the loop if no pixel has this value.
SETENABS
MEMeqCONST m0:8  7
ANYENAB
SKIPIFNONE done
LOOP #4
  MEMpluseqCONST m8:8  3
ENDLOOP
done:
  PIXELSTOFB m8:8
)"},
}};

std::size_t group_of(const OpInfo& row) {
    return row.pattern.fixed_bits >> (op_byte_shift + 4);
}

std::string_view source_name(Source source) {
    return source == Source::published ? "published"
           : source == Source::derived ? "derived"
                                       : "designed";
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
                   "### `{}`\n\n{}\n\n`{}`{}\n\nChanges: {}. Cycles: `{}`{}. Source: {}.\n\n",
                   syntax_of(row), row.doc, row.picture,
                   row.n_max == 0 ? "" : fmt::format(", n is 1..{}", row.n_max), effects_text(row),
                   row.cycles_text,
                   row.n_max == 0 ? ""
                                  : fmt::format(" ({} for n = 1, {} for n = {}; b = 0)",
                                                row.cycles(narrow), row.cycles(wide), row.n_max),
                   source_name(row.source));
}

constexpr std::string_view head = R"(# The Renderer's instruction set

Made from `instructions.def` by `cmake --build BUILD --target isa_doc`; do not edit. `README.md`
describes the machine. `ASSEMBLER.md` describes the assembler, with complete programs.

No public source holds the original instruction list of Pixel-Planes 5. This instruction set is
designed in the manner of the original. The source of each row is one of these:

| source | meaning |
|---|---|
| published | a public text gives the name or the meaning |
| derived | the row follows from published facts |
| designed | the row is ours |

All cycle counts are ours.

## Words

A program is a sequence of 32-bit words. Each instruction is an instruction word and its coefficient
words. The top byte of an instruction word selects the row. In a bit picture, the letters are
operands, and `-` must be 0.

| in the text | meaning |
|---|---|
| `ma`, `mb` | a field of pixel memory that begins at bit a or b |
| `:n` | the width of the field in bits |
| `>>b` | the fraction bits that the tree's result drops, 0..63 |
| `#b` | a number, 0..255 |
| `bsb` | block b of the backing store, 0..127 |
| `A B C`, `A B C D E F`, `K` | coefficient words, signed |

- Q = A x + B y + C (+ D x^2 + E x y + F y^2), exact in 64 bits. T = floor(Q / 2^b).
- Fields are unsigned unless the sentence says signed. Low bits are two's complement.
- If fields overlap, the instruction reads all sources before it writes the result.
- E is the enable bit of a pixel. A test clears E where the test fails.
- A disabled pixel does not change, unless the row says "every pixel".

)";

}  // namespace

std::string isa_markdown() {
    std::string out(head);
    fmt::format_to(
        std::back_inserter(out),
        "Limits: {} bits of memory and {} blocks of {} bits per pixel. LOOP nests {} deep and CALL "
        "{} deep.\nA program has at most {} words.\n\n",
        memory_bits, backing_blocks, backing_block_bits, max_loop_depth, max_call_depth,
        max_program_words);
    for (std::size_t group = 0; group < groups.size(); ++group) {
        fmt::format_to(std::back_inserter(out), "## {}\n\n```pxasm\n{}```\n\n", groups[group].title,
                       groups[group].example);
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
