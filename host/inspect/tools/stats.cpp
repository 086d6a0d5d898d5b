// pxpl5 trace stats: counts of instructions, cycles and messages.
#include <fmt/format.h>

#include <algorithm>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "host/inspect/tools/tools.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr double cycles_per_ms = 40e3;  ///< The pixel processors run at 40 MHz.

/// Counts by name, in the order in which the names come.
template <typename Count>
struct Sums {
    std::vector<std::pair<std::string, Count>> list{};

    Count& operator[](const std::string& name) {
        for (auto& [other, count] : list) {
            if (other == name) {
                return count;
            }
        }
        return list.emplace_back(name, Count{}).second;
    }
};

struct PartSum {
    OpCount count;
    std::uint64_t primitives = 0;
};

const char* group_of(const PartCounts& part) {
    using Kind = PartKind;
    switch (part.kind) {
        case Kind::shut_door:
        case Kind::open_door:
            return "screen doors";
        case Kind::end_of_region:
            return "end of region";
        case Kind::segment:
            return "segments";
        default:
            return kind_name(part.kind);
    }
}

/// One row per sum. `total` is what percentages count from.
Table table_of(const std::string& name, const Sums<PartSum>& sums, const OpCount& total,
               bool has_primitives) {
    std::string key = "by_" + name;
    std::ranges::replace(key, ' ', '_');
    Table table{key,
                {{"name", name},
                 {"instructions", "instructions"},
                 {"cycles", "cycles"},
                 {"", "% of cycles"},
                 {"", "ms at 40 MHz"},
                 {"words", "words"},
                 {"primitives", has_primitives ? "primitives" : ""}}};
    for (const auto& [row, sum] : sums.list) {
        const auto cycles = static_cast<double>(sum.count.cycles);
        const double all = static_cast<double>(std::max<std::uint64_t>(total.cycles, 1));
        table.rows.push_back({row, grouped_cell(sum.count.instructions),
                              grouped_cell(sum.count.cycles), fixed_cell(100 * cycles / all, 1),
                              fixed_cell(cycles / cycles_per_ms, 3), grouped_cell(sum.count.words),
                              grouped_cell(sum.primitives)});
    }
    return table;
}

template <typename Name>
Table table_by(const RunStats& stats, const std::string& what, const OpCount& total,
               const Name& name_of_part) {
    Sums<PartSum> sums;
    for (const PartCounts& part : stats.parts) {
        PartSum& sum = sums[name_of_part(part)];
        sum.count += part.total();
        sum.primitives += part.primitives;
    }
    // Sorts gp-9 before gp-10, and both before "prologue".
    std::ranges::sort(sums.list, {},
                      [](const auto& row) { return std::pair(row.first.size(), row.first); });
    return table_of(what, sums, total, true);
}

template <typename Name>
Table table_by_op(const RunStats& stats, const std::string& what, const OpCount& total,
                  const Name& name_of_op) {
    Sums<PartSum> sums;
    for (std::size_t op = 0; op < isa::op_count; ++op) {
        OpCount count;
        for (const PartCounts& part : stats.parts) {
            count += part.ops[op];
        }
        if (count != OpCount{}) {
            sums[std::string(name_of_op(static_cast<isa::Op>(op)))].count += count;
        }
    }
    return table_of(what, sums, total, false);
}

/// "gp" of "gp-3".
std::string role_of(const std::string& node) {
    return node.substr(0, node.rfind('-'));
}

/// Messages summed by one of kind, source, destination and channel.
template <typename Name>
Table messages_by(const RunStats& stats, const char* what, const Name& name) {
    Sums<MessageCount> sums;
    for (const auto& [way, count] : stats.messages) {
        sums[name(way)] += count;
    }
    Table table{"", {{"", what}, {"", "messages"}, {"", "bytes"}, {"", "words on the ring"}}};
    for (const auto& [row, count] : sums.list) {
        table.rows.push_back({row, grouped_cell(count.messages), grouped_cell(count.bytes),
                              grouped_cell(count.words)});
    }
    return table;
}

Table all_messages(const RecordedRun& run, const RunStats& stats) {
    Table table{"messages",
                {{"kind", ""},
                 {"source", ""},
                 {"destination", ""},
                 {"channel", ""},
                 {"messages", ""},
                 {"bytes", ""},
                 {"words", ""}}};
    for (const auto& [way, count] : stats.messages) {
        table.rows.push_back({bus::kind_name(way.kind), run.node_name(way.source),
                              run.node_name(way.destination), way.channel, count.messages,
                              count.bytes, count.words});
    }
    return table;
}

void add_messages(const RecordedRun& run, const RunStats& stats, Answer& answer) {
    const auto name = [&](bus::NodeId node) { return run.node_name(node); };
    for (const Table& table :
         {messages_by(stats, "kind", [](const auto& w) { return bus::kind_name(w.kind); }),
          messages_by(stats, "from", [&](const auto& w) { return name(w.source); }),
          messages_by(stats, "to", [&](const auto& w) { return name(w.destination); }),
          messages_by(stats, "between",
                      [&](const auto& w) {
                          return role_of(name(w.source)) + " -> " + role_of(name(w.destination));
                      }),
          messages_by(stats, "channel",
                      [](const auto& w) { return fmt::format("{}", w.channel); })}) {
        answer.table(table).line("");
    }
    answer.table(all_messages(run, stats));
}

Answer answer_of(const RecordedRun& run, const RunStats& stats) {
    OpCount total;
    for (const PartCounts& part : stats.parts) {
        total += part.total();
    }
    Answer answer;
    answer
        .line(fmt::format("{}: {} instructions, {} cycles of the pixel processors (40 MHz)",
                          counted(stats.regions, "region"), grouped(total.instructions),
                          grouped(total.cycles)))
        .data("regions", stats.regions)
        .data("instructions", total.instructions)
        .data("cycles", total.cycles)
        .data("words", total.words)
        .data("regions_told", stats.told)
        .data("differences", stats.differences.size());
    if (stats.told != 0) {
        answer.line(fmt::format("The counts of {} {} the counts that their Renderers reported.",
                                counted(stats.told, "region"),
                                stats.differences.empty() ? "equal" : "do not all equal"));
    }
    for (const std::string& sentence : stats.differences) {
        answer.line(sentence);
    }
    answer.sentences("missing", "reason", "Not recorded: ", stats.missing);
    answer
        .line(
            "words: length of the streams, where the body of a loop counts once; primitives: "
            "from one SETENABS to the next")
        .line("");
    using Part = const PartCounts&;
    for (const Table& table :
         {table_by(stats, "frame", total, [](Part p) { return std::to_string(p.frame); }),
          table_by(stats, "region", total, [](Part p) { return std::to_string(p.region); }),
          table_by(stats, "renderer", total,
                   [](Part p) { return fmt::format("renderer-{}", p.renderer); }),
          table_by(
              stats, "drawn by", total,
              [](Part p) { return p.is_segment() ? fmt::format("gp-{}", p.gp) : group_of(p); }),
          table_by_op(stats, "class", total,
                      [](isa::Op op) { return isa::name_of(isa::class_of(op)); }),
          table_by_op(stats, "instruction", total,
                      [](isa::Op op) { return isa::info(op).name; })}) {
        answer.table(table).line("");
    }
    add_messages(run, stats, answer);
    return answer;
}

/// One line per part of a region and instruction. Written part by part: a run can have millions.
void put_csv(const RunStats& stats, TextOutput& output) {
    Table table;
    for (const char* key : {"frame", "region", "renderer", "part", "gp", "surface", "slab", "class",
                            "instruction", "instructions", "cycles", "words"}) {
        table.columns.push_back({key, ""});
    }
    output.put(csv_heading(table));
    for (const PartCounts& part : stats.parts) {
        const auto of_segment = [&](std::uint32_t value) {
            return Cell(part.is_segment() ? std::optional(value) : std::nullopt);
        };
        table.rows.clear();
        for (std::size_t i = 0; i < isa::op_count; ++i) {
            const auto op = static_cast<isa::Op>(i);
            const OpCount& count = part.ops[i];
            if (count != OpCount{}) {
                table.rows.push_back({part.frame, part.region, part.renderer, group_of(part),
                                      of_segment(part.gp), of_segment(part.surface),
                                      of_segment(part.slab), isa::name_of(isa::class_of(op)),
                                      isa::info(op).name, count.instructions, count.cycles,
                                      count.words});
            }
        }
        output.put(csv_rows(table));
    }
}

}  // namespace

int trace_stats(const StatsOptions& options) {
    if (options.json && options.csv) {
        throw RequestError(ExitCode::usage, "--json and --csv: give only one of them");
    }
    const Selection selection = parse_selection(options.selection);
    const RecordedRun run = open_run(options.run);
    const RunStats stats = stats_of(run, selection);
    if (options.csv) {
        TextOutput output(options.output);
        put_csv(stats, output);
        output.finish();
    } else {
        write(answer_of(run, stats), options.json ? Format::json : Format::text, options.output);
    }
    return stats.differences.empty() ? 0 : static_cast<int>(ExitCode::failed);
}

}  // namespace pxpl5::host::inspect
