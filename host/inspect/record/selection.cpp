#include "host/inspect/record/selection.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "host/base/error.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::string_view blanks = " \t";

[[noreturn]] void refuse(std::string_view option, std::string_view text, std::string_view wanted) {
    throw RequestError(ExitCode::usage,
                       fmt::format("--{} '{}'; it must be {}", option, text, wanted));
}

/// The words of all texts, which `separators` part.
std::vector<std::string> words_of(const std::vector<std::string>& texts,
                                  std::string_view separators) {
    std::vector<std::string> words;
    for (const std::string& text : texts) {
        for (std::size_t at = text.find_first_not_of(separators); at < text.size();) {
            const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
            words.push_back(text.substr(at, end - at));
            at = text.find_first_not_of(separators, end);
        }
    }
    return words;
}

std::optional<std::uint32_t> number(std::string_view text) {
    std::uint32_t value = 0;
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    return error == std::errc{} && at == end ? std::optional(value) : std::nullopt;
}

/// "7", "3-5", "3-" (and all after it).
Range parse_range(std::string_view option, std::string_view text) {
    constexpr std::string_view wanted = "a number, or a range such as 3-5 or 3-";
    const std::size_t dash = text.find('-');
    const auto from = number(text.substr(0, dash));
    std::optional<std::uint32_t> to = from;
    if (dash != std::string_view::npos) {
        const std::string_view rest = text.substr(dash + 1);
        to = rest.empty() ? std::numeric_limits<std::uint32_t>::max() : number(rest);
    }
    if (!from || !to) {
        refuse(option, text, wanted);
    }
    if (*from > *to) {
        refuse(option, text, fmt::format("a range that ascends, e.g. {}-{}", *to, *from));
    }
    return {*from, *to};
}

std::vector<Range> parse_ranges(std::string_view option, const std::vector<std::string>& texts) {
    std::vector<Range> ranges;
    for (const std::string& word : words_of(texts, " \t,")) {
        ranges.push_back(parse_range(option, word));
    }
    if (ranges.empty() && !texts.empty()) {
        refuse(option, texts.front(), "a number or a range");
    }
    return ranges;
}

Selection::Region parse_region(std::string_view text) {
    constexpr std::string_view wanted = "a region's number, or its column and row, e.g. 2,1";
    const std::size_t comma = text.find(',');
    const auto first = number(text.substr(0, comma));
    if (comma == std::string_view::npos && first) {
        return {first, 0, 0};
    }
    if (comma == std::string_view::npos) {
        refuse("region", text, wanted);
    }
    const auto row = number(text.substr(comma + 1));
    constexpr std::uint32_t most = 1U << 16;  // Regions of a frame have 16-bit numbers.
    if (!first || !row || *first >= most || *row >= most) {
        refuse("region", text, wanted);
    }
    return {std::nullopt, static_cast<int>(*first), static_cast<int>(*row)};
}

bool matches(const std::string& pattern, const std::string& name) {
    return fnmatch(pattern.c_str(), name.c_str(), FNM_CASEFOLD) == 0;
}

bool matches_any(const std::vector<std::string>& patterns, std::string_view name) {
    return patterns.empty() || std::ranges::any_of(patterns, [&](const std::string& pattern) {
               return matches(pattern, std::string(name));
           });
}

void check_ops(const std::vector<std::string>& patterns) {
    for (const std::string& pattern : patterns) {
        if (std::ranges::none_of(isa::op_table, [&](const isa::OpInfo& row) {
                return matches(pattern, std::string(row.name));
            })) {
            refuse("op", pattern,
                   "the name of an instruction, with * and ? for any part, e.g. TREE*");
        }
    }
}

void check_kinds(const std::vector<std::string>& patterns) {
    for (const std::string& pattern : patterns) {
        const char* const* names = bus::schema::EnumNamesBody();
        bool found = false;
        for (const char* const* name = names; *name != nullptr; ++name) {
            found = found || (name != names && matches(pattern, *name));  // The first is NONE.
        }
        if (!found) {
            refuse("kind", pattern,
                   "the name of a message, with * and ? for any part, e.g. Region*");
        }
    }
}

}  // namespace

bool Selection::has(const std::vector<Range>& ranges, std::uint32_t n) {
    return ranges.empty() ||
           std::ranges::any_of(ranges, [n](const Range& range) { return range.contains(n); });
}

bool Selection::has_region(std::uint32_t number, int column, int row) const {
    return regions.empty() || std::ranges::any_of(regions, [&](const Region& region) {
               return region.number ? *region.number == number
                                    : region.column == column && region.row == row;
           });
}

bool Selection::has_op(isa::Op op) const {
    return matches_any(ops, isa::info(op).name);
}

bool Selection::has_kind(std::string_view kind) const {
    return matches_any(kinds, kind);
}

Selection parse_selection(const SelectionText& text) {
    Selection selection;
    selection.frames = parse_ranges("frame", text.frame);
    selection.gps = parse_ranges("gp", text.gp);
    selection.renderers = parse_ranges("renderer", text.renderer);
    selection.surfaces = parse_ranges("surface", text.surface);
    selection.slabs = parse_ranges("slab", text.slab);
    for (const std::string& word : words_of(text.region, blanks)) {
        selection.regions.push_back(parse_region(word));
    }
    selection.ops = words_of(text.op, " \t,");
    selection.kinds = words_of(text.kind, " \t,");
    check_ops(selection.ops);
    check_kinds(selection.kinds);
    return selection;
}

}  // namespace pxpl5::host::inspect
