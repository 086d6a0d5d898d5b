#include "host/inspect/replay/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"

namespace pxpl5::host::inspect {

namespace {

/// A region's pixels beside its recording.
struct Replayed {
    RegionReplay report;
    std::vector<std::uint32_t> pixels;
};

std::string pixel_text(const PixelDifference& p, std::string_view recorded_by) {
    return fmt::format("pixel ({}, {}): {} here, {} in {}; {}", p.x, p.y, color_text(p.found),
                       color_text(p.expected), recorded_by,
                       color_difference(p, "the replay", "the recording"));
}

/// The difference from the recording, if any.
std::optional<std::string> difference(const RecordedFrame& frame, std::uint32_t region,
                                      const RegionRun& run, const RegionReplay& report) {
    const std::string sender = fmt::format("renderer-{}'s RegionPixels", report.renderer);
    const std::size_t due = frame.has_pixels() ? region_pixels : 0;
    if (run.pixels.size() != due) {
        return fmt::format("{} pixels were read out, not {}", run.pixels.size(), due);
    }
    const std::optional<RecordedTile> tile = tile_of(frame, region);
    if (tile) {
        if (tile->pixels.size() != due) {
            return fmt::format("{} pixels are in {}, not {}", tile->pixels.size(), sender, due);
        }
        if (due != 0) {
            if (const auto pixel = compare_tiles(frame, region, run.pixels, tile->pixels)) {
                return pixel_text(*pixel, sender);
            }
        }
        if (!std::ranges::equal(run.pixels, tile->pixels)) {
            return "a pixel outside of the picture, or an alpha value, differs from " + sender;
        }
        if (!std::ranges::equal(run.depths, tile->depths)) {
            return "the provenance or the depth of a pixel differs from " + sender;
        }
        const auto counts = [](const isa::RunCounts& c) {
            return fmt::format("{} instructions, {} modelled cycles", c.instructions, c.cycles);
        };
        if (counts(run.counts) != counts(tile->counts)) {
            return fmt::format("{}; {} states {}", counts(run.counts), sender,
                               counts(tile->counts));
        }
    }
    const auto picture = picture_of(frame);
    if (!picture.empty()) {
        if (const auto pixel =
                compare_tiles(frame, region, run.pixels, cut_out(frame, region, picture))) {
            return pixel_text(*pixel, "the host's FrameDone");
        }
    }
    return std::nullopt;
}

Replayed replay_region(const RecordedFrame& frame, const RecordedRegion& region,
                       ExecutorKind kind) {
    const std::uint32_t number = region.place.number;
    Replayed replayed;
    replayed.report.region = number;
    replayed.report.renderer = region.renderer;
    RegionRun run = run_region(region, *make_executor(kind));
    replayed.report.counts = run.counts;
    replayed.report.compared = tile_of(frame, number) || !picture_of(frame).empty();
    replayed.report.difference = difference(frame, number, run, replayed.report);
    replayed.pixels = std::move(run.pixels);
    return replayed;
}

/// Calls work(i) for i in 0..count-1 from several threads. Rethrows the first exception.
void in_parallel(std::size_t count, unsigned threads,
                 const std::function<void(std::size_t)>& work) {
    std::atomic<std::size_t> next{0};
    std::vector<std::exception_ptr> failed(threads);
    const auto run = [&](unsigned thread) {
        try {
            for (std::size_t i = next++; i < count; i = next++) {
                work(i);
            }
        } catch (...) {
            failed[thread] = std::current_exception();
        }
    };
    {
        std::vector<std::jthread> others;
        for (unsigned thread = 1; thread < threads; ++thread) {
            others.emplace_back(run, thread);
        }
        run(0);
    }
    for (const std::exception_ptr& failure : failed) {
        if (failure) {
            std::rethrow_exception(failure);
        }
    }
}

FrameReplay replay_frame(const RecordedFrame& frame,
                         const std::vector<const RecordedRegion*>& regions, ExecutorKind kind,
                         unsigned threads) {
    const std::int64_t start = now_ns();
    std::vector<Replayed> replayed(regions.size());
    in_parallel(regions.size(), std::max(threads, 1U),
                [&](std::size_t i) { replayed[i] = replay_region(frame, *regions[i], kind); });
    FrameReplay report{frame.number, kind, frame.pass_text(), {}, {}, {}, 0};
    const FrameShape shape = shape_of(frame);
    std::vector<std::uint32_t> picture(shape.pixels());
    for (Replayed& region : replayed) {
        if (region.pixels.size() == region_pixels) {
            place_region(shape, static_cast<int>(region.report.region), region.pixels, picture);
        }
        report.regions.push_back(std::move(region.report));
    }
    if (frame.has_pixels() && regions.size() == static_cast<std::size_t>(shape.regions())) {
        report.digest = digest_of(picture);
    }
    if (!picture_of(frame).empty()) {
        report.recorded = digest_of(picture_of(frame));
    }
    report.elapsed_s = ms_since(start) / 1000;
    return report;
}

}  // namespace

std::size_t FrameReplay::compared() const {
    return static_cast<std::size_t>(std::ranges::count(regions, true, &RegionReplay::compared));
}

const RegionReplay* FrameReplay::first_difference() const {
    const auto found = std::ranges::find_if(
        regions, [](const RegionReplay& r) { return r.difference.has_value(); });
    return found == regions.end() ? nullptr : &*found;
}

bool ReplayReport::agrees() const {
    return std::ranges::all_of(frames, &FrameReplay::agrees);
}

std::size_t ReplayReport::compared() const {
    std::size_t sum = 0;
    for (const FrameReplay& frame : frames) {
        sum += frame.compared();
    }
    return sum;
}

Answer answer_of(const FrameReplay& frame) {
    std::uint64_t instructions = 0;
    std::size_t differ = 0;
    for (const RegionReplay& region : frame.regions) {
        instructions += region.counts.instructions;
        differ += region.difference ? 1 : 0;
    }
    const auto hex = [](std::uint64_t digest) { return fmt::format("{:016x}", digest); };
    const std::string recorded = !frame.digest || !frame.recorded ? ""
                                 : *frame.digest == *frame.recorded
                                     ? " as recorded"
                                     : ", recorded " + hex(*frame.recorded);
    Answer answer;
    answer
        .line(fmt::format(
            "frame {:>4}  {:<9}  regions {:>3}, compared {:>3}, differ {:>3}  "
            "instructions {:>9}  {:6.2f} s  {}{}digest {}{}",
            frame.frame, name_of(frame.executor), frame.regions.size(), frame.compared(), differ,
            instructions, frame.elapsed_s, frame.pass, frame.pass.empty() ? "" : ", ",
            frame.digest ? hex(*frame.digest) : "of the whole frame unknown", recorded))
        .data("frame", frame.frame)
        .data("executor", name_of(frame.executor))
        .data("regions", frame.regions.size())
        .data("compared", frame.compared())
        .data("agrees", frame.agrees())
        .data_if("digest", frame.digest ? hex(*frame.digest) : "")
        .data_if("recorded", frame.recorded ? hex(*frame.recorded) : "");
    if (const RegionReplay* region = frame.first_difference()) {
        answer.line(fmt::format("    region {}: {}", region->region, *region->difference))
            .data("region", region->region)
            .data("difference", *region->difference);
    }
    return answer;
}

Answer summary_of(const ReplayReport& report) {
    const std::size_t compared = report.compared();
    return Answer()
        .sentences("missing", "reason", "not recorded: ", report.missing)
        .line(!report.agrees() ? "The replay differs from the recording."
              : compared == 0
                  ? "Nothing was compared: the pixels were not recorded."
                  : fmt::format("All comparisons agree: {}.", counted(compared, "region")));
}

Answer answer_of(const ReplayReport& report) {
    std::vector<Answer> frames;
    for (const FrameReplay& frame : report.frames) {
        frames.push_back(answer_of(frame));
    }
    return Answer()
        .data("agrees", report.agrees())
        .data("compared", report.compared())
        .list("frames", std::move(frames))
        .append(summary_of(report));
}

ReplayReport replay(const RecordedRun& run, const ReplayOptions& options,
                    const std::function<void(const FrameReplay&)>& on_frame) {
    ReplayReport report;
    for (const auto& [id, node] : run.nodes()) {
        if (!node.cut.empty()) {
            report.missing.push_back(run.node_name(id) + ": " + node.cut);
        }
    }
    for (const std::uint32_t number : run.frames()) {
        if (!options.selection.has_frame(number)) {
            continue;
        }
        const RecordedFrame frame = run.frame(number);
        for (const std::string& reason : frame.missing) {
            report.missing.push_back(fmt::format("frame {}: {}", number, reason));
        }
        const auto regions = selected_regions(frame, options.selection);
        for (const ExecutorKind kind : options.executors) {
            if (!regions.empty()) {
                report.frames.push_back(replay_frame(frame, regions, kind, options.threads));
                if (on_frame) {
                    on_frame(report.frames.back());
                }
            }
        }
    }
    if (report.frames.empty()) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format(
                "nothing to replay: no selected region of {} frames was recorded completely{}",
                run.frames().size(), report.missing.empty() ? "" : "; " + report.missing.front()));
    }
    return report;
}

}  // namespace pxpl5::host::inspect
