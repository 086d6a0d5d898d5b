#include "host/inspect/record/run_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/inspect/record/message_text.hpp"
#include "ringbus/rules/slice_planes.hpp"
#include "ringbus/trace/trace_info.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;

/// Gathers what messages tell of frames and volumes.
struct Gatherer {
    const RecordedRun& run;
    std::map<std::uint32_t, FrameRow> frames;
    std::map<std::uint32_t, VolumeRow> volumes;
    struct Inputs {
        std::vector<std::uint16_t> assignment;
        std::set<std::uint32_t> begun;                          ///< Renderers.
        std::map<std::uint32_t, std::set<std::uint32_t>> came;  ///< GPs by Renderer.
        std::set<std::uint32_t> counted;                        ///< GPs.
    };
    std::map<std::uint32_t, Inputs> inputs;
    std::map<std::uint32_t, std::uint32_t> views_done;  ///< By frame.

    void add(const NodeTrace& node, const bus::Message& message) {
        if (const auto* begin = message.as<schema::BeginFrame>()) {
            add_begin(node, *begin);
        } else if (const auto* programs = message.as<schema::RegionPrograms>()) {
            add_programs(node, *programs);
        } else if (const auto* pixels = message.as<schema::RegionPixels>()) {
            for (const schema::RegionTile* tile : *pixels->tiles()) {
                frames[pixels->frame()].instructions += tile->instructions();
            }
        } else if (const auto* done = message.as<schema::FrameDone>()) {
            views_done[done->frame()] += done->views();
        } else if (const auto* volume = message.as<schema::VolumeHeader>()) {
            volumes[volume->volume()] = {volume->volume(),
                                         volume->name()->str(),
                                         volume->source() == nullptr ? "" : volume->source()->str(),
                                         enum_name(volume->type()),
                                         volume->nx(),
                                         volume->ny(),
                                         volume->nz(),
                                         volume->digest()};
        } else if (const auto* end = message.as<schema::VolumeEnd>();
                   end != nullptr && volumes.contains(end->volume())) {
            volumes[end->volume()].digest |= end->digest();  // 0 until all slices are there.
        }
    }
    void add_begin(const NodeTrace& node, const schema::BeginFrame& begin) {
        const schema::DrawFrame& draw = *begin.draw();
        FrameRow& frame = frames[draw.frame()];
        frame.width = draw.width();
        frame.height = draw.height();
        frame.views = draw.views()->size();
        frame.surfaces = bus::first_plane(draw);
        frame.regions = begin.assignment()->size();
        Inputs& in = inputs[draw.frame()];
        in.assignment.assign(begin.assignment()->begin(), begin.assignment()->end());
        if (node.info.role == schema::Role::renderer) {
            in.begun.insert(node.info.index);
        }
    }
    void add_programs(const NodeTrace& node, const schema::RegionPrograms& programs) {
        FrameRow& frame = frames[programs.frame()];
        Inputs& in = inputs[programs.frame()];
        in.came[node.info.index].insert(programs.gp());
        for (const schema::RegionProgram* region : *programs.regions()) {
            frame.words += region->words()->size();
        }
        if (in.counted.insert(programs.gp()).second) {  // Each Renderer is told the same sum.
            frame.triangles += programs.triangles_in();
            frame.triangles_drawn += programs.triangles_out();
        }
    }
    /// Regions all of whose messages are there.
    std::size_t executable(const Inputs& in) const {
        return static_cast<std::size_t>(
            std::ranges::count_if(in.assignment, [&](std::uint32_t renderer) {
                const auto came = in.came.find(renderer);
                return in.begun.count(renderer) != 0 && came != in.came.end() &&
                       came->second.size() >= run.gp_count();
            }));
    }
};

NodeRow row_of(const NodeTrace& node) {
    NodeRow row{bus::trace::name_of(node.info.role, node.info.index),
                enum_name(node.info.recording),
                node.entries.size(),
                0,
                0,
                0,
                node.info.dropped,
                node.cut};
    for (const bus::trace::Entry& entry : node.entries) {
        row.bytes += entry.header.body_bytes();
        row.last_clock = std::max(row.last_clock, entry.header.clock());
        row.first_clock = &entry == node.entries.data()
                              ? entry.header.clock()
                              : std::min(row.first_clock, entry.header.clock());
    }
    return row;
}

void take_info(RunTable& table, const bus::trace::Info& info) {
    table.build = info.build;
    table.schema_hash = bus::trace::to_metadata(info).at("schema_hash");
    for (const auto& [key, value] : info.more) {
        if (key == "topology") {
            table.topology = value;
        } else {
            table.more[key] = value;
        }
    }
}

bool tells(Body kind) {
    return kind == Body::VolumeHeader || (bus::is_of_frame(kind) && kind != Body::DrawFrame);
}

}  // namespace

RunTable table_of(const RecordedRun& run) {
    RunTable table;
    table.gps = run.gp_count();
    table.renderers = run.renderer_count();
    table.frame_buffers = run.frame_buffer_count();
    Gatherer gatherer{run, {}, {}, {}, {}};
    for (const auto& [id, node] : run.nodes()) {
        take_info(table, node.info);
        table.nodes.push_back(row_of(node));
        for (const bus::trace::Entry& entry : node.entries) {
            if (tells(entry.kind())) {
                gatherer.add(node, node.load(entry));
            }
        }
    }
    for (auto& [number, frame] : gatherer.frames) {
        frame.number = number;
        frame.done = frame.views > 0 && gatherer.views_done[number] >= frame.views;
        frame.executable = gatherer.executable(gatherer.inputs[number]);
        table.frames.push_back(frame);
    }
    for (const auto& [id, volume] : gatherer.volumes) {
        table.volumes.push_back(volume);
    }
    return table;
}

namespace {

constexpr std::size_t hash_digits = 16;  ///< Digits of a longer hash in the text; JSON has all.

/// "; 8 MiB for each GP; ring of 8 channels of 80 MB/s": the values that the topology states.
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

Table nodes_table(const std::vector<NodeRow>& nodes) {
    Table table{"nodes",
                {{"name", "node"},
                 {"messages", "messages"},
                 {"bytes", "bytes"},
                 {"first_clock", "from clock"},
                 {"last_clock", "to clock"},
                 {"recording", "recording"},
                 {"dropped", "dropped"},
                 {"complete", ""},
                 {"cut", ""},
                 {"", "trace"}}};
    for (const NodeRow& node : nodes) {
        const bool complete = node.cut.empty();
        table.rows.push_back({node.name, grouped_cell(node.messages), grouped_cell(node.bytes),
                              node.first_clock, node.last_clock, node.recording,
                              grouped_cell(node.dropped), complete, node.cut,
                              complete ? "complete" : "cut: " + node.cut});
    }
    return table;
}

Table frames_table(const std::vector<FrameRow>& frames) {
    Table table{"frames",
                {{"frame", "frame"},
                 {"width", ""},
                 {"height", ""},
                 {"views", ""},
                 {"", "size"},
                 {"surfaces", "surfaces"},
                 {"triangles", "triangles"},
                 {"triangles_drawn", "drawn"},
                 {"words", "words"},
                 {"regions", "regions"},
                 {"executable", "executable"},
                 {"instructions", "instructions"},
                 {"done", "done"}},
                {},
                0};
    for (const FrameRow& frame : frames) {
        table.rows.push_back(
            {frame.number, frame.width, frame.height, frame.views,
             fmt::format("{}x{}{}", frame.width, frame.height, frame.views > 1 ? "x2" : ""),
             frame.surfaces, grouped_cell(frame.triangles), grouped_cell(frame.triangles_drawn),
             grouped_cell(frame.words), frame.regions, frame.executable,
             grouped_cell(frame.instructions), frame.done});
    }
    return table;
}

Table volumes_table(const std::vector<VolumeRow>& volumes) {
    Table table{"volumes",
                {{"volume", "volume"},
                 {"name", "name"},
                 {"source", "read from"},
                 {"nx", ""},
                 {"ny", ""},
                 {"nz", ""},
                 {"", "size"},
                 {"type", "type"},
                 {"digest", "digest"}},
                {},
                3};
    for (const VolumeRow& volume : volumes) {
        table.rows.push_back({volume.id, volume.name, volume.source, volume.nx, volume.ny,
                              volume.nz, fmt::format("{}x{}x{}", volume.nx, volume.ny, volume.nz),
                              volume.type, hex_cell(volume.digest)});
    }
    return table;
}

}  // namespace

Answer answer_of(const RunTable& run) {
    std::string versions =
        fmt::format("recorded by {}; message schemas {}", run.build, run.schema_hash);
    Fields more;
    for (const auto& [key, value] : run.more) {
        versions += fmt::format("; {} {}", key, value.substr(0, hash_digits));
        more.push_back({key, value});
    }
    const std::string buffers =
        run.frame_buffers > 1 ? fmt::format(", frame buffers {}", run.frame_buffers) : "";
    Answer answer;
    answer.line(versions)
        .line(fmt::format("machine: GPs {}, Renderers {}{}{}", run.gps, run.renderers, buffers,
                          machine_text(run.topology)))
        .data("build", run.build)
        .data("schema_hash", run.schema_hash)
        .data("more", more)
        .data("topology", run.topology)
        .data("gps", run.gps)
        .data("renderers", run.renderers)
        .data("frame_buffers", run.frame_buffers)
        .line("")
        .table(volumes_table(run.volumes))
        .line("")
        .table(nodes_table(run.nodes))
        .line("")
        .table(frames_table(run.frames));
    return answer;
}

}  // namespace pxpl5::host::inspect
