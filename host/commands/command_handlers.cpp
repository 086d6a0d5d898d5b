#include "host/commands/command_handlers.hpp"

#include <fmt/core.h>

#include "host/commands/text/picture_text.hpp"
#include "host/session/transfer/detail.hpp"

namespace pxpl5::host {

Reply run_stats(Session& session, const Arguments&) {
    Reply reply;
    std::vector<Fields> list;
    for (const Surface& surface : session.scene.surfaces) {
        if (!session.surfaces.has_report(surface.name)) {
            continue;  // The GPs extract it at the moment.
        }
        const SurfaceReport& report = session.surfaces.report_of(surface.name);
        reply.text +=
            surface_text(surface, report) +
            fmt::format("\n  {} cells crossed, {} of them ambiguous; {} cell rows skipped\n",
                        report.cells_active, report.cells_ambiguous, report.rows_skipped);
        list.push_back(surface_fields(surface, report));
    }
    if (const ArchiveFacts* archive = session.volumes.archive()) {
        reply.text += fmt::format("{}: {} triangles, {} spheres, {} lines\n", archive->file,
                                  archive->triangles, archive->spheres, archive->lines);
    }
    const FrameReport& frame = session.frames.last();
    reply.text += fmt::format("machine: GPs {}, Renderers {}\n", session.conversation.gps().size(),
                              session.conversation.renderer_count());
    reply.text +=
        fmt::format("last frame: {:.1f} ms, {} instructions, {} Renderer cycles (modelled)",
                    frame.elapsed_ms, frame.instructions, frame.renderer_cycles);
    reply.fields = {{"surfaces", list},
                    {"gps", static_cast<std::int64_t>(session.conversation.gps().size())},
                    {"renderers", static_cast<std::int64_t>(session.conversation.renderer_count())},
                    {"frame", Fields{{"elapsed_ms", frame.elapsed_ms},
                                     {"instructions", frame.instructions},
                                     {"renderer_cycles", frame.renderer_cycles}}}};
    return reply;
}

Reply run_digest(Session& session, const Arguments&) {
    const std::string frame = fmt::format("{:016x}", picture_digest(session.frames.draw()));
    const double moved_mm = session.frames.last().moved_mm;
    Reply reply{"frame " + frame, {{"frame", frame}, {"moved_mm", moved_mm}}};
    if (moved_mm > 0) {
        reply.text += fmt::format(" (simplified within {} mm)", bound_text(moved_mm));
    }
    Fields meshes;
    for (const Surface& surface : session.scene.surfaces) {
        const std::string mesh = fmt::format("{:016x}", session.meshes.digest(surface.name));
        reply.text += fmt::format("\nmesh {} {}", surface.name, mesh);
        meshes.push_back({surface.name, mesh});
    }
    reply.fields.push_back({"meshes", meshes});
    return reply;
}

Reply run_trace(Session& session, const Arguments&) {
    const SavedTraces saved = session.nodes.save_traces();
    return {fmt::format("{} messages of {} nodes, {:.1f} MB, in {}", saved.messages, saved.nodes,
                        static_cast<double>(saved.bytes) / 1e6, saved.folder),
            {{"folder", saved.folder},
             {"nodes", std::int64_t{saved.nodes}},
             {"messages", static_cast<std::int64_t>(saved.messages)},
             {"bytes", static_cast<std::int64_t>(saved.bytes)}}};
}

Reply run_quit(Session&, const Arguments&) {
    return {"", {}};
}

}  // namespace pxpl5::host
