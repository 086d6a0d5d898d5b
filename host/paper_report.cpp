#include "host/paper_report.hpp"

#include <fmt/core.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "host/error.hpp"
#include "host/phantom/phantom.hpp"
#include "host/picture_text.hpp"

namespace pxpl5::host {

namespace {

constexpr int rate_frames = 60;

/// A row of the paper's results, as its captions give them.
struct PaperRow {
    std::string_view volume, surface;
    std::int64_t triangles;
    double built_ms, frames_per_s;
    ViewAngles view;  ///< Ours: the paper's views are not stated.
};
constexpr std::array paper_rows = {
    PaperRow{"phantom:pelvis", "skin", 41'708, 409, 20, {25, 15}},
    PaperRow{"phantom:pelvis", "muscle", 110'450, 676, 8, {25, 15}},
    PaperRow{"phantom:pelvis", "bone", 49'552, 409, 19, {15, 15}},
    PaperRow{"phantom:fetus", "face", 70'874, 357, 12, {20, 10}},
    PaperRow{"phantom:head", "skin", 269'720, 591, 3, {35, 10}},
};

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
    for (const PaperRow& row : paper_rows) {
        if (row.volume != loaded) {
            session.load(std::string(row.volume));
            loaded = row.volume;
        }
        const PhantomSurface surface = phantom_surface(row);
        const SurfaceReport built = extract(session, surface);
        session.scene.camera = {row.view, 1};
        const OrbitReport orbit =
            session.orbit(rate_frames, [](int, const Picture&, const Camera&) {});
        if (!pictures.empty()) {
            paths.push_back(write_picture(session, row, pictures));
        }
        session.remove_surface(surface.name);
        fmt::print("{:<24}{:>10}{:>10}{:>12.0f}{:>12.1f}{:>11.0f}{:>11.1f}\n",
                   fmt::format("{}, {}", row.volume, row.surface), row.triangles, built.triangles,
                   row.built_ms, built.elapsed_ms, row.frames_per_s,
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
