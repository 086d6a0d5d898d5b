#include "isa/disassemble.hpp"

#include <fmt/format.h>

#include <iterator>

#include "isa/program.hpp"

namespace pxpl5::isa {
namespace {

/// Returns the row's text with the operands: "{a}" becomes the number.
std::string filled_text(const OpInfo& row, const Operands& o) {
    std::string out;
    for (std::size_t i = 0; i < row.text.size(); ++i) {
        if (row.text[i] != '{') {
            out += row.text[i];
            continue;
        }
        const char operand = row.text[i + 1];
        out += std::to_string(operand == 'a' ? o.a : operand == 'b' ? o.b : o.n);
        i += 2;
    }
    return out;
}

}  // namespace

std::string disassemble(Instruction in, Coefficients coefficients) {
    std::string out = filled_text(info(in.op), in.operands);
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
        fmt::format_to(std::back_inserter(out), "{}{}", i == 0 ? "  " : " ", coefficients[i]);
    }
    return out;
}

std::string disassemble(std::span<const std::uint32_t> words, ListingOptions options) {
    std::string out;
    const auto put = std::back_inserter(out);
    for (std::size_t at = 0; at < words.size();) {
        const std::uint32_t word = words[at];
        const std::optional<Instruction> in = decode(word);
        const std::size_t length = instruction_words(word);
        const bool whole = in && length <= words.size() - at;
        if (options.numbered) {
            fmt::format_to(put, "{:6}  {:08x}  {:>6}  ", at, word,
                           whole ? std::to_string(info(in->op).cycles(in->operands)) : "-");
        }
        if (whole) {
            out += disassemble(*in, signed_words(words.subspan(at + 1, length - 1)));
        } else {
            fmt::format_to(put, "; 0x{:08x} {}", word,
                           in ? "has too few coefficient words" : "is not an instruction");
        }
        out += '\n';
        at += whole ? length : 1;
    }
    return out;
}

}  // namespace pxpl5::isa
