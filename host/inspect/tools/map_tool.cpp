// pxpl5 trace map: the map of a frame, as a picture or as numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/map/map_picture.hpp"
#include "host/inspect/map/map_values.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/tools.hpp"
#include "host/session/pictures/write_picture.hpp"

namespace pxpl5::host::inspect {

namespace {

/// One line about the numbers.
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
        return fmt::format("{}: {}: no pixel has a value\n", kind.title, kind.unit);
    }
    std::string text = fmt::format("{}: {}: {} to {}, at {} of {} pixels", kind.title, kind.unit,
                                   range.least, range.most, count, map.values.size());
    if (kind.scale == MapScale::count) {
        text += fmt::format(", mean {:.4g}", sum / static_cast<double>(count));
    }
    return text + "\n";
}

}  // namespace

int trace_map(const MapOptions& options) {
    const bool has_run = !options.map.empty();
    const MapKind kind = map_kind_of(has_run ? options.map : options.run);
    if (options.output.empty() && !options.raw) {
        throw RequestError(ExitCode::usage,
                           "give the file of the map with -o FILE.png, or --raw to print numbers");
    }
    if (!options.raw) {
        check_picture_suffix("-o", options.output);
    }
    const RecordedRun run = open_run(has_run ? options.run : "");
    const RecordedFrame frame = run.frame(one_frame(run, options.selection));
    for (const std::string& reason : frame.missing) {
        print_notice("note", fmt::format("{}; its regions are dark in the map", reason));
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
