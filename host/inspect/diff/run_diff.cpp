// Two recorded runs, compared in the order in which one thing leads to the next.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "host/base/error.hpp"
#include "host/inspect/diff/diff.hpp"
#include "host/inspect/diff/draw_text.hpp"
#include "host/inspect/diff/message_diff.hpp"
#include "host/inspect/diff/stream_diff.hpp"
#include "host/inspect/record/recorded_results.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

/// The first value that differs, as "name is A's in A, B's in B".
std::optional<std::string> first_value(const NamedValues& a, const NamedValues& b) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i >= a.size() || i >= b.size()) {
            return fmt::format("{} is only in {}", (i < a.size() ? a : b)[i].first,
                               i < a.size() ? "A" : "B");
        }
        if (a[i] != b[i]) {
            return fmt::format("{} is {} in A, {} is {} in B", a[i].first, a[i].second, b[i].first,
                               b[i].second);
        }
    }
    return std::nullopt;
}

// ---- set-up

/// The set-up messages to GP 0, before and between the frames.
std::vector<bus::Message> setup_of(const RecordedRun& run) {
    std::vector<bus::Message> messages;
    if (const NodeTrace* master = run.find(schema::Role::gp, 0)) {
        for (const bus::trace::Entry& entry : master->entries) {
            if (entry.kind() == bus::Body::VolumeHeader || entry.kind() == bus::Body::SetSurface ||
                entry.kind() == bus::Body::RemoveSurface) {
                messages.push_back(master->load(entry));
            }
        }
    }
    return messages;
}

bool is_whole(const RecordedRun& run) {
    const NodeTrace* master = run.find(schema::Role::gp, 0);
    return master != nullptr && master->info.dropped == 0;
}

/// True if the headers of all volumes have digests of the voxels.
bool digests_known(const RecordedRun& run) {
    return is_whole(run) && std::ranges::none_of(setup_of(run), [](const bus::Message& message) {
               const auto* header = message.as<schema::VolumeHeader>();
               return header != nullptr && header->digest() == 0;
           });
}

std::optional<Difference> compare_setup(const RecordedRun& a, const RecordedRun& b,
                                        DiffReport& report) {
    if (!is_whole(a) || !is_whole(b)) {
        report.notes.push_back(
            "set-up is not compared: GP 0's trace of a run is missing, or has "
            "only the newest messages");
        return std::nullopt;
    }
    const std::vector<bus::Message> in_a = setup_of(a), in_b = setup_of(b);
    for (std::size_t i = 0; i < std::min(in_a.size(), in_b.size()); ++i) {
        if (const auto value = first_value(setup_values_of(in_a[i]), setup_values_of(in_b[i]))) {
            return message_difference(0, fmt::format("set-up, message {} ({}) to gp-0: {}", i + 1,
                                                     bus::kind_name(in_a[i].kind()), *value));
        }
    }
    if (in_a.size() != in_b.size()) {
        report.notes.push_back(fmt::format("set-up: gp-0 received {} messages in A, {} in B",
                                           in_a.size(), in_b.size()));
    }
    return std::nullopt;
}

// ---- programs

/// Triangles before and after culling, over all GPs.
std::optional<std::pair<std::uint64_t, std::uint64_t>> triangles_of(const RecordedFrame& frame) {
    if (frame.inputs.empty()) {
        return std::nullopt;
    }
    std::pair<std::uint64_t, std::uint64_t> sum{0, 0};
    for (const auto& [gp, message] : frame.inputs.begin()->second.programs) {
        const auto& programs = *message.as<schema::RegionPrograms>();
        sum.first += programs.triangles_in();
        sum.second += programs.triangles_out();
    }
    return sum;
}

// ---- results

/// The result of a region: the pixels of its Renderer, or those that the host received.
struct Outcome {
    std::optional<RecordedTile> tile;
    std::vector<std::uint32_t> pixels;  ///< 128 * 128; empty if none were recorded.
};

Outcome outcome_of(const RecordedFrame& frame, std::uint32_t region) {
    Outcome outcome{tile_of(frame, region), {}};
    if (outcome.tile) {
        outcome.pixels.assign(outcome.tile->pixels.begin(), outcome.tile->pixels.end());
        return outcome;
    }
    const auto picture = picture_of(frame);
    if (!picture.empty()) {
        outcome.pixels = cut_out(frame, region, picture);
    }
    return outcome;
}

/// Adds which run is wrong: executes the region again.
void add_verdict(Difference& d, const RecordedRun& a, const RecordedRun& b,
                 const RecordedFrame& frame, const RecordedRegion& in_a, const RecordedRegion& in_b,
                 const PixelDifference& pixel, const DiffOptions& options) {
    const RegionRun again = run_region(in_a, *options.trusted.make());
    const std::size_t at = static_cast<std::size_t>((pixel.y - in_a.place.y0_px) * region_px +
                                                    pixel.x - in_a.place.x0_px);
    const std::uint32_t right = again.pixels.at(at) & 0xFFFFFF;
    const bool a_wrong = right != pixel.found, b_wrong = right != pixel.expected;
    const auto recorder = [](const RecordedRun& run, const RecordedRegion& region) {
        const NodeTrace* node = run.find(schema::Role::renderer, region.renderer);
        return fmt::format("renderer-{}{}", region.renderer,
                           node == nullptr ? "" : " of build " + node->info.build);
    };
    const std::string verdict = a_wrong && b_wrong ? "both are wrong"
                                : a_wrong          ? "A is wrong: " + recorder(a, in_a)
                                                   : "B is wrong: " + recorder(b, in_b);
    d.answer
        .line(fmt::format("  executed again ({}), the pixel is {}: {}", options.trusted.name,
                          color_text(right), verdict))
        .data(options.trusted.name, color_text(right))
        .data("verdict", verdict);
    const auto here = first_divergence(in_a.plan, options.trusted.make, options.other.make);
    if (!here) {
        d.answer.line(fmt::format(
            "  {} and {} of this program agree on the region: the recording Renderer is wrong",
            options.trusted.name, options.other.name));
        return;
    }
    d.answer.line("this program also differs in this region:")
        .object("executors", describe(frame, in_a, *here, options).answer);
}

Difference pixel_difference(const RecordedRun& run_a, const RecordedRun& run_b,
                            const RecordedFrame& frame, const RecordedRegion& a,
                            const RecordedRegion& b, const PixelDifference& pixel,
                            const DiffOptions& options) {
    Difference d{"pixel", {}, frame.number, a.place.number};
    d.answer
        .line(fmt::format("frame {}, {}: the programs are the same, the pixels differ",
                          frame.number, region_name(frame, a.place.number)))
        .line(fmt::format("  pixel        ({}, {}) of the picture: {} in A, {} in B", pixel.x,
                          pixel.y, color_text(pixel.found), color_text(pixel.expected)))
        .line("  bits         " + color_difference(pixel, "A", "B"))
        .data("level", d.level)
        .data("frame", frame.number)
        .data("region", a.place.number)
        .data("x", pixel.x)
        .data("y", pixel.y)
        .data("a", color_text(pixel.found))
        .data("b", color_text(pixel.expected));
    add_verdict(d, run_a, run_b, frame, a, b, pixel, options);
    return d;
}

class RunDiff {
  public:
    RunDiff(const RecordedRun& a, const RecordedRun& b, const DiffOptions& options)
        : a_(a), b_(b), options_(options) {}

    DiffReport run() {
        report_.difference = compare_setup(a_, b_, report_);
        const std::vector<std::uint32_t> in_a = a_.frames(), in_b = b_.frames();
        for (std::size_t i = 0; i < in_a.size() && !report_.difference; ++i) {
            if (!options_.selection.has_frame(in_a[i])) {
                continue;
            }
            if (std::ranges::find(in_b, in_a[i]) == in_b.end()) {
                report_.notes.push_back(fmt::format("frame {} is only in A", in_a[i]));
            } else {
                report_.difference = compare_frame(in_a[i]);
                ++report_.frames;
            }
        }
        for (const std::uint32_t number : in_b) {
            if (std::ranges::find(in_a, number) == in_a.end()) {
                report_.notes.push_back(fmt::format("frame {} is only in B", number));
            }
        }
        if (!report_.difference) {
            if (const auto message = first_message_difference(a_, b_)) {
                report_.notes.push_back("equal results, but " + *message);
            }
        }
        if (!report_.difference && report_.regions == 0) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("no region of a frame is in both runs: A has {} frames, "
                                           "B has {}",
                                           in_a.size(), in_b.size()));
        }
        return std::move(report_);
    }

  private:
    std::optional<Difference> compare_frame(std::uint32_t number) {
        const RecordedFrame a = a_.frame(number), b = b_.frame(number);
        if (const auto value = first_value(values_of(a.draw()), values_of(b.draw()))) {
            return message_difference(number,
                                      fmt::format("frame {}, DrawFrame: {}", number, *value));
        }
        if (const auto voxel = compare_volume(number)) {
            return voxel;
        }
        for (const RecordedFrame* frame : {&a, &b}) {
            for (const std::string& reason : frame->missing) {
                report_.notes.push_back(fmt::format("frame {} of {} is not complete: {}", number,
                                                    frame == &a ? "A" : "B", reason));
            }
        }
        const auto counts_a = triangles_of(a), counts_b = triangles_of(b);
        auto difference = each_region(a, b, &RunDiff::compare_programs);
        if (!difference && counts_a && counts_b && counts_a != counts_b) {
            difference = message_difference(
                number, fmt::format("frame {}: {} triangles and {} after culling in A, {} and {} "
                                    "in B",
                                    number, counts_a->first, counts_a->second, counts_b->first,
                                    counts_b->second));
        }
        return difference ? difference : each_region(a, b, &RunDiff::compare_results);
    }

    /// Compares the voxels of each volume once, unless the headers have digests.
    std::optional<Difference> compare_volume(std::uint32_t number) {
        const auto header = digests_known_ ? std::nullopt : a_.volume(number);
        const std::uint32_t id = header ? header->header.as<schema::VolumeHeader>()->volume() : 0;
        if (!header || volume_compared_ == id) {
            return std::nullopt;
        }
        volume_compared_ = id;
        const auto voxel = slice_difference(a_, b_, number);
        return voxel ? std::optional(message_difference(
                           number, fmt::format("frame {}, Slices: {}", number, *voxel)))
                     : std::nullopt;
    }

    using Compare = std::optional<Difference> (RunDiff::*)(const RecordedFrame&,
                                                           const RecordedRegion&,
                                                           const RecordedFrame&,
                                                           const RecordedRegion&);

    std::optional<Difference> each_region(const RecordedFrame& a, const RecordedFrame& b,
                                          Compare compare) {
        for (const auto& [number, in_a] : a.regions) {
            const auto in_b = b.regions.find(number);
            if (in_b != b.regions.end() &&
                options_.selection.has_region(number, in_a.place.column, in_a.place.row)) {
                if (auto difference = (this->*compare)(a, in_a, b, in_b->second)) {
                    return difference;
                }
            }
        }
        return std::nullopt;
    }

    std::optional<Difference> compare_programs(const RecordedFrame& frame_a,
                                               const RecordedRegion& a,
                                               const RecordedFrame& frame_b,
                                               const RecordedRegion& b) {
        ++report_.regions;
        return compare_streams(frame_a, a, frame_b, b);
    }

    std::optional<Difference> compare_results(const RecordedFrame& frame_a, const RecordedRegion& a,
                                              const RecordedFrame& frame_b,
                                              const RecordedRegion& b) {
        const std::uint32_t region = a.place.number;
        const Outcome in_a = outcome_of(frame_a, region), in_b = outcome_of(frame_b, region);
        if (in_a.pixels.empty() || in_b.pixels.empty()) {
            report_.notes.push_back(
                fmt::format("frame {}, region {}: pixels of {} were not "
                            "recorded",
                            frame_a.number, region, in_a.pixels.empty() ? "A" : "B"));
            return std::nullopt;
        }
        if (const auto pixel = compare_tiles(frame_a, region, in_a.pixels, in_b.pixels)) {
            return pixel_difference(a_, b_, frame_a, a, b, *pixel, options_);
        }
        if (in_a.tile && in_b.tile &&
            (in_a.tile->counts.instructions != in_b.tile->counts.instructions ||
             in_a.tile->counts.cycles != in_b.tile->counts.cycles)) {
            return message_difference(
                frame_a.number,
                fmt::format("frame {}, {}: {} instructions and {} modelled cycles in A, {} and {} "
                            "in B",
                            frame_a.number, region_name(frame_a, region),
                            in_a.tile->counts.instructions, in_a.tile->counts.cycles,
                            in_b.tile->counts.instructions, in_b.tile->counts.cycles));
        }
        return std::nullopt;
    }

    const RecordedRun &a_, &b_;
    const DiffOptions& options_;
    DiffReport report_;
    const bool digests_known_ = digests_known(a_) && digests_known(b_);
    std::optional<std::uint32_t> volume_compared_;
};

}  // namespace

DiffReport diff_runs(const RecordedRun& a, const RecordedRun& b, const DiffOptions& options) {
    return RunDiff(a, b, options).run();
}

}  // namespace pxpl5::host::inspect
