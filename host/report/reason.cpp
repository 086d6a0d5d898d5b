#include "host/report/reason.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/base/chart_axis.hpp"
#include "host/timing/replay/build_model.hpp"

namespace pxpl5::host::report {

namespace {

using namespace timing;

constexpr double mhz_to_cycles_per_ms = 1e3, ns_per_ms = 1e6, bytes_per_word = 4;
constexpr double long_share = 0.5;  ///< Share of a frame that makes one region worth a sentence.

/// A count, and the time that it takes its unit.
struct Load {
    double count = 0;
    std::string what;
    double ms = 0;
};

std::string text_of(const Load& load) {
    return fmt::format("{} {} ({:.1f} ms)", grouped(std::round(load.count)), load.what, load.ms);
}

double gp_ms(const Machine& machine, double cycles) {
    return cycles / (machine.gp_clock_mhz * mhz_to_cycles_per_ms);
}

double ring_ms(const Machine& machine, double words) {
    return words * bytes_per_word / (machine.ring_channel_mb_s * mhz_to_cycles_per_ms);
}

/// "GP 12 is busy 97 % of 532 ms"
std::string busy_text(const UnitUse& use, double ms) {
    const std::string which =
        use.unit == Unit::host || use.unit == Unit::host_link
            ? std::string(name_of(use.unit))
            : fmt::format("{} {}{}", name_of(use.unit), use.unit == Unit::ring ? "channel " : "",
                          use.index);
    return fmt::format("{} is busiest, {:.0f} % of {:.1f} ms", which, use.busiest * 100, ms);
}

/// Loads of one GP's extraction.
std::vector<Load> extraction(const Machine& machine, const VolumeWork& volume,
                             const BuildWork& build, std::uint32_t gp) {
    double edges = 0, triangles = 0;
    for (std::uint32_t slab = gp; slab + 1 < volume.nz; slab += machine.gps) {
        edges += static_cast<double>(edges_of(volume, slab));
    }
    for (const SlabWork& slab : build.slabs) {
        triangles += slab.slab % machine.gps == gp ? static_cast<double>(slab.triangles) : 0;
    }
    return {{edges, "edges looked at", gp_ms(machine, edges * machine.gp_edge_cycles)},
            {triangles, "triangles made",
             gp_ms(machine, triangles * machine.gp_build_triangle_cycles)}};
}

/// How many times a load would have to be for its unit to take `missing_ms` longer.
std::string instead_text(const std::vector<Load>& loads, double missing_ms) {
    std::string text;
    for (const Load& load : loads) {
        if (load.ms > 0 && load.ms + missing_ms > 0) {
            text += fmt::format("{}{:.2f} times as many {}", text.empty() ? "" : " or ",
                                1 + missing_ms / load.ms, load.what);
        }
    }
    return text.empty() ? "" : "; the paper's time needs " + text;
}

std::string joined(const std::vector<Load>& loads) {
    std::string text;
    for (const Load& load : loads) {
        text += (text.empty() ? "" : ", ") + text_of(load);
    }
    return text;
}

Load draw_load(const Machine& machine, const FrameWork& frame, std::uint32_t gp) {
    double primitives = 0;
    for (const DrawnSlab& slab : frame.drawn) {
        const auto all = static_cast<double>(slab.primitives);
        primitives += machine.share == Sharing::even  ? all / machine.gps
                      : slab.slab % machine.gps == gp ? all
                                                      : 0;
    }
    return {primitives, "primitives drawn",
            gp_ms(machine, primitives * machine.gp_draw_primitive_cycles)};
}

Load emit_load(const Machine& machine, const FrameWork& frame, std::uint32_t gp) {
    double words = 0;
    for (const PartWork& part : frame.parts) {
        const auto all = static_cast<double>(part.words);
        words += machine.share == Sharing::even  ? all / machine.gps
                 : part.slab % machine.gps == gp ? all
                                                 : 0;
    }
    return {words, "words put into bins", gp_ms(machine, words * machine.gp_emit_word_cycles)};
}

/// Loads of the frame's busiest unit.
std::vector<Load> frame_loads(const Machine& machine, const FrameWork& frame, const UnitUse& use) {
    const auto sum = [&frame](const auto& of) {
        return std::accumulate(frame.parts.begin(), frame.parts.end(), 0.0,
                               [&](double before, const PartWork& part) {
                                   return before + static_cast<double>(of(part));
                               });
    };
    const double words = sum([](const PartWork& part) { return part.words; });
    const double pixels = static_cast<double>(frame.regions() * region_pixels);
    switch (use.unit) {
        case Unit::gp:
            return {draw_load(machine, frame, use.index), emit_load(machine, frame, use.index)};
        case Unit::renderer: {
            const double cycles =
                sum([](const PartWork& part) { return part.cycles(); }) / machine.renderers;
            return {{cycles, "cycles a Renderer on average",
                     cycles / (machine.renderer_clock_mhz * mhz_to_cycles_per_ms)}};
        }
        case Unit::ring:
            return {{words + pixels, "words on all channels",
                     ring_ms(machine, (words + pixels) / machine.ring_channels)}};
        case Unit::frame_buffer:
            return {
                {pixels, "words of pixels",
                 ring_ms(machine, pixels / machine.frame_buffer_ports / machine.frame_buffers)}};
        case Unit::host:
        case Unit::host_link:
        case Unit::waiting:
            break;
    }
    return {};
}

double dearest_region_ms(const Machine& machine, const FrameWork& frame) {
    const auto most_expensive = static_cast<double>(std::ranges::max(frame.region_cycles()));
    return most_expensive / (machine.renderer_clock_mhz * mhz_to_cycles_per_ms);
}

}  // namespace

std::string build_reason(const Machine& machine, const VolumeWork& volume, const BuildWork& build,
                         const StepTime& time, double paper_ms) {
    const UnitUse& use = busiest_of(time.use);
    const double ms = static_cast<double>(time.end - time.begin) / ns_per_ms;
    std::string text = busy_text(use, ms);
    if (use.unit == Unit::gp) {
        const std::vector<Load> loads = extraction(machine, volume, build, use.index);
        text += ": " + joined(loads) + instead_text(loads, paper_ms - ms);
    }
    return text + (time.limit == Unit::waiting ? "; the rest is waiting for other units" : "");
}

std::string frames_reason(const Machine& machine, const FrameWork& frame, const Rate& rate) {
    constexpr double ms_per_s = 1e3;
    const UnitUse& use = busiest_of(rate.use);
    std::string text = busy_text(use, ms_per_s / rate.frames_per_s) + " a frame";
    const std::vector<Load> loads = frame_loads(machine, frame, use);
    text += loads.empty() ? "" : ": " + joined(loads);
    const double region_ms = dearest_region_ms(machine, frame);
    if (region_ms * rate.frames_per_s > long_share * ms_per_s) {
        text += fmt::format(
            "; the most expensive region alone keeps its Renderer busy for {:.1f} ms", region_ms);
    }
    if (rate.limit == Unit::waiting) {
        text += fmt::format(
            "; the rest is waiting: for other units, and for a retrace, which comes every {:.1f} "
            "ms",
            ms_per_s / machine.frame_buffer_refresh_hz);
    }
    return text;
}

}  // namespace pxpl5::host::report
