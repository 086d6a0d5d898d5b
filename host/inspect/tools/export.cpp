// pxpl5 trace export: a run as a timeline, a table or assembly files.
#include <fmt/format.h>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/listing/stream_files.hpp"
#include "host/inspect/listing/timeline.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/message_text.hpp"
#include "host/inspect/record/selected_messages.hpp"
#include "host/inspect/tools/tools.hpp"

namespace pxpl5::host::inspect {

namespace {

Fields fields_of(const RecordedRun& run, const MessageRef& ref) {
    const auto number = [](std::uint64_t n) { return static_cast<std::int64_t>(n); };
    const bus::schema::Header& header = ref.header();
    const bus::Message message = ref.load();
    Fields fields{{"clock", number(header.clock())},
                  {"source", run.node_name(header.source())},
                  {"destination", run.node_name(header.destination())},
                  {"sequence", number(header.sequence())},
                  {"kind", bus::kind_name(ref.at().kind())},
                  {"bytes", number(header.body_bytes())},
                  {"wall_ns", number(ref.at().wall_ns)},
                  {"departure_ns", number(header.departure_ns())},
                  {"arrival_ns", number(header.arrival_ns())},
                  {"channel", number(header.channel())}};
    const std::optional<std::uint32_t> frame = frame_of(message);
    fields.push_back({"frame", frame ? FieldValue(number(*frame)) : FieldValue(std::string())});
    fields.push_back({"what", describe(message)});
    return fields;
}

void put_messages(const RecordedRun& run, const Selection& selection, bool as_json,
                  TextOutput& output) {
    output.put(as_json ? "[" : "");
    bool is_first = true;
    for (const MessageRef& message : select_messages(run, selection)) {
        const Fields fields = fields_of(run, message);
        if (as_json) {
            output.put((is_first ? "\n" : ",\n") + json_text(fields));
        } else {
            output.put((is_first ? csv_heading(fields) : "") + csv_line(fields));
        }
        is_first = false;
    }
    output.put(as_json ? "\n]\n" : "");
}

void check(const ExportOptions& options) {
    const int asked = (options.chrome.empty() ? 0 : 1) + (options.messages.empty() ? 0 : 1) +
                      (options.streams.empty() ? 0 : 1);
    if (asked != 1) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("give one of --chrome FILE, --messages json|csv and --streams "
                        "FOLDER, not {}",
                        asked));
    }
    if (!options.messages.empty() && options.messages != "json" && options.messages != "csv") {
        throw RequestError(ExitCode::usage, fmt::format("--messages '{}'; it must be json or csv",
                                                        options.messages));
    }
    if (options.messages.empty() && !options.output.empty()) {
        throw RequestError(ExitCode::usage,
                           "-o goes with --messages; --chrome and --streams name "
                           "where they write");
    }
}

}  // namespace

int trace_export(const ExportOptions& options) {
    check(options);
    const Selection selection = parse_selection(options.selection);
    const RecordedRun run = open_run(options.run);
    if (!options.messages.empty()) {
        TextOutput output(options.output);
        put_messages(run, selection, options.messages == "json", output);
        output.finish();
    } else if (!options.chrome.empty()) {
        TextOutput output(options.chrome);
        const TimelineCounts counts = put_timeline(run, selection, options.events, output);
        output.finish();
        fmt::print(stderr, "{}: {} events{}\n", printable(options.chrome), grouped(counts.events),
                   counts.messages_left_out == 0
                       ? ""
                       : fmt::format("; {} messages left out: --events allows more, --frame and "
                                     "--kind select fewer",
                                     grouped(counts.messages_left_out)));
    } else {
        const StreamFiles files = write_streams(run, selection, options.streams);
        fmt::print(stderr, "{}: {} files of {} regions\n", printable(options.streams), files.files,
                   files.regions);
    }
    return 0;
}

}  // namespace pxpl5::host::inspect
