#include "host/session/surfaces.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <utility>

#include "host/base/command_descriptor.hpp"
#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Sums in slab order, so that rounding does not depend on the machine.
SurfaceReport sum_slabs(std::vector<schema::SlabCounts> slabs) {
    std::sort(slabs.begin(), slabs.end(),
              [](const auto& p, const auto& q) { return p.slab() < q.slab(); });
    SurfaceReport report;
    for (const schema::SlabCounts& slab : slabs) {
        report.triangles += slab.triangles();
        report.vertices += slab.vertices();
        report.cells_active += slab.cells_active();
        report.cells_ambiguous += slab.cells_ambiguous();
        report.rows_skipped += slab.rows_skipped();
        report.area_mm2 += slab.area_mm2();
        report.volume_mm3 += slab.volume_mm3();
    }
    report.slabs = std::move(slabs);
    return report;
}

}  // namespace

std::optional<Surface> Surfaces::find(const std::string& name) const {
    const auto found = std::ranges::find(scene_.surfaces, name, &Surface::name);
    return found == scene_.surfaces.end() ? std::nullopt : std::optional(*found);
}

void Surfaces::set_style(const Surface& like) {
    Surface& surface = meshes_.surface(like.name);
    surface.color = like.color;
    surface.visible = like.visible;
    surface.opacity = like.opacity;
    surface.rim = like.rim;
    surface.cull_back = like.cull_back;
}

/// Adds the surface if none of that name exists.
Surface& Surfaces::put(const std::string& name) {
    if (const auto found = std::ranges::find(scene_.surfaces, name, &Surface::name);
        found != scene_.surfaces.end()) {
        return *found;
    }
    if (scene_.surfaces.size() == max_user_surfaces) {
        throw RequestError(ExitCode::usage, fmt::format("{} surfaces are the most; remove one "
                                                        "before adding '{}'",
                                                        max_user_surfaces, name));
    }
    Surface added;
    added.name = name;
    added.id = volumes_.new_surface_id();
    return scene_.surfaces.emplace_back(added);
}

/// Has the GPs extract the surface's newest revision, and the announced frame drawn behind it.
SurfaceReport Surfaces::extract(const Surface& surface) {
    const std::int64_t start_ns = now_ns();
    schema::SetSurfaceT request;
    request.surface = surface.id;
    request.revision = surface.revision;
    request.isovalue = surface.isovalue;
    request.table = surface.table;
    std::vector<schema::SlabCounts> slabs;
    SurfaceReport all;
    bool can_hold_all = true;
    conversation_.expect([&](const bus::Message& message) {
        const auto* built = message.as<schema::SurfaceBuilt>();
        if (built == nullptr || built->surface() != request.surface ||
            built->revision() != request.revision) {
            return false;
        }
        for (const schema::SlabCounts* slab : *built->slabs()) {
            slabs.push_back(*slab);
        }
        all.memory_bytes += static_cast<std::int64_t>(built->memory_bytes());
        all.slabs_left_out += built->left_out();
        all.gps_to_hold_all = std::max(all.gps_to_hold_all, std::int64_t{built->gps_to_hold_all()});
        can_hold_all = can_hold_all && (built->left_out() == 0 || built->gps_to_hold_all() > 0);
        return true;
    });
    struct Forget {
        Conversation& conversation;
        ~Forget() { conversation.forget(); }
    };
    const Forget forget{conversation_};
    conversation_.broadcast(bus::pack(request));
    frames_.request_announced();
    {
        const Conversation::Cancelable cancelable(conversation_);
        conversation_.wait_for_answers("surface " + surface.name);
    }
    SurfaceReport report = sum_slabs(std::move(slabs));
    report.elapsed_ms = ms_since(start_ns);
    report.memory_bytes = all.memory_bytes;
    report.slabs_left_out = all.slabs_left_out;
    report.gps_to_hold_all = can_hold_all ? all.gps_to_hold_all : 0;
    return report;
}

/// Ends a canceled extraction in all GPs, and drops their answers and faults that are still to
/// come: a fault would count as the answer to the next extraction.
void Surfaces::end_extraction(Surface& surface) {
    schema::SetSurfaceT nothing;  // Replaces the extraction, and has no triangles.
    nothing.surface = surface.id;
    nothing.revision = ++surface.revision;
    nothing.isovalue = max_float;
    nothing.table = surface.table;
    schema::MaskSurfaceT
        last;  // GPs answer it behind all that came before, and apply no such mask.
    last.surface = surface.id;
    last.revision = ++surface.revision;
    conversation_.broadcast(bus::pack(nothing));
    conversation_.broadcast(bus::pack(last));
    std::set<bus::NodeId> waiting(conversation_.gps().begin(), conversation_.gps().end());
    conversation_.discard_until(
        [&](const bus::Message& message) {
            const auto* built = message.as<schema::SurfaceBuilt>();
            if (built != nullptr && built->surface() == last.surface &&
                built->revision() == last.revision) {
                waiting.erase(message.source());
            }
        },
        [&] { return waiting.empty(); });
}

/// Extracts the surface of before a failed change once more: the GPs no longer have it. Removes the
/// surface if there was none, or if that fails, too.
void Surfaces::put_back(const std::string& name, const std::optional<Surface>& before) {
    if (before) {
        Surface& surface = meshes_.surface(name);
        const std::uint32_t revision = surface.revision + 1;
        surface = *before;
        surface.revision = revision;
        const Conversation::Uncancelable whole(conversation_);
        try {
            reports_.insert_or_assign(name, extract(surface));
            mask_again(surface);
            return;
        } catch (const RequestError&) {
            frames_.abandon();
        }
    }
    remove(name);
}

SurfaceReport Surfaces::set(const std::string& name, double isovalue, CaseRule table, Color color) {
    volumes_.volume();  // Throws if no volume is loaded.
    frames_.drop_ahead();
    const std::optional<Surface> before = find(name);
    Surface& surface = put(name);
    surface.isovalue = isovalue;
    surface.table = table;
    surface.color = color;
    ++surface.revision;
    SurfaceReport report;
    try {
        report = extract(surface);
    } catch (const RequestError& error) {
        frames_.abandon();
        if (dynamic_cast<const Canceled*>(&error) != nullptr) {
            end_extraction(surface);
        }
        put_back(name, before);
        throw;
    }
    reports_.insert_or_assign(name, report);
    mask_again(surface);
    return report;
}

SweepReport Surfaces::sweep(const std::string& name, std::span<const double> isovalues,
                            const TakeChange& take) {
    const Surface before = meshes_.surface(name);
    const auto set_before = [&] { set(name, before.isovalue, before.table, before.color); };
    const auto restore = [&] {
        try {
            set_before();
        } catch (const RequestError&) {
            if (find(name)) {  // It has the isovalue of the last picture again.
                set_before();
            }
            throw;
        }
    };
    std::vector<double> extractions_ms, pictures_ms;
    try {
        for (const double isovalue : isovalues) {
            const std::int64_t start_ns = now_ns();
            const bool is_ahead =
                scene_.samples == 1 && before.components.kind == ComponentFilter::Kind::all;
            frames_.announce(is_ahead
                                 ? std::optional(Frames::Moving{scene_.size, scene_.detail.detail})
                                 : std::nullopt);
            const SurfaceReport report = set(name, isovalue, before.table, before.color);
            const Picture picture = frames_.draw();
            pictures_ms.push_back(ms_since(start_ns));
            extractions_ms.push_back(report.elapsed_ms);
            take(static_cast<int>(pictures_ms.size()) - 1, picture, report);
        }
    } catch (const RequestError&) {
        if (find(name)) {  // A surface that cannot be extracted is removed.
            restore();
        }
        throw;
    }
    restore();
    return {static_cast<int>(pictures_ms.size()), spread_of(std::move(extractions_ms)),
            spread_of(std::move(pictures_ms))};
}

void Surfaces::remove(const std::string& name) {
    const Surface& surface = meshes_.surface(name);
    frames_.drop_ahead();
    schema::RemoveSurfaceT request;
    request.surface = surface.id;
    conversation_.broadcast(bus::pack(request));
    reports_.erase(name);
    std::erase_if(scene_.surfaces, [&](const Surface& other) { return other.name == name; });
}

const SurfaceReport& Surfaces::report_of(const std::string& name) const {
    const auto found = reports_.find(name);
    if (found == reports_.end()) {
        throw RequestError(ExitCode::usage, fmt::format("there is no surface '{}'", name));
    }
    return found->second;
}

DrawnComponents Surfaces::set_components(const std::string& name, const ComponentFilter& filter) {
    Surface& surface = meshes_.surface(name);
    surface.components = filter;
    const Conversation::Uncancelable whole(conversation_);  // The GPs' mask is the filter's.
    try {
        return meshes_.apply_filter(surface);
    } catch (...) {
        surface.components = {};  // The filter says what is drawn.
        throw;
    }
}

/// Masks a surface that was extracted again.
void Surfaces::mask_again(const Surface& surface) {
    if (surface.components.kind != ComponentFilter::Kind::all) {
        set_components(surface.name, ComponentFilter(surface.components));
    }
}

MeshComparison Surfaces::compare(const std::string& name) {
    end_comparison(name);
    const Surface whole = meshes_.surface(name);
    if (!whole.compared_with.empty()) {
        throw RequestError(ExitCode::usage, fmt::format("{} is a comparison itself", name));
    }
    if (scene_.surfaces.size() + 2 > max_user_surfaces) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("compare: {} surfaces and two more are {}, {} are the most",
                        scene_.surfaces.size(), scene_.surfaces.size() + 2, max_user_surfaces));
    }
    const std::string ours = name + ":watertight", theirs = name + ":lorensen1987";
    for (const std::string& made : {ours, theirs}) {
        if (find(made)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("compare: there is a surface '{}' already", made));
        }
    }
    try {
        constexpr Color only_ours{64, 180, 166}, only_theirs{232, 128, 64};
        set(ours, whole.isovalue, CaseRule::watertight, only_ours);
        meshes_.surface(ours).compared_with = name;
        set(theirs, whole.isovalue, CaseRule::lorensen1987, only_theirs);
        meshes_.surface(theirs).compared_with = name;
        const WeldedMesh a = meshes_.fetch(ours, true), b = meshes_.fetch(theirs, true);
        const Pause pause = meshes_.pause_of(whole);
        MeshComparison comparison = compare_meshes(a, b, meshes_.grid(), pause);
        meshes_.show(ours, a, comparison.shown_a);
        meshes_.show(theirs, b, comparison.shown_b);
        return comparison;
    } catch (const RequestError&) {
        for (const std::string& made : {ours, theirs}) {
            if (find(made)) {
                remove(made);  // Without its mask it would hide the surface.
            }
        }
        throw;
    }
}

bool Surfaces::end_comparison(const std::string& name) {
    std::vector<std::string> made;
    for (const Surface& surface : scene_.surfaces) {
        if (surface.compared_with == name) {
            made.push_back(surface.name);
        }
    }
    for (const std::string& each : made) {
        remove(each);
    }
    return !made.empty();
}

}  // namespace pxpl5::host
