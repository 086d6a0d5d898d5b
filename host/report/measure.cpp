#include "host/report/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "host/base/error.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/phantom/phantom.hpp"
#include "host/report/report_row.hpp"
#include "host/session/live_work.hpp"
#include "host/timing/headset.hpp"

namespace pxpl5::host::report {

namespace {

constexpr int rate_frames = 60;

/// The row's surface: of a phantom as it suggests.
Surface surface_of(const Source& source) {
    Surface surface;
    surface.name = source.row.surface;
    surface.isovalue = source.row.isovalue;
    const std::vector<PhantomSurface> suggested = suggested_surfaces(source.volume);
    const auto found = std::ranges::find(suggested, source.row.surface, &PhantomSurface::name);
    if (found != suggested.end()) {
        surface.isovalue = found->isovalue;
        surface.color = {found->color_rgb[0], found->color_rgb[1], found->color_rgb[2]};
    } else if (!suggested.empty()) {
        throw RequestError(ExitCode::failed, fmt::format("{} has no surface '{}'", source.volume,
                                                         source.row.surface));
    }
    return surface;
}

std::string write_picture(Session& session, const Source& source, const std::string& folder) {
    std::string name = source.name;
    std::ranges::replace(name, '/', '-');
    const std::string path = (std::filesystem::path(folder) / (name + ".png")).string();
    const Picture picture = session.frames.draw();
    session.exports.pictures({&picture, 1}, path, picture_extras(session, session.scene.camera));
    return path;
}

SurfaceReport set_surface(Session& session, const Source& source) {
    const Surface surface = surface_of(source);
    session.scene.camera = {{source.row.azimuth_deg, source.row.elevation_deg}, 1};
    session.scene.size = wall_size;
    return session.surfaces.set(surface.name, surface.isovalue, CaseRule::watertight,
                                surface.color);
}

/// Draws each row once more, from a volume with smooth gradients.
void write_pictures(Session& session, std::span<const Source> sources,
                    const MeasureOptions& measuring, std::vector<MeasuredCase>& cases) {
    ImportOptions options;
    options.gradient = GradientKernel::smooth;
    std::string_view loaded;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const Source& source = sources[i];
        if (measuring.progress) {
            measuring.progress(sources.size() + i, source);
        }
        if (source.volume != loaded) {
            session.volumes.load(source.volume, options);
            loaded = source.volume;
        }
        set_surface(session, source);
        cases[i].picture = write_picture(session, source, measuring.pictures);
        session.surfaces.remove(std::string(source.row.surface));
    }
}

/// Counts the scene's frame for both eyes of a head-mounted display.
timing::FrameWork pair_work(Session& session) {
    const timing::Headset headset;
    const Scene before = session.scene;
    session.scene.size = {static_cast<int>(headset.eye_width),
                          static_cast<int>(headset.eye_height)};
    session.scene.stereo.mode = StereoMode::side_by_side;
    timing::FrameWork pair = std::move(frame_work(session).at(0));
    session.scene = before;
    return pair;
}

MeasuredCase measured(Session& session, const Source& source, const MeasureOptions& options) {
    const std::string surface(source.row.surface);
    const SurfaceReport built = set_surface(session, source);
    MeasuredCase measured;
    measured.triangles = built.triangles;
    measured.wall_built_ms = built.elapsed_ms;
    if (options.wall) {
        constexpr double ms_per_s = 1000;
        const OrbitReport orbit =
            session.frames.orbit(rate_frames, [](int, const Picture&, const Camera&) {});
        measured.wall_frames_per_s = orbit.frames * ms_per_s / orbit.elapsed_ms;
    }
    session.scene.size = modelled_size;
    measured.work = {source.row, volume_work(session), build_work(session, surface),
                     std::move(frame_work(session).at(0))};
    if (options.pairs) {
        measured.pair = pair_work(session);
    }
    session.scene.size = wall_size;
    session.surfaces.remove(surface);
    return measured;
}

}  // namespace

std::vector<MeasuredCase> measure(Session& session, std::span<const Source> sources,
                                  const MeasureOptions& options) {
    std::vector<MeasuredCase> cases;
    std::string_view loaded;
    for (const Source& source : sources) {
        if (options.progress) {
            options.progress(cases.size(), source);
        }
        if (source.volume != loaded) {
            session.volumes.load(source.volume);
            loaded = source.volume;
        }
        cases.push_back(measured(session, source, options));
    }
    if (!options.pictures.empty()) {
        write_pictures(session, sources, options, cases);
    }
    return cases;
}

}  // namespace pxpl5::host::report
