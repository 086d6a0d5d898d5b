#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/inspect/record/message_text.hpp"
#include "host/inspect/record/run_table.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::size_t hash_digits = 16;  ///< Of a longer hash; --json has all.

/// "; 8 MiB for each GP; ring of 8 channels of 80 MB/s", as far as the topology tells.
std::string machine_text(const std::string& topology) {
    const auto json = nlohmann::json::parse(topology, nullptr, false);
    const auto number = [&](const char* path) {
        const nlohmann::json::json_pointer place(path);
        const bool is_there =
            json.is_object() && json.contains(place) && json.at(place).is_number_integer();
        return is_there ? std::optional(json.at(place).get<std::int64_t>()) : std::nullopt;
    };
    std::string text;
    if (const auto memory = number("/roles/gp/memory_mib")) {
        text += fmt::format("; {} MiB for each GP", *memory);
    }
    const auto channels = number("/ring/channels"), speed = number("/ring/channel_mb_s");
    if (channels && speed) {
        text += fmt::format("; ring of {} channels of {} MB/s", *channels, *speed);
    }
    return text;
}

std::string state_of(const NodeRow& node) {
    return node.cut.empty() ? "complete" : "cut: " + node.cut;
}

std::string nodes_text(const RunTable& table) {
    std::string text =
        fmt::format("{:<15} {:>9} {:>13} {:>10} {:>10}  {:<9} {:>8}  {}\n", "node", "messages",
                    "bytes", "from clock", "to clock", "recording", "dropped", "trace");
    for (const NodeRow& node : table.nodes) {
        text += fmt::format("{:<15} {:>9} {:>13} {:>10} {:>10}  {:<9} {:>8}  {}\n", node.name,
                            grouped(node.messages), grouped(node.bytes), node.first_clock,
                            node.last_clock, node.recording, grouped(node.dropped), state_of(node));
    }
    return text;
}

std::string frames_text(const RunTable& table) {
    std::string text = fmt::format("{:>5}  {:<11} {:>8} {:>11} {:>11} {:>11} {:>7} {:>10} {:>12}\n",
                                   "frame", "size", "surfaces", "triangles", "drawn", "words",
                                   "regions", "executable", "instructions");
    for (const FrameRow& frame : table.frames) {
        text += fmt::format(
            "{:>5}  {:<11} {:>8} {:>11} {:>11} {:>11} {:>7} {:>10} {:>12}{}\n", frame.number,
            fmt::format("{}x{}{}", frame.width, frame.height, frame.views > 1 ? "x2" : ""),
            frame.surfaces, grouped(frame.triangles), grouped(frame.triangles_drawn),
            grouped(frame.words), frame.regions, frame.executable, grouped(frame.instructions),
            frame.done ? "" : "  (not done)");
    }
    return table.frames.empty() ? "no frame\n" : text;
}

}  // namespace

std::string to_text(const RunTable& table) {
    std::string text =
        fmt::format("recorded by {}; message schemas {}", table.build, table.schema_hash);
    for (const auto& [key, value] : table.more) {
        text += fmt::format("; {} {}", key, value.substr(0, hash_digits));
    }
    text += fmt::format("\nmachine: GPs {}, Renderers {}{}\n", table.gps, table.renderers,
                        machine_text(table.topology));
    for (const VolumeRow& volume : table.volumes) {
        text +=
            fmt::format("volume {}: {}, {}x{}x{} {}, digest {:016x}{}{}\n", volume.id, volume.name,
                        volume.nx, volume.ny, volume.nz, volume.type, volume.digest,
                        volume.source.empty() ? "" : ", read from ", volume.source);
    }
    return text + "\n" + nodes_text(table) + "\n" + frames_text(table);
}

Fields to_fields(const RunTable& table) {
    const auto number = [](std::uint64_t n) { return static_cast<std::int64_t>(n); };
    std::vector<Fields> nodes, volumes, frames;
    for (const NodeRow& node : table.nodes) {
        nodes.push_back({{"name", node.name},
                         {"messages", number(node.messages)},
                         {"bytes", number(node.bytes)},
                         {"first_clock", number(node.first_clock)},
                         {"last_clock", number(node.last_clock)},
                         {"recording", node.recording},
                         {"dropped", number(node.dropped)},
                         {"complete", node.cut.empty()},
                         {"cut", node.cut}});
    }
    for (const VolumeRow& volume : table.volumes) {
        volumes.push_back({{"volume", number(volume.id)},
                           {"name", volume.name},
                           {"source", volume.source},
                           {"nx", number(volume.nx)},
                           {"ny", number(volume.ny)},
                           {"nz", number(volume.nz)},
                           {"type", volume.type},
                           {"digest", fmt::format("{:016x}", volume.digest)}});
    }
    for (const FrameRow& frame : table.frames) {
        frames.push_back({{"frame", number(frame.number)},
                          {"width", number(frame.width)},
                          {"height", number(frame.height)},
                          {"views", number(frame.views)},
                          {"surfaces", number(frame.surfaces)},
                          {"triangles", number(frame.triangles)},
                          {"triangles_drawn", number(frame.triangles_drawn)},
                          {"words", number(frame.words)},
                          {"regions", number(frame.regions)},
                          {"executable", number(frame.executable)},
                          {"instructions", number(frame.instructions)},
                          {"done", frame.done}});
    }
    Fields more;
    for (const auto& [key, value] : table.more) {
        more.push_back({key, value});
    }
    return {{"build", table.build},
            {"schema_hash", table.schema_hash},
            {"more", more},
            {"topology", table.topology},
            {"gps", number(table.gps)},
            {"renderers", number(table.renderers)},
            {"volumes", volumes},
            {"nodes", nodes},
            {"frames", frames}};
}

}  // namespace pxpl5::host::inspect
