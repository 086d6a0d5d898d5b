#include "tests/isa/coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "isa/sequencer.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/isa/conformance_suite.hpp"

namespace pxpl5::test {
namespace {

constexpr std::array<std::string_view, 4> enables_names = {"none", "inside", "edge", "all"};
constexpr std::array<char, 4> enables_letters = {'n', 'i', 'e', 'a'};
constexpr std::array<std::uint32_t, 5> last_of_class = {1, 8, 16, 32, 64};
constexpr int last = region_px - 1;

template <typename Action>
void each_cell(const Action& action) {
    for (std::size_t row = 0; row < isa::op_count; ++row) {
        for (std::size_t width = 0; width < width_classes(isa::op_table[row]); ++width) {
            for (std::size_t i = 0; i < enables_names.size(); ++i) {
                action(row, width, static_cast<Enables>(i));
            }
        }
    }
}

bool all_inside(const isa::Executor& executor) {
    for (int y = 1; y < last; ++y) {
        for (int x = 1; x < last; ++x) {
            if (!executor.enabled(x, y)) {
                return false;
            }
        }
    }
    return true;
}

std::string cell_text(const Coverage& coverage, std::size_t row, std::size_t width) {
    std::string text;
    for (std::size_t i = 0; i < enables_letters.size(); ++i) {
        text += coverage.has(row, width, static_cast<Enables>(i)) ? enables_letters[i] : '.';
    }
    return text;
}

void note_case(const ConformanceFile& file, Coverage& coverage) {
    renderer::fast::Fast fast;
    set_up(file.test.given, fast);
    isa::Controller controller;
    isa::Sequencer sequencer(file.test.program.words, fast, controller);
    try {
        while (!sequencer.done()) {
            coverage.note(*isa::decode(file.test.program.words[sequencer.at()]), enables_of(fast));
            sequencer.step();
        }
    } catch (const isa::RunError&) {
        // Some cases must stop with an error.
    }
}

}  // namespace

Enables enables_of(const isa::Executor& executor) {
    if (!executor.any_enabled()) {
        return Enables::none;
    }
    int at_edge = 0;
    for (int i = 0; i <= last; ++i) {
        at_edge += executor.enabled(i, 0) + executor.enabled(i, last) + executor.enabled(0, i) +
                   executor.enabled(last, i);
    }
    const bool all_at_edge = at_edge == 4 * (last + 1);
    return at_edge == 0                          ? Enables::inside
           : all_at_edge && all_inside(executor) ? Enables::all
                                                 : Enables::edge;
}

std::size_t width_class(std::uint32_t n) {
    return static_cast<std::size_t>(std::ranges::lower_bound(last_of_class, n) -
                                    last_of_class.begin());
}

std::size_t width_classes(const isa::OpInfo& row) {
    return width_class(row.n_max) + 1;
}

std::size_t Coverage::cells() const {
    std::size_t count = 0;
    each_cell([&](auto row, auto width, auto enables) { count += has(row, width, enables); });
    return count;
}

std::size_t possible_cells() {
    std::size_t count = 0;
    each_cell([&](auto, auto, auto) { ++count; });
    return count;
}

std::vector<std::string> open_cells(const Coverage& coverage) {
    std::vector<std::string> open;
    each_cell([&](std::size_t row, std::size_t width, Enables enables) {
        if (!coverage.has(row, width, enables)) {
            open.push_back(fmt::format("{}, width {}, {}", isa::op_table[row].name,
                                       width_names[width],
                                       enables_names[static_cast<std::size_t>(enables)]));
        }
    });
    return open;
}

Coverage coverage_of_suite() {
    Coverage coverage;
    for (const ConformanceFile& file : conformance_suite()) {
        note_case(file, coverage);
    }
    return coverage;
}

std::string coverage_markdown(const Coverage& suite, const Coverage& phantoms) {
    std::string out = fmt::format(
        "# What the conformance suite covers\n\n"
        "Made by `PXPL5_UPDATE_GOLDEN=1 ctest --preset release -R isa_coverage`; do not edit.\n\n"
        "Each cell shows the suite, then the frames of the phantoms. A letter is the set of "
        "enabled "
        "pixels\nwhen the instruction ran:\n\n"
        "- `n`: none\n- `i`: some, all of them inside the region\n"
        "- `e`: some, including pixels at the edge (x or y is 0 or 127)\n- `a`: all\n"
        "- `.`: not met\n\nRows without a width are in column 1.\n\n"
        "The suite meets {1} of {0} cells, and the phantoms meet {2}.\n\n| instruction |",
        possible_cells(), suite.cells(), phantoms.cells());
    const auto put = std::back_inserter(out);
    for (const std::string_view width : width_names) {
        fmt::format_to(put, " {} |", width);
    }
    out += "\n|---|---|---|---|---|---|\n";
    for (std::size_t row = 0; row < isa::op_count; ++row) {
        fmt::format_to(put, "| `{}` |", isa::op_table[row].name);
        for (std::size_t width = 0; width < width_names.size(); ++width) {
            const bool has_cell = width < width_classes(isa::op_table[row]);
            out += has_cell ? fmt::format(" `{} {}` |", cell_text(suite, row, width),
                                          cell_text(phantoms, row, width))
                            : " |";
        }
        out += '\n';
    }
    return out;
}

}  // namespace pxpl5::test
