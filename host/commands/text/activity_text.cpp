#include "host/commands/text/activity_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "host/session/activity/network.hpp"

namespace pxpl5::host {

namespace {

constexpr std::size_t machine_channels = 8;  ///< The ring of 1993 has 8; a topology may have more.
constexpr double cycles_per_ms = 40'000;     ///< The pixel processors run at 40 MHz.
constexpr double bytes_per_mb = 1e6;
constexpr std::size_t shown_kinds = 4;

struct Sum {
    std::uint64_t messages = 0, bytes = 0;
    void add(const bus::SentCount& sent) {
        messages += sent.messages;
        bytes += sent.bytes;
    }
};

std::int64_t whole(std::uint64_t value) {
    return static_cast<std::int64_t>(value);
}

double share(double part, double whole) {
    return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0;
}

std::vector<Sum> by_channel(const ActivityReport& report) {
    std::vector<Sum> channels(machine_channels);
    for (const NodeReport& node : report.nodes) {
        for (const bus::SentCount& sent : node.sent) {
            channels.resize(std::max(channels.size(), sent.channel + std::size_t{1}));
            channels[sent.channel].add(sent);
        }
    }
    return channels;
}

std::string node_text(const NodeReport& report) {
    std::string text = fmt::format("{:<15}", report.node.name);
    if (!report.answered) {
        return text + " has not answered yet: it is at work";
    }
    Sum sent;
    for (const bus::SentCount& each : report.sent) {
        sent.add(each);
    }
    const double seconds = report.wall_ms / 1e3;
    const auto rate = [&](double count) { return seconds > 0 ? count / seconds : 0.0; };
    text += fmt::format(
        " {:5.1f} {:5.1f} {:9.1f} {:9.3f} {:7}", 100 * share(report.busy_ms, report.wall_ms),
        100 * share(report.cpu_ms, report.wall_ms), rate(static_cast<double>(sent.messages)),
        rate(static_cast<double>(sent.bytes)) / bytes_per_mb, report.frames);
    for (const NodeReport::Stage& stage : report.stages) {
        text += fmt::format("  {} {:.1f}", stage.name, stage.ms);
    }
    if (report.refused_messages > 0) {
        text += fmt::format("  dropped messages {}", report.refused_messages);
    }
    return text;
}

Fields sent_fields(const bus::SentCount& sent, const std::string& to) {
    return {{"to", to},
            {"kind", bus::kind_name(sent.kind)},
            {"channel", std::int64_t{sent.channel}},
            {"messages", whole(sent.messages)},
            {"bytes", whole(sent.bytes)}};
}

Fields node_fields(const NodeReport& report, const std::map<bus::NodeId, std::string>& names) {
    std::vector<Fields> stages, sent;
    for (const NodeReport::Stage& stage : report.stages) {
        stages.push_back({{"name", stage.name}, {"ms", stage.ms}, {"count", stage.count}});
    }
    for (const bus::SentCount& each : report.sent) {
        const auto name = names.find(each.to);
        sent.push_back(sent_fields(each, name == names.end() ? "io" : name->second));
    }
    Fields fields{{"name", report.node.name},
                  {"role", std::string(bus::schema::EnumNameRole(report.node.role))},
                  {"answered", report.answered},
                  {"wall_ms", report.wall_ms},
                  {"busy", share(report.busy_ms, report.wall_ms)},
                  {"cpu", share(report.cpu_ms, report.wall_ms)},
                  {"stages", stages},
                  {"memory_bytes", whole(report.memory_bytes)},
                  {"queue", std::int64_t{report.queue}},
                  {"held_up", std::int64_t{report.held_up}},
                  {"frames", report.frames},
                  {"received_messages", whole(report.received_messages)},
                  {"received_bytes", whole(report.received_bytes)},
                  {"sent", sent}};
    if (report.refused_messages > 0) {
        fields.push_back({"refused_messages", whole(report.refused_messages)});
    }
    return fields;
}

double per_frame(const ActivityReport& report, std::uint64_t bytes) {
    return report.frames > 0 ? static_cast<double>(bytes) / static_cast<double>(report.frames) : 0;
}

/// One line for each computer, and one for the messages between them. Empty on one computer.
std::string network_text(const ActivityReport& report) {
    const NetworkReport network = network_of(report);
    if (network.computers.empty()) {
        return {};
    }
    std::string text = fmt::format("\n{:<15} {:>5} {:>9} {:>9} {:>9}", "computer", "nodes",
                                   "cpu ms", "MB out", "MB in");
    for (const ComputerReport& each : network.computers) {
        text += fmt::format("\n{:<15} {:>5} {:>9.1f} {:>9.3f} {:>9.3f}", each.name, each.nodes,
                            each.cpu_ms, static_cast<double>(each.sent_bytes) / bytes_per_mb,
                            static_cast<double>(each.received_bytes) / bytes_per_mb);
    }
    text += fmt::format("\nbetween computers: {:.3f} MB",
                        static_cast<double>(network.bytes) / bytes_per_mb);
    if (report.frames > 0) {
        text += fmt::format(", {:.3f} MB a frame", per_frame(report, network.bytes) / bytes_per_mb);
    }
    for (std::size_t i = 0; i < std::min<std::size_t>(network.kinds.size(), shown_kinds); ++i) {
        text +=
            fmt::format("{}{} {:.3f}", i == 0 ? "; " : ", ", bus::kind_name(network.kinds[i].kind),
                        static_cast<double>(network.kinds[i].bytes) / bytes_per_mb);
    }
    return text;
}

void add_network_fields(const ActivityReport& report, Fields& fields) {
    const NetworkReport network = network_of(report);
    if (network.computers.empty()) {
        return;
    }
    std::vector<Fields> computers, kinds;
    for (const ComputerReport& each : network.computers) {
        computers.push_back({{"name", each.name},
                             {"nodes", std::int64_t{each.nodes}},
                             {"cpu_ms", each.cpu_ms},
                             {"sent_bytes", whole(each.sent_bytes)},
                             {"received_bytes", whole(each.received_bytes)}});
    }
    for (const NetworkReport::Kind& each : network.kinds) {
        kinds.push_back({{"kind", bus::kind_name(each.kind)}, {"bytes", whole(each.bytes)}});
    }
    fields.push_back({"computers", computers});
    fields.push_back({"network", Fields{{"bytes", whole(network.bytes)},
                                        {"bytes_per_frame", per_frame(report, network.bytes)},
                                        {"kinds", kinds}}});
}

/// The last frame, and who has drawn what of it. There is none before the first.
Fields frame_fields(const FrameReport& frame) {
    std::vector<double> cycles(frame.region_cycles.begin(), frame.region_cycles.end());
    std::vector<double> renderers(frame.region_renderers.begin(), frame.region_renderers.end());
    Fields fields{{"elapsed_ms", frame.elapsed_ms}, {"instructions", frame.instructions}};
    if (!renderers.empty()) {  // Renderers only: what GPs and ring took is not modelled here.
        std::map<double, double> sums;
        for (std::size_t region = 0; region < cycles.size(); ++region) {
            sums[renderers.at(region)] += cycles[region];
        }
        double longest = 0;
        for (const auto& [renderer, sum] : sums) {
            longest = std::max(longest, sum);
        }
        fields.push_back({"renderer_ms_1993", longest / cycles_per_ms});
    }
    fields.push_back({"regions", Fields{{"columns", std::int64_t{frame.region_columns}},
                                        {"rows", std::int64_t{frame.region_rows}},
                                        {"renderer", renderers},
                                        {"cycles", cycles}}});
    return fields;
}

}  // namespace

std::string activity_text(const ActivityReport& report) {
    std::string text = fmt::format(
        "{:.0f} ms, {} frames\n{:<15} {:>5} {:>5} {:>9} {:>9} {:>7}  stages, ms", report.wall_ms,
        report.frames, "node", "busy%", "cpu%", "sent/s", "MB/s", "frames");
    for (const NodeReport& node : report.nodes) {
        text += "\n" + node_text(node);
    }
    text += "\nchannels, messages:";
    for (const Sum& channel : by_channel(report)) {
        text += fmt::format(" {}", channel.messages);
    }
    return text + network_text(report);
}

Fields activity_fields(const ActivityReport& report, const FrameReport& frame) {
    std::map<bus::NodeId, std::string> names;
    for (const NodeReport& node : report.nodes) {
        names.emplace(node.node.id, node.node.name);
    }
    std::vector<Fields> nodes, channels;
    for (const NodeReport& node : report.nodes) {
        nodes.push_back(node_fields(node, names));
    }
    for (const Sum& channel : by_channel(report)) {
        channels.push_back(
            {{"messages", whole(channel.messages)}, {"bytes", whole(channel.bytes)}});
    }
    Fields fields{{"wall_ms", report.wall_ms},
                  {"frames", report.frames},
                  {"frame", frame_fields(frame)},
                  {"nodes", nodes},
                  {"channels", channels}};
    add_network_fields(report, fields);
    return fields;
}

Fields activity_fields(Session& session) {
    return activity_fields(session.nodes.activity(AwaitAnswers::none), session.frames.last());
}

}  // namespace pxpl5::host
