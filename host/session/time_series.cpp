#include "host/session/time_series.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/volume/volume_messages.hpp"

namespace pxpl5::host {

namespace {

std::size_t bytes_of(const Volume& volume) {
    return volume.values.size() + (volume.reduced ? volume.reduced->values.size() : 0);
}

/// Volumes from now until `frame` is due, if the series is played in turn.
int distance(int frame, const Volume& now) {
    return (frame - now.frame + now.frames) % now.frames;
}

bool is_alike(const Volume& next, const Volume& now) {
    return next.nx == now.nx && next.ny == now.ny && next.nz == now.nz &&
           next.frames == now.frames && next.frame_ms == now.frame_ms &&
           next.times_ms == now.times_ms && next.voxel_to_patient == now.voxel_to_patient &&
           next.slice_places == now.slice_places;
}

/// Throws RequestError (bad_data) unless `next` is volume `frame` of the series of `now`.
void check_alike(const Volume& next, int frame, const Volume& now) {
    if (next.frame != frame) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: volume {} of {} was wanted, volume {} of {} was read",
                                       now.source, frame, now.frames, next.frame, next.frames));
    }
    if (is_alike(next, now)) {
        return;
    }
    throw RequestError(
        ExitCode::bad_data,
        fmt::format(
            "{}: volume {} of {} has {} x {} x {} voxels, the shown volume {} of {} has "
            "{} x {} x {}, and both must also have the same place and times. If the file has "
            "changed, load it again",
            now.source, next.frame, next.frames, next.nx, next.ny, next.nz, now.frame, now.frames,
            now.nx, now.ny, now.nz));
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
    begin_series();
    std::vector<Volume> read = take(frame);
    check_alike(read.front(), frame, now);
    keep(volumes_.exchange(std::move(read.front())));
    for (std::size_t later = 1; later < read.size(); ++later) {
        if (is_alike(read[later], volumes_.volume())) {
            keep(std::move(read[later]));
        }
    }
}

void TimeSeries::forget_others() {
    if (loads_ != volumes_.loads() || !volumes_.has_volume()) {
        kept_.clear();
        kept_bytes_ = 0;
        window_.reset();
        reads_ahead_ = true;
    }
}

/// Notes what the series has of its first shown volume.
void TimeSeries::begin_series() {
    forget_others();
    loads_ = volumes_.loads();
    if (!window_) {
        const Volume& first = volumes_.volume();
        window_ = usual_window(first, histogram(first, window_bins));
    }
}

GrayWindow TimeSeries::window() {
    begin_series();
    return *window_;
}

/// How many volumes from `frame` on one request reads: those that are not kept, up to the end of
/// the series.
int TimeSeries::count_to_read(int frame) const {
    const Volume& now = volumes_.volume();
    const std::size_t bytes = slice_bytes(now) * static_cast<std::size_t>(now.nz);
    const ImportOptions& options = volumes_.options();
    const bool is_larger_in_file = !options.crop_size.empty() || !options.resample_size.empty() ||
                                   !options.resample_spacing_mm.empty();
    const int most =
        !reads_ahead_ || is_larger_in_file
            ? 1
            : std::clamp(static_cast<int>(max_ahead_bytes / bytes), 1, max_ahead_volumes);
    int count = 1;
    for (int next = frame + 1;
         count < most && next <= now.frames && next != now.frame && !kept_.contains(next); ++next) {
        ++count;
    }
    return count;
}

/// The volume, from memory or from its file, and then those that were read with it. The process
/// that reads the next ones starts meanwhile.
std::vector<Volume> TimeSeries::take(int frame) {
    std::vector<Volume> taken;
    if (auto found = kept_.extract(frame)) {
        kept_bytes_ -= bytes_of(found.mapped());
        taken.push_back(std::move(found.mapped()));
        return taken;
    }
    const int count = count_to_read(frame);
    try {
        taken = volumes_.read_of_series(frame, count);
    } catch (const IoFailure&) {
        if (count == 1) {
            throw;
        }
        reads_ahead_ = false;  // A later one may be the cause, and would be again.
        taken = volumes_.read_of_series(frame, 1);
    }
    volumes_.prepare_read();
    return taken;
}

/// Keeps a volume that is not shown. Those that are due last go if there are too many.
void TimeSeries::keep(Volume volume) {
    const std::size_t bytes = bytes_of(volume);
    const int frame = volume.frame;
    if (kept_.try_emplace(frame, std::move(volume)).second) {
        kept_bytes_ += bytes;
    }
    const Volume& now = volumes_.volume();
    while (!kept_.empty() && kept_bytes_ > max_kept_bytes) {
        const auto last = std::ranges::max_element(
            kept_, {}, [&](const auto& each) { return distance(each.first, now); });
        kept_bytes_ -= bytes_of(last->second);
        kept_.erase(last);
    }
}

}  // namespace pxpl5::host
