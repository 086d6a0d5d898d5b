#include "host/session/time_series.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

std::size_t bytes_of(const Volume& volume) {
    return volume.values.size() + (volume.reduced ? volume.reduced->values.size() : 0);
}

/// Volumes from now until `frame` is due, if the series is played in turn.
int distance(int frame, const Volume& now) {
    return (frame - now.frame + now.frames) % now.frames;
}

/// Throws RequestError (bad_data) unless `next` is volume `frame` of the series of `now`.
void check_alike(const Volume& next, int frame, const Volume& now) {
    if (next.frame != frame) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: volume {} of {} was wanted, volume {} of {} was read",
                                       now.source, frame, now.frames, next.frame, next.frames));
    }
    if (next.nx == now.nx && next.ny == now.ny && next.nz == now.nz && next.frames == now.frames &&
        next.voxel_to_patient == now.voxel_to_patient && next.slice_places == now.slice_places) {
        return;
    }
    throw RequestError(
        ExitCode::bad_data,
        fmt::format("{}: volume {} of {} has {} x {} x {} voxels, the shown volume {} of {} has "
                    "{} x {} x {}, and both must also be at the same place. If the file has "
                    "changed, load it again",
                    now.source, next.frame, next.frames, next.nx, next.ny, next.nz, now.frame,
                    now.frames, now.nx, now.ny, now.nz));
}

}  // namespace

void check_frame(const Volume& volume, int frame) {
    if (volume.frames == 1) {
        throw RequestError(ExitCode::usage, fmt::format("time: {} is one volume", volume.source));
    }
    if (frame < 1 || frame > volume.frames) {
        throw RequestError(ExitCode::usage,
                           fmt::format("time: {} is no volume of {}, which has {}: give 1 to {}",
                                       frame, volume.source, volume.frames, volume.frames));
    }
}

void TimeSeries::show(int frame) {
    const Volume& now = volumes_.volume();
    if (frame == now.frame) {
        return;
    }
    check_frame(now, frame);
    forget_others();
    loads_ = volumes_.loads();
    Volume next = take(frame);
    check_alike(next, frame, now);
    keep(volumes_.exchange(std::move(next)));
}

TimeSeries::Kept TimeSeries::kept() const {
    Kept kept{kept_.size(), 0};
    for (const auto& [frame, volume] : kept_) {
        kept.bytes += bytes_of(volume);
    }
    return kept;
}

void TimeSeries::forget_others() {
    if (loads_ != volumes_.loads() || !volumes_.has_volume()) {
        kept_.clear();
    }
}

/// The volume, from memory or from its file. The process that reads the next one starts meanwhile.
Volume TimeSeries::take(int frame) {
    if (const auto found = kept_.extract(frame)) {
        return std::move(found.mapped());
    }
    ImportOptions options = volumes_.options();
    options.frame = static_cast<std::uint32_t>(frame);
    Volume volume = volumes_.read(volumes_.volume().source, options);
    volumes_.prepare_read();
    return volume;
}

/// Keeps a volume that is no longer shown. Those that are due last go if there are too many.
void TimeSeries::keep(Volume volume) {
    kept_.insert_or_assign(volume.frame, std::move(volume));
    const Volume& now = volumes_.volume();
    while (!kept_.empty() && kept().bytes > max_kept_bytes) {
        kept_.erase(std::ranges::max_element(
            kept_, {}, [&](const auto& each) { return distance(each.first, now); }));
    }
}

}  // namespace pxpl5::host
