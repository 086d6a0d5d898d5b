// pxpl5 trace ls and trace dump.
#include <fmt/format.h>

#include <limits>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/listing/region_listing.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/run_table.hpp"
#include "host/inspect/record/selected_messages.hpp"
#include "host/inspect/tools/tools.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr const char* how_to_see_more = "--all lists everything, --lines N lists more";

std::uint64_t lines_of(const DumpOptions& options) {
    return options.all ? std::numeric_limits<std::uint64_t>::max() : options.lines;
}

void dump_messages(const RecordedRun& run, const Selection& selection, std::uint64_t max_lines,
                   TextOutput& output) {
    const std::vector<MessageRef> messages = select_messages(run, selection);
    const std::uint64_t start_ns = start_of(run);
    output.line(
        "; clock: logical time at the sender; ms: wall time of the receipt since the first "
        "receipt");
    output.line(message_heading());
    std::uint64_t listed = 0;
    for (; listed < messages.size() && listed < max_lines; ++listed) {
        output.line(message_line(run, messages[listed], start_ns));
    }
    if (listed < messages.size()) {
        output.line(fmt::format("; {} of {} messages left out: {}",
                                grouped(messages.size() - listed), grouped(messages.size()),
                                how_to_see_more));
    }
    if (messages.empty()) {
        output.line("; no message is selected");
    }
}

/// The instructions of all selected regions.
class InstructionDump {
  public:
    InstructionDump(const RecordedRun& run, const DumpOptions& options, Selection selection,
                    TextOutput& output)
        : run_(run),
          options_(options),
          selection_(std::move(selection)),
          output_(output),
          left_(lines_of(options)) {}

    void put() {
        output_.put(listing_legend(!options_.pixel.empty()));
        for (const std::uint32_t number : run_.frames()) {
            if (selection_.has_frame(number)) {
                put_frame(run_.frame(number));
            }
        }
        if (left_out_ != 0 || regions_left_out_ != 0) {
            output_.line(fmt::format("; left out: {} instructions{}; {}", grouped(left_out_),
                                     regions_left_out_ == 0
                                         ? ""
                                         : fmt::format(", and {} regions that were not begun",
                                                       grouped(regions_left_out_)),
                                     how_to_see_more));
        }
        if (regions_ == 0) {
            throw RequestError(ExitCode::usage,
                               "no region is selected that was recorded completely; 'pxpl5 trace "
                               "ls' lists the frames and regions");
        }
    }

  private:
    void put_frame(const RecordedFrame& frame) {
        std::optional<RegionPlace> chosen;
        if (!options_.pixel.empty()) {
            chosen = frame.region_at(options_.pixel[0], options_.pixel[1]);
        }
        for (const RecordedRegion* region : selected_regions(frame, selection_)) {
            if (!chosen || chosen->number == region->place.number) {
                put_region(frame, *region);
            }
        }
        for (const std::string& missing : frame.missing) {
            output_.line(fmt::format("; frame {}: not recorded: {}", frame.number, missing));
        }
    }

    void put_region(const RecordedFrame& frame, const RecordedRegion& region) {
        ++regions_;
        if (left_ == 0) {
            ++regions_left_out_;
            return;
        }
        std::optional<RegionPixel> pixel;
        if (!options_.pixel.empty()) {
            pixel = {options_.pixel[0] - region.place.x0_px,
                     options_.pixel[1] - region.place.y0_px};
        }
        const ListedLines lines = list_region(frame, region, {selection_, pixel, left_}, output_);
        left_ -= lines.listed;
        left_out_ += lines.left_out;
    }

    const RecordedRun& run_;
    const DumpOptions& options_;
    Selection selection_;
    TextOutput& output_;
    std::uint64_t left_, left_out_ = 0, regions_left_out_ = 0, regions_ = 0;
};

/// True if the options select instructions and not messages.
bool asks_for_instructions(const DumpOptions& options) {
    const SelectionText& text = options.selection;
    return options.instructions || !options.pixel.empty() || !text.region.empty() ||
           !text.op.empty() || !text.slab.empty() || !text.surface.empty();
}

}  // namespace

int trace_ls(const RunOptions& options) {
    write(answer_of(table_of(open_run(options.run))), options.json ? Format::json : Format::text,
          options.output);
    return 0;
}

int trace_dump(const DumpOptions& options) {
    const Selection selection = parse_selection(options.selection);
    const bool instructions = asks_for_instructions(options);
    if (instructions && !selection.kinds.empty()) {
        throw RequestError(ExitCode::usage,
                           "--kind selects messages, and --region, --op, --slab, --surface, "
                           "--pixel and --instructions select instructions: not both are possible");
    }
    const RecordedRun run = open_run(options.run);
    TextOutput output(options.output);
    if (instructions) {
        InstructionDump(run, options, selection, output).put();
    } else {
        dump_messages(run, selection, lines_of(options), output);
    }
    output.finish();
    return 0;
}

}  // namespace pxpl5::host::inspect
