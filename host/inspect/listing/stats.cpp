#include "host/inspect/listing/stats.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/reply.hpp"
#include "host/base/text_output.hpp"
#include "host/base/text_table.hpp"
#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/message_text.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr double cycles_per_ms = 40e3;  ///< The pixel processors' 40 MHz.

std::int64_t number(std::uint64_t n) {
    return static_cast<std::int64_t>(n);
}

/// One line of a table: counts of all that has one name.
struct Sum {
    OpCount count;
    std::uint64_t primitives = 0;
};
using Sums = std::vector<std::pair<std::string, Sum>>;

Sum& sum_at(Sums& sums, const std::string& name) {
    for (auto& [other, sum] : sums) {
        if (other == name) {
            return sum;
        }
    }
    return sums.emplace_back(name, Sum{}).second;
}

template <typename Name>
Sums sums_of(const RunStats& stats, const Name& name_of_part) {
    Sums sums;
    for (const PartCounts& part : stats.parts) {
        Sum& sum = sum_at(sums, name_of_part(part));
        sum.count += part.total();
        sum.primitives += part.primitives;
    }
    // gp-9 before gp-10, and those before "prologue".
    std::ranges::sort(sums, {},
                      [](const auto& row) { return std::pair(row.first.size(), row.first); });
    return sums;
}

template <typename Name>
Sums sums_of_ops(const RunStats& stats, const Name& name_of_op) {
    Sums sums;
    for (std::size_t op = 0; op < isa::op_count; ++op) {
        OpCount count;
        for (const PartCounts& part : stats.parts) {
            count += part.ops[op];
        }
        if (count != OpCount{}) {
            sum_at(sums, name_of_op(static_cast<isa::Op>(op))).count += count;
        }
    }
    return sums;
}

const char* name_of(const PartCounts& part) {
    switch (part.kind) {
        case renderer::RegionPlan::Kind::prologue:
            return "prologue";
        case renderer::RegionPlan::Kind::shut_door:
        case renderer::RegionPlan::Kind::open_door:
            return "screen doors";
        case renderer::RegionPlan::Kind::depths:
            return "depths";
        case renderer::RegionPlan::Kind::end_of_region:
            return "end of region";
        case renderer::RegionPlan::Kind::segment:
            break;
    }
    return "segments";
}

struct NamedSums {
    const char* name;
    Sums sums;
    bool has_primitives;
};

std::vector<NamedSums> tables_of(const RunStats& stats) {
    const auto text = [](std::string_view t) { return std::string(t); };
    return {
        {"frame", sums_of(stats, [](const PartCounts& p) { return std::to_string(p.frame); }),
         true},
        {"region", sums_of(stats, [](const PartCounts& p) { return std::to_string(p.region); }),
         true},
        {"renderer",
         sums_of(stats, [](const PartCounts& p) { return fmt::format("renderer-{}", p.renderer); }),
         true},
        {"drawn by",
         sums_of(stats,
                 [](const PartCounts& p) {
                     return p.is_segment() ? fmt::format("gp-{}", p.gp) : std::string(name_of(p));
                 }),
         true},
        {"class",
         sums_of_ops(stats, [&](isa::Op op) { return text(isa::name_of(isa::class_of(op))); }),
         false},
        {"instruction", sums_of_ops(stats, [&](isa::Op op) { return text(isa::info(op).name); }),
         false},
    };
}

std::string text_of(const NamedSums& table, const OpCount& total) {
    TableRow heading{table.name, "instructions", "cycles", "% of cycles", "ms at 40 MHz", "words"};
    if (table.has_primitives) {
        heading.emplace_back("primitives");
    }
    std::vector<TableRow> rows;
    for (const auto& [name, sum] : table.sums) {
        const auto cycles = static_cast<double>(sum.count.cycles);
        TableRow row{
            name,
            grouped(sum.count.instructions),
            grouped(sum.count.cycles),
            fmt::format("{:.1f}",
                        total.cycles == 0 ? 0.0 : 100 * cycles / static_cast<double>(total.cycles)),
            fmt::format("{:.3f}", cycles / cycles_per_ms),
            grouped(sum.count.words)};
        if (table.has_primitives) {
            row.push_back(grouped(sum.primitives));
        }
        rows.push_back(row);
    }
    return text_table(heading, rows) + "\n";
}

/// "gp" of "gp-3"
std::string role_of(const std::string& node) {
    return node.substr(0, node.rfind('-'));
}

/// Messages by one of kind, source, destination and channel.
template <typename Name>
std::vector<std::pair<std::string, MessageCount>> messages_by(const MessageCounts& counts,
                                                              const Name& name) {
    std::vector<std::pair<std::string, MessageCount>> sums;
    for (const auto& [way, count] : counts) {
        const std::string one = name(way);
        auto found = std::ranges::find(sums, one, [](const auto& row) { return row.first; });
        if (found == sums.end()) {
            found = sums.insert(sums.end(), {one, {}});
        }
        found->second += count;
    }
    return sums;
}

std::string messages_text(const RecordedRun& run, const MessageCounts& counts) {
    std::string text;
    const auto put = [&](const char* what, const auto& name) {
        std::vector<TableRow> rows;
        for (const auto& [one, count] : messages_by(counts, name)) {
            rows.push_back(
                {one, grouped(count.messages), grouped(count.bytes), grouped(count.words)});
        }
        text += text_table({what, "messages", "bytes", "words on the ring"}, rows) + "\n";
    };
    put("kind", [](const MessageWay& way) { return bus::kind_name(way.kind); });
    put("from", [&](const MessageWay& way) { return run.node_name(way.source); });
    put("to", [&](const MessageWay& way) { return run.node_name(way.destination); });
    put("between", [&](const MessageWay& way) {
        return role_of(run.node_name(way.source)) + " -> " +
               role_of(run.node_name(way.destination));
    });
    put("channel", [](const MessageWay& way) { return fmt::format("{}", way.channel); });
    return text;
}

OpCount total_of(const RunStats& stats) {
    OpCount total;
    for (const PartCounts& part : stats.parts) {
        total += part.total();
    }
    return total;
}

std::string text_of(const RecordedRun& run, const RunStats& stats) {
    const OpCount total = total_of(stats);
    std::string text =
        fmt::format("{} regions: {} instructions, {} cycles of the pixel processors (40 MHz)\n",
                    grouped(stats.regions), grouped(total.instructions), grouped(total.cycles));
    if (stats.told != 0) {
        text +=
            fmt::format("Counts of {} regions {} what their Renderers told.\n", grouped(stats.told),
                        stats.differences.empty() ? "equal" : "do not all equal");
    }
    for (const std::string& sentence : stats.differences) {
        text += sentence + "\n";
    }
    for (const std::string& sentence : stats.missing) {
        text += "Not there: " + sentence + "\n";
    }
    text += "words: in the streams, a loop's body once; primitives: from SETENABS to SETENABS\n\n";
    for (const NamedSums& table : tables_of(stats)) {
        text += text_of(table, total);
    }
    return text + messages_text(run, stats.messages);
}

Fields fields_of(const RecordedRun& run, const RunStats& stats) {
    const OpCount total = total_of(stats);
    Fields fields{
        {"regions", number(stats.regions)},   {"instructions", number(total.instructions)},
        {"cycles", number(total.cycles)},     {"words", number(total.words)},
        {"regions_told", number(stats.told)}, {"differences", number(stats.differences.size())}};
    for (const NamedSums& table : tables_of(stats)) {
        std::vector<Fields> rows;
        for (const auto& [name, sum] : table.sums) {
            rows.push_back({{"name", name},
                            {"instructions", number(sum.count.instructions)},
                            {"cycles", number(sum.count.cycles)},
                            {"words", number(sum.count.words)},
                            {"primitives", number(sum.primitives)}});
        }
        std::string key = std::string("by_") + table.name;
        std::ranges::replace(key, ' ', '_');
        fields.push_back({key, rows});
    }
    std::vector<Fields> messages;
    for (const auto& [way, count] : stats.messages) {
        messages.push_back({{"kind", bus::kind_name(way.kind)},
                            {"source", run.node_name(way.source)},
                            {"destination", run.node_name(way.destination)},
                            {"channel", number(way.channel)},
                            {"messages", number(count.messages)},
                            {"bytes", number(count.bytes)},
                            {"words", number(count.words)}});
    }
    fields.push_back({"messages", messages});
    return fields;
}

/// One line for each part of a region and instruction that it holds.
void put_csv(const RunStats& stats, TextOutput& output) {
    output.line(
        "frame,region,renderer,part,gp,surface,slab,class,instruction,instructions,cycles,"
        "words");
    for (const PartCounts& part : stats.parts) {
        const std::string from =
            part.is_segment() ? fmt::format("{},{},{}", part.gp, part.surface, part.slab) : ",,";
        for (std::size_t i = 0; i < isa::op_count; ++i) {
            const auto op = static_cast<isa::Op>(i);
            const OpCount& count = part.ops[i];
            if (count != OpCount{}) {
                output.line(fmt::format("{},{},{},{},{},{},{},{},{},{}", part.frame, part.region,
                                        part.renderer, name_of(part), from,
                                        isa::name_of(isa::class_of(op)), isa::info(op).name,
                                        count.instructions, count.cycles, count.words));
            }
        }
    }
}

}  // namespace

int trace_stats(const StatsOptions& options) {
    if (options.json && options.csv) {
        throw RequestError(ExitCode::usage, "--json and --csv: only one of them");
    }
    const Selection selection = parse_selection(options.selection);
    const RecordedRun run = open_run(options.run);
    const RunStats stats = stats_of(run, selection);
    TextOutput output(options.output);
    if (options.csv) {
        put_csv(stats, output);
    } else {
        output.put(options.json ? json_text(fields_of(run, stats)) + "\n" : text_of(run, stats));
    }
    output.finish();
    return stats.differences.empty() ? 0 : static_cast<int>(ExitCode::failed);
}

}  // namespace pxpl5::host::inspect
