// Assembles the region programs' texts to constants for texts.hpp. Part of the build.
//
//     pxpl5_assemble_texts OUTPUT registers.pxasm NAME.pxasm...
//
// A text NAME_n.pxasm gives NAME_x, NAME_y and NAME_z, one for each of the registers X, Y and Z,
// which the text calls N. A text NAME_s.pxasm gives NAME_4 and NAME_16, one for each number of
// passes. If a text is not a program, prints the error and exits with 1.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "isa/assemble.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/contract/screen_door.hpp"

namespace {

using namespace pxpl5;

std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw std::runtime_error("cannot be read");
    }
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns definitions of the fields of region_layout.hpp and screen_door.hpp.
std::string layout_names() {
    namespace region = isa::region;
    namespace door = isa::door;
    std::string names;
    const auto name = [&](const char* text, std::uint32_t address) {
        names += fmt::format(".def {} {}\n", text, address);
    };
    name("surface", region::surface.address);
    name("z", region::z.address);
    name("normal_x", region::normal_x.address);
    name("normal_y", region::normal_y.address);
    name("normal_z", region::normal_z.address);
    name("rgb", region::rgb.address);
    name("kept_z", door::kept_z.address);
    name("rank", door::rank.address);
    name("shut", door::shut);
    return names;
}

/// Returns a program as the constant `name`.
std::string constant(const std::string& name, const isa::Program& program) {
    std::string words, open;
    for (const std::uint32_t word : program.words) {
        words += fmt::format("{:#010x}, ", word);
    }
    for (const isa::Program::Patch& patch : program.patches) {
        if (patch.is_operand) {
            throw std::runtime_error("$" + patch.name + " is no coefficient");
        }
        open += fmt::format("Open{{\"{}\", {}}}, ", patch.name, patch.word);
    }
    return fmt::format("inline constexpr Text<{}, {}> {} = {{{{{}}}, {{{}}}}};\n",
                       program.words.size(), program.patches.size(), name, words, open);
}

/// Returns definitions of the sums of S = 2^shift passes: three of 8 + shift bits, and half of S in
/// each.
/// bits   Distance of the sums: 10, so that three fill a word; 16, so that none crosses a word.
/// words  Bits of all words that hold sums.
std::string sum_names(int shift, int bits, int words) {
    const int half = 1 << (shift - 1);
    return fmt::format(
        ".def shift {}\n.def words {}\n.def green T+{}\n.def blue T+{}\n"
        ".def halves {}\n.def half_blue {}\n",
        shift, words, bits, 2 * bits,
        half + (half << bits) + (words == 32 ? half << (2 * bits) : 0), words == 32 ? 0 : half);
}

/// Returns all constants of the text at `path`.
std::string constants(const std::filesystem::path& path, const std::string& names) {
    const std::string name = path.stem().string();
    const std::string text = read(path);
    if (name.ends_with("_s")) {
        const std::string base = name.substr(0, name.size() - 1);
        return constant(base + "4", isa::assemble(names + sum_names(2, 10, 32) + text)) +
               constant(base + "16", isa::assemble(names + sum_names(4, 16, 64) + text));
    }
    if (!name.ends_with("_n")) {
        return constant(name, isa::assemble(names + text));
    }
    std::string all;
    for (const char axis : {'x', 'y', 'z'}) {
        const std::string place = fmt::format(".def N {:c}\n", axis - 'x' + 'X');
        all +=
            constant(name.substr(0, name.size() - 1) + axis, isa::assemble(names + place + text));
    }
    return all;
}

}  // namespace

int main(int count, char** arguments) {
    constexpr int first_text = 3;
    if (count < first_text) {
        fmt::print(stderr, "usage: {} OUTPUT registers.pxasm NAME.pxasm...\n", arguments[0]);
        return 64;
    }
    const char* at = arguments[2];
    try {
        const std::string names = layout_names() + read(at);
        std::string code;
        for (int i = first_text; i < count; ++i) {
            at = arguments[i];
            code += constants(at, names);
        }
        at = arguments[1];
        std::ofstream output(at, std::ios::binary);
        output << code;
        if (!output.flush()) {
            throw std::runtime_error("cannot be written");
        }
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}: {}\n", at, error.what());
        return 1;
    }
    return 0;
}
