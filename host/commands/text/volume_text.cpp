#include "host/commands/text/volume_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/base/chart_axis.hpp"
#include "host/phantom/phantom.hpp"
#include "host/surface/atlas/histogram.hpp"

namespace pxpl5::host {

namespace {

glm::dvec3 axis_mm(const Volume& volume, int axis) {
    return glm::dvec3(volume.voxel_to_patient[axis]);
}

/// Whether a finding makes the geometry of the volume uncertain, or says that volumes are missing.
bool is_warning(FindingKind kind) {
    using enum FindingKind;
    return kind == assumption || kind == gantry_tilt || kind == missing_slices ||
           kind == uneven_slices || kind == duplicate_slices || kind == mixed_orientations ||
           kind == thickness_differs || kind == missing_volumes;
}

std::vector<double> list_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

constexpr std::array<int, 5> quantile_percent = {5, 25, 50, 75, 95};
constexpr int histogram_bins = 1024, histogram_rows = 16, histogram_columns = 48;

/// Values that so many percent of the voxels do not exceed, to a bin's width: where isovalues are
/// worth trying.
std::vector<double> quantiles(const Histogram& counted) {
    std::vector<double> values;
    for (const int percent : quantile_percent) {
        values.push_back(quantile(counted, 10 * percent));
    }
    return values;
}

std::string percentiles_text(const std::vector<double>& shares) {
    std::string text = "\npercentiles:";
    for (std::size_t i = 0; i < shares.size(); ++i) {
        text += fmt::format("{} {} % {:.6g}", i == 0 ? "" : ",", quantile_percent[i], shares[i]);
    }
    return text;
}

std::string apart_text(const Volume& volume) {
    if (volume.frame_ms > 0) {
        return fmt::format("volumes are {:.6g} ms apart", volume.frame_ms);
    }
    if (volume.times_ms.empty()) {
        return "the times of the volumes are not stated";
    }
    std::vector<double> steps(volume.times_ms.size());
    std::adjacent_difference(volume.times_ms.begin(), volume.times_ms.end(), steps.begin());
    const auto [least, most] = std::minmax_element(steps.begin() + 1, steps.end());
    return fmt::format("volumes are {:.6g} to {:.6g} ms apart", *least, *most);
}

/// A line about the time series; empty without one.
std::string series_text(const Volume& volume) {
    const std::string place = time_place(volume);
    if (place.empty()) {
        return {};
    }
    return "\ntime series: " + place + "; " + apart_text(volume);
}

}  // namespace

double quantile(const Histogram& counted, int per_mille) {
    std::uint64_t all = 0, below = 0;
    for (const std::uint64_t count : counted.counts) {
        all += count;
    }
    std::size_t bin = 0;
    for (; bin + 1 < counted.counts.size(); ++bin) {
        below += counted.counts[bin];
        if (below * 1000 >= all * static_cast<std::uint64_t>(per_mille)) {
            break;
        }
    }
    return counted.first + counted.width * static_cast<double>(bin);
}

std::string histogram_text(const Histogram& counted, int reduction) {
    if (counted.counts.empty()) {
        return reduction == 1 ? "no voxel is a finite number"
                              : "none of the voxels that the host keeps is a finite number";
    }
    const std::size_t bins = counted.counts.size();
    const std::size_t per_row = (bins + histogram_rows - 1) / histogram_rows;
    std::vector<std::uint64_t> rows((bins + per_row - 1) / per_row);
    for (std::size_t bin = 0; bin < bins; ++bin) {
        rows[bin / per_row] += counted.counts[bin];
    }
    const double most = std::log2(1.0 + static_cast<double>(*std::ranges::max_element(rows)));
    std::string text = "bin start, count (log-scaled bars)";
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const double share = std::log2(1.0 + static_cast<double>(rows[row])) / std::max(1.0, most);
        text += fmt::format("\n{:>10.6g} {:>10} {}",
                            counted.first + counted.width * static_cast<double>(row * per_row),
                            rows[row],
                            std::string(static_cast<std::size_t>(share * histogram_columns), '#'));
    }
    return text;
}

Fields histogram_fields(const Histogram& counted) {
    const std::vector<std::int64_t> counts(counted.counts.begin(), counted.counts.end());
    return {{"first", counted.first}, {"width", counted.width}, {"counts", counts}};
}

std::string place_warning(const Volume& volume) {
    return is_assumed(volume) ? "place or spacing ASSUMED" : "";
}

glm::dvec3 spacing_mm(const Volume& volume) {
    return {glm::length(axis_mm(volume, 0)), glm::length(axis_mm(volume, 1)),
            glm::length(axis_mm(volume, 2))};
}

std::string place_text(const glm::dvec3& p_mm) {
    const auto rounded = [](double mm) { return std::round(mm * 100) / 100 + 0.0; };
    return fmt::format("({:.2f}, {:.2f}, {:.2f})", rounded(p_mm.x), rounded(p_mm.y),
                       rounded(p_mm.z));
}

std::vector<double> place_numbers(const glm::dvec3& p) {
    return {p.x + 0.0, p.y + 0.0, p.z + 0.0};
}

std::string finding_name(FindingKind kind) {
    std::string name = enum_name(kind);
    std::ranges::replace(name, '_', ' ');
    return name;
}

std::string orientation_letters(const Volume& volume) {
    std::string letters;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 direction = axis_mm(volume, axis);
        const glm::dvec3 size = glm::abs(direction);
        const int largest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        letters += direction[largest] > 0 ? "LPS"[largest] : "RAI"[largest];
    }
    return letters;
}

std::string plane_text(const ScenePlane& plane) {
    return fmt::format("{} {}", "xyz"[plane.axis], plane.index);
}

Fields plane_fields(const ScenePlane& plane) {
    return {{"axis", std::string(1, "xyz"[plane.axis])}, {"index", std::int64_t{plane.index}}};
}

std::array<glm::dvec3, 3> direction_cosines(const Volume& volume) {
    std::array<glm::dvec3, 3> cosines{};
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double digits = 1e6;
        // Adding 0 makes 0 of -0.
        cosines[static_cast<std::size_t>(axis)] =
            glm::round(glm::normalize(axis_mm(volume, axis)) * digits) / digits + 0.0;
    }
    return cosines;
}

namespace {

/// Adds unit and windows of the values to `text`, and returns the windows as fields.
std::vector<Fields> tell_values(const Volume& volume, std::string& text) {
    if (!volume.unit.empty()) {
        text += fmt::format("; values in {}", volume.unit);
    }
    std::vector<Fields> windows;
    for (const NamedWindow& window : volume.windows) {
        text += fmt::format("{} {}{}window {:.6g} level {:.6g}",
                            windows.empty() ? "\nof the file:" : ",", window.name,
                            window.name.empty() ? "" : ": ", window.width, window.level);
        windows.push_back(
            {{"name", window.name}, {"window", window.width}, {"level", window.level}});
    }
    return windows;
}

/// Adds the findings to the reply's text and warnings, and returns them as fields.
std::vector<Fields> tell_findings(const Volume& volume, Reply& reply) {
    std::vector<Fields> notes;
    for (const Finding& finding : volume.findings) {
        const std::string kind = finding_name(finding.kind);
        reply.text += fmt::format("\n{}: {}", kind, finding.text);
        if (is_warning(finding.kind)) {
            reply.warnings.push_back(fmt::format("{}: {}", kind, finding.text));
        }
        notes.push_back({{"kind", kind}, {"note", finding.text}});
    }
    return notes;
}

/// Returns "; CT; gradient smooth". Leaves out an unknown modality and central gradients.
std::string kind_text(const Volume& volume) {
    return (volume.modality.empty() ? "" : "; " + volume.modality) +
           (volume.gradient == GradientKernel::smooth ? "; gradient smooth" : "");
}

}  // namespace

std::string ms_text(double ms) {
    constexpr double per_ms = 1000;
    return fmt::format("{}", std::round(ms * per_ms) / per_ms);
}

std::string time_place(const Volume& volume) {
    if (volume.frames == 1) {
        return {};
    }
    const std::optional<double> ms = time_ms(volume, volume.frame);
    return fmt::format("{}/{}{}", volume.frame, volume.frames,
                       ms ? fmt::format(", {} ms", grouped(*ms)) : "");
}

Reply describe_volume(const Volume& volume, VolumeDetail detail) {
    const glm::dvec3 spacing = spacing_mm(volume),
                     extent =
                         spacing * glm::dvec3(volume.nx - 1, volume.ny - 1, last_place(volume));
    const glm::dvec3 origin(volume.voxel_to_patient[3]);
    const std::string type = enum_name(volume.type);
    const std::string letters = orientation_letters(volume);
    Reply reply;
    reply.text = fmt::format(
        "{}: {} x {} x {} voxels of {}, spacing {:.4g} x {:.4g} x {:.4g} mm, {:.0f} x {:.0f} x "
        "{:.0f} mm\nvalues {:.7g} .. {:.7g}; orientation {}, origin ({:.1f}, {:.1f}, {:.1f}) mm "
        "LPS",
        volume.name, volume.nx, volume.ny, volume.nz, type, spacing.x, spacing.y, spacing.z,
        extent.x, extent.y, extent.z, volume.minimum, volume.maximum, letters, origin.x, origin.y,
        origin.z);
    reply.text += kind_text(volume);
    const std::vector<Fields> windows = tell_values(volume, reply.text);
    const std::array<glm::dvec3, 3> cosines = direction_cosines(volume);
    reply.text += "\ndirections";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const glm::dvec3& c = cosines[axis];
        reply.text += fmt::format("{} {} ({:.6g}, {:.6g}, {:.6g})", axis == 0 ? "" : ",",
                                  "xyz"[axis], c.x, c.y, c.z);
    }
    reply.text += " LPS" + series_text(volume);
    const Histogram counted = histogram(volume, histogram_bins);
    const std::vector<double> shares = quantiles(counted);
    reply.text += percentiles_text(shares);
    if (detail == VolumeDetail::all) {
        reply.text += "\n" + histogram_text(counted, volume.reduction);
    }
    const std::vector<Fields> notes = tell_findings(volume, reply);
    std::vector<Fields> surfaces;
    for (const PhantomSurface& surface : suggested_surfaces(volume.name)) {
        reply.text += fmt::format("\nsuggested: surface {} iso={}", surface.name, surface.isovalue);
        surfaces.push_back({{"name", surface.name}, {"isovalue", surface.isovalue}});
    }
    reply.fields = {
        {"name", volume.name},
        {"dims", std::vector<std::int64_t>{volume.nx, volume.ny, volume.nz}},
        {"type", type},
        {"spacing_mm", std::vector<double>{spacing.x, spacing.y, spacing.z}},
        {"origin_mm", std::vector<double>{origin.x, origin.y, origin.z}},
        {"orientation", letters},
        {"x_direction", list_of(cosines[0])},
        {"y_direction", list_of(cosines[1])},
        {"z_direction", list_of(cosines[2])},
        {"minimum", volume.minimum},
        {"maximum", volume.maximum},
        {"reduction", std::int64_t{volume.reduction}},
        {"gradient", std::string(enum_name(volume.gradient))},
        {"quantiles", shares},
        {"histogram", histogram_fields(counted)},
        {"modality", volume.modality},
        {"unit", volume.unit},
        {"windows", windows},
        {"suv_per_value", volume.suv_per_value},
        {"frame", std::int64_t{volume.frame}},
        {"frames", std::int64_t{volume.frames}},
        {"frame_ms", volume.frame_ms},
        {"times_ms", volume.times_ms},
        {"gap_slabs", std::vector<std::int64_t>(volume.gap_slabs.begin(), volume.gap_slabs.end())},
        {"notes", notes},
        {"surfaces", surfaces}};
    return reply;
}

}  // namespace pxpl5::host
