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
    return fmt::format("pixel ({}, {}): {} here, {} in {}; {}", p.x, p.y, colour_text(p.found),
                       colour_text(p.expected), recorded_by,
                       colour_difference(p, "the replay", "the recording"));
}

/// What differs from the recording, if anything.
std::optional<std::string> difference(const RecordedFrame& frame, std::uint32_t region,
                                      const RegionRun& run, const RegionReplay& report) {
    const std::string sender = fmt::format("renderer-{}'s RegionPixels", report.renderer);
    const std::size_t due = frame.has_pixels() ? isa::region_pixels : 0;
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
            return "a pixel outside of the picture, or an alpha, is not as " + sender + " has it";
        }
        if (!std::ranges::equal(run.depths, tile->depths)) {
            return "what a pixel shows, or its depth, is not as " + sender + " has it";
        }
        const auto counts = [](const isa::RunCounts& c) {
            return fmt::format("{} instructions, {} modelled cycles", c.instructions, c.cycles);
        };
        if (counts(run.counts) != counts(tile->counts)) {
            return fmt::format("{}; {} says {}", counts(run.counts), sender, counts(tile->counts));
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

/// Calls work(i) for i in 0..count-1 from several threads, and passes on what one of them throws.
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

std::vector<const RecordedRegion*> selected(const RecordedFrame& frame,
                                            const Selection& selection) {
    std::vector<const RecordedRegion*> regions;
    for (const auto& [number, region] : frame.regions) {
        if (selection.has_region(number, region.place.column, region.place.row) &&
            selection.has_renderer(region.renderer)) {
            regions.push_back(&region);
        }
    }
    return regions;
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
        if (region.pixels.size() == isa::region_pixels) {
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

Fields fields_of(const FrameReplay& frame) {
    Fields fields = {{"frame", std::int64_t{frame.frame}},
                     {"executor", std::string(name_of(frame.executor))},
                     {"regions", static_cast<std::int64_t>(frame.regions.size())},
                     {"compared", static_cast<std::int64_t>(frame.compared())},
                     {"agrees", frame.agrees()}};
    if (frame.digest) {
        fields.push_back({"digest", fmt::format("{:016x}", *frame.digest)});
    }
    if (frame.recorded) {
        fields.push_back({"recorded", fmt::format("{:016x}", *frame.recorded)});
    }
    if (const RegionReplay* region = frame.first_difference()) {
        fields.push_back({"region", std::int64_t{region->region}});
        fields.push_back({"difference", *region->difference});
    }
    return fields;
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

std::string to_text(const FrameReplay& frame) {
    std::uint64_t instructions = 0;
    for (const RegionReplay& region : frame.regions) {
        instructions += region.counts.instructions;
    }
    const auto differ = std::ranges::count_if(
        frame.regions, [](const RegionReplay& r) { return r.difference.has_value(); });
    std::string text = fmt::format(
        "frame {:>4}  {:<9}  regions {:>3}, compared {:>3}, differ {:>3}  instructions {:>9}  "
        "{:6.2f} s  {}{}digest {}{}",
        frame.frame, name_of(frame.executor), frame.regions.size(), frame.compared(), differ,
        instructions, frame.elapsed_s, frame.pass, frame.pass.empty() ? "" : ", ",
        frame.digest ? fmt::format("{:016x}", *frame.digest) : "of the whole frame unknown",
        !frame.digest || !frame.recorded   ? ""
        : *frame.digest == *frame.recorded ? " as recorded"
                                           : fmt::format(", recorded {:016x}", *frame.recorded));
    if (const RegionReplay* region = frame.first_difference()) {
        text += fmt::format("\n    region {}: {}", region->region, *region->difference);
    }
    return text;
}

std::string summary_of(const ReplayReport& report) {
    std::string text;
    for (const std::string& sentence : report.missing) {
        text += "not there: " + sentence + "\n";
    }
    const std::size_t compared = report.compared();
    if (!report.agrees()) {
        return text + "the replay differs from the recording";
    }
    return text + (compared == 0 ? "nothing to compare with: the pixels were not recorded"
                                 : fmt::format("all that could be compared agrees: {} region{}",
                                               compared, compared == 1 ? "" : "s"));
}

Fields to_fields(const ReplayReport& report) {
    std::vector<Fields> frames, missing;
    for (const FrameReplay& frame : report.frames) {
        frames.push_back(fields_of(frame));
    }
    for (const std::string& sentence : report.missing) {
        missing.push_back({{"reason", sentence}});
    }
    return {{"agrees", report.agrees()},
            {"compared", static_cast<std::int64_t>(report.compared())},
            {"frames", frames},
            {"missing", missing}};
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
        const auto regions = selected(frame, options.selection);
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
            fmt::format("nothing to replay: of {} frames no selected region was recorded whole{}",
                        run.frames().size(),
                        report.missing.empty() ? "" : "; " + report.missing.front()));
    }
    return report;
}

}  // namespace pxpl5::host::inspect
