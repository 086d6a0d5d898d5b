#include "host/inspect/tools/map_tool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/map/map_picture.hpp"
#include "host/inspect/map/map_values.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/session/pictures/write_picture.hpp"

namespace pxpl5::host::inspect {

namespace {

/// One line that says what the numbers are.
std::string summary(const MapValues& map) {
    const MapInfo& kind = info(map.kind);
    if (kind.scale == MapScale::direction) {
        return fmt::format("{}: {}\n", kind.title, kind.unit);
    }
    double sum = 0;
    std::size_t count = 0;
    MapRange range{std::numeric_limits<std::int64_t>::max(), 0};
    for (const std::int64_t value : map.values) {
        if (value != no_value) {
            sum += static_cast<double>(value);
            count += 1;
            range = {std::min(range.least, value), std::max(range.most, value)};
        }
    }
    if (count == 0) {
        return fmt::format("{}: {}: no pixel has one\n", kind.title, kind.unit);
    }
    std::string text = fmt::format("{}: {}: {} to {}, at {} of {} pixels", kind.title, kind.unit,
                                   range.least, range.most, count, map.values.size());
    if (kind.scale == MapScale::count) {
        text += fmt::format(", mean {:.4g}", sum / static_cast<double>(count));
    }
    return text + "\n";
}

}  // namespace

std::uint32_t one_frame(const RecordedRun& run, const SelectionText& text) {
    const Selection selection = parse_selection(text);
    std::vector<std::uint32_t> selected;
    for (const std::uint32_t frame : run.frames()) {
        if (selection.has_frame(frame)) {
            selected.push_back(frame);
        }
    }
    if (selected.empty()) {
        const std::vector<std::uint32_t> all = run.frames();
        throw RequestError(ExitCode::usage,
                           all.empty() ? std::string("the run has no frame")
                                       : fmt::format("the run has no such frame; it has {} to {}",
                                                     all.front(), all.back()));
    }
    if (selected.size() > 1 && !selection.frames.empty()) {
        throw RequestError(ExitCode::usage, fmt::format("{} frames are selected; name one with "
                                                        "--frame, e.g. --frame {}",
                                                        selected.size(), selected.back()));
    }
    return selected.back();
}

int trace_map(const MapOptions& options) {
    const MapKind kind = map_kind_of(options.words.back());
    if (!options.raw && options.output.empty()) {
        throw RequestError(ExitCode::usage,
                           "a map is a picture: name its file with -o FILE.png, "
                           "or ask for the numbers with --raw");
    }
    if (!options.raw) {
        check_picture_suffix("-o", options.output);
    }
    const RecordedRun run = open_run(options.words.size() > 1 ? options.words.front() : "");
    const RecordedFrame frame = run.frame(one_frame(run, options.selection));
    for (const std::string& reason : frame.missing) {
        std::fputs(("note: " + reason + "; its regions stay dark\n").c_str(), stderr);
    }
    const MapValues map = map_values(frame, kind);
    if (options.raw) {
        TextOutput output(options.output);
        output.put(to_csv(map));
        output.finish();
        return 0;
    }
    const bool grid = options.grid || info(kind).per_region;
    const MapPicture picture =
        draw_map(map, {.grid = grid, .subject = fmt::format("frame {}", frame.number)});
    write_picture(options.output, {{picture.width, picture.height},
                                   picture.rgba,
                                   picture.marks,
                                   fmt::format("pxpl5 trace map {}", info(kind).name)});
    TextOutput output("");
    output.put(summary(map) + options.output + "\n");
    output.finish();
    return 0;
}

}  // namespace pxpl5::host::inspect
