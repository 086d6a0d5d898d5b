#include "host/paper_report.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <vector>

#include "host/error.hpp"
#include "host/phantom/phantom.hpp"
#include "host/picture_text.hpp"
#include "host/timing/paper_rows.hpp"

namespace pxpl5::host {

namespace {

constexpr int rate_frames = 60;

using timing::paper_rows;
using timing::PaperRow;

PhantomSurface phantom_surface(const PaperRow& row) {
    for (const PhantomSurface& surface : suggested_surfaces(row.volume)) {
        if (surface.name == row.surface) {
            return surface;
        }
    }
    throw RequestError(ExitCode::failed,
                       fmt::format("{} has no surface '{}'", row.volume, row.surface));
}

SurfaceReport extract(Session& session, const PhantomSurface& surface) {
    return session.set_surface(
        surface.name, surface.isovalue, CaseTable::watertight,
        {surface.colour_rgb[0], surface.colour_rgb[1], surface.colour_rgb[2]});
}

std::string write_picture(Session& session, const PaperRow& row, const std::string& folder) {
    std::filesystem::create_directories(folder);
    const std::string path =
        (std::filesystem::path(folder) /
         fmt::format("{}-{}.png", row.volume.substr(row.volume.find(':') + 1), row.surface))
            .string();
    const Picture picture = session.draw();
    session.export_pictures({&picture, 1}, path, picture_extras(session, session.scene.camera));
    return path;
}

}  // namespace

void report_paper(Session& session, const std::string& machine, const std::string& pictures) {
    fmt::print("{:<24}{:>20}{:>24}{:>22}\n", "", "triangles", "surface built in, ms", "frames/s");
    fmt::print("{:<24}{:>10}{:>10}{:>12}{:>12}{:>11}{:>11}\n", "volume, surface", "paper", "here",
               "paper", "here", "paper", "here");
    std::vector<std::string> paths;
    std::string_view loaded;
    for (const PaperRow& row : paper_rows()) {
        if (row.volume != loaded) {
            session.load(std::string(row.volume));
            loaded = row.volume;
        }
        const PhantomSurface surface = phantom_surface(row);
        const SurfaceReport built = extract(session, surface);
        session.scene.camera = {{row.azimuth_deg, row.elevation_deg}, 1};
        const OrbitReport orbit =
            session.orbit(rate_frames, [](int, const Picture&, const Camera&) {});
        if (!pictures.empty()) {
            paths.push_back(write_picture(session, row, pictures));
        }
        session.remove_surface(surface.name);
        fmt::print("{:<24}{:>10}{:>10}{:>12.0f}{:>12.1f}{:>11.0f}{:>11.1f}\n",
                   fmt::format("{}, {}", row.volume, row.surface), row.paper.triangles,
                   built.triangles, row.paper.built_ms, built.elapsed_ms, row.paper.frames_per_s,
                   orbit.frames * 1000 / orbit.elapsed_ms);
        std::fflush(stdout);
    }
    fmt::print(
        "paper: 36 GPs, 16 Renderers, 1993, wall time of that machine; here: wall time of "
        "this one, {}, {}x{}, every view newly drawn\n",
        machine, session.scene.size.width, session.scene.size.height);
    if (!paths.empty()) {
        fmt::print("pictures:\n");
        for (const std::string& path : paths) {
            fmt::print("  {}\n", path);
        }
    }
}

}  // namespace pxpl5::host
