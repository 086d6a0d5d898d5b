// Slices of one series by position, and the distances between them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/values/frames.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double same_position_mm = 1e-3;
constexpr double max_uneven = 0.01;      // Share of the usual step: positions have few digits.
constexpr double gap_steps = 1.5;        // Wider slabs span missing slices.
constexpr double same_direction = 1e-3;  // Length for a unit vector: 0.06 degrees.
constexpr double same_spacing = 1e-3;    // Share of the spacing.
constexpr double max_sideways_mm = 0.05;
constexpr std::size_t max_named = 8;      // Limit per kind in one finding.
constexpr std::size_t max_shapes = 1024;  // A file for each would be no series.

bool is_same_step(glm::dvec3 a, glm::dvec3 b) {
    return std::abs(glm::length(a) - glm::length(b)) <= same_spacing * glm::length(a) &&
           glm::length(glm::normalize(a) - glm::normalize(b)) <= same_direction;
}

bool is_same_shape(const DicomSlice& a, const DicomSlice& b) {
    return a.columns == b.columns && a.rows == b.rows && is_same_step(a.x_step_mm, b.x_step_mm) &&
           is_same_step(a.y_step_mm, b.y_step_mm);
}

/// The largest set of one size and orientation; of equally large ones the first.
std::vector<DicomSlice> largest_shape(const std::string& source, std::vector<DicomSlice> series,
                                      std::vector<Finding>& findings) {
    std::vector<std::vector<DicomSlice>> shapes;
    for (DicomSlice& slice : series) {
        const auto same = std::find_if(shapes.begin(), shapes.end(), [&](const auto& shape) {
            return is_same_shape(shape.front(), slice);
        });
        if (same != shapes.end()) {
            same->push_back(std::move(slice));
        } else if (shapes.size() == max_shapes) {
            throw ImportError(fmt::format("{}: its slices have more than {} sizes and orientations",
                                          source, max_shapes));
        } else {
            shapes.push_back({std::move(slice)});
        }
    }
    const auto largest =
        std::max_element(shapes.begin(), shapes.end(),
                         [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (const auto& shape : shapes) {
        if (&shape != &*largest) {
            findings.push_back(
                {FindingKind::mixed_orientations,
                 fmt::format("{} slices of {}x{} in another orientation or size are left out, the "
                             "first is {}",
                             shape.size(), shape.front().columns, shape.front().rows,
                             name_of(shape.front()))});
        }
    }
    return std::move(*largest);
}

/// Frames of one file that have no positions lie as far apart as the file says.
void place_frames(const std::string& source, std::vector<DicomSlice>& slices,
                  const ImportRequest& request, std::vector<Finding>& findings) {
    const DicomSlice& first = slices.front();
    const bool wished = request.spacing_mm.has_value();
    if (!first.frame_step_mm && !wished) {
        throw ImportError(fmt::format(
            "{}: its {} frames state neither positions (0020,0032) nor a distance (0018,0088): "
            "give spacing=x,y,z in millimeters",
            source, slices.size()));
    }
    const double step = first.frame_step_mm ? *first.frame_step_mm : request.spacing_mm->z;
    const glm::dvec3 normal = glm::normalize(glm::cross(first.x_step_mm, first.y_step_mm));
    for (DicomSlice& slice : slices) {
        slice.origin_mm += normal * (step * slice.frame);
    }
    findings.push_back(
        {FindingKind::assumption,
         fmt::format("the frames state no positions of their own: they are taken as {} "
                     "mm apart ({})",
                     step, first.frame_step_mm ? "0018,0088" : "as asked for")});
}

void check_positions(const std::string& source, std::vector<DicomSlice>& slices,
                     const ImportRequest& request, std::vector<Finding>& findings) {
    const auto without = std::find_if(slices.begin(), slices.end(), [](const DicomSlice& slice) {
        return !slice.position_stated;
    });
    if (without == slices.end()) {
        return;
    }
    if (slices.size() == 1) {
        findings.push_back({FindingKind::assumption,
                            "the slice states no position and orientation (0020,0032 and "
                            "0020,0037): x, y, z are taken as left, posterior, superior"});
        return;
    }
    const bool one_file = std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& slice) {
        return slice.path == slices.front().path && !slice.position_stated;
    });
    if (one_file) {
        place_frames(source, slices, request, findings);
        return;
    }
    throw ImportError(
        fmt::format("{}: {} states no position and orientation (0020,0032 and 0020,0037), so the "
                    "slices have no order",
                    source, name_of(*without)));
}

/// `places`  Indices of the slices at each place, of which the first is kept.
void report_duplicates(const std::vector<std::vector<std::size_t>>& places,
                       const std::vector<std::string>& copies, const TimeOrder& times,
                       std::vector<Finding>& findings) {
    if (copies.empty()) {
        return;
    }
    const auto [least, most] = std::ranges::minmax(places, {}, &std::vector<std::size_t>::size);
    const bool may_be_series = least.size() > 1 && places.size() > 1;
    const std::string times_there = least.size() == most.size()
                                        ? std::to_string(most.size())
                                        : fmt::format("{} to {}", least.size(), most.size());
    findings.push_back(
        {FindingKind::duplicate_slices,
         fmt::format("{} slices have the position of another and are left out{}: {}", copies.size(),
                     may_be_series
                         ? fmt::format(" (each position occurs {} times, but this is no time "
                                       "series: {}; the shown volume may mix them)",
                                       times_there, times.why_not)
                         : "",
                     few_of(copies))});
}

double median_of(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Distances between slices, and those that are usual where they are.
struct Steps {
    std::vector<double> mm, usual_mm;
    double median_mm = 0;
    double per_thickness = 0;  ///< Above 0: the usual steps are this share of the thicknesses.
    std::string usual;         ///< For texts: "2 mm".
};

bool is_close(double step, double usual) {
    return std::abs(step - usual) <= max_uneven * usual;
}

/// Steps follow the thickness of their own two slices if that makes more of them usual: a head
/// scanned in blocks of thin and thick slices has no gaps.
void follow_thickness(const std::vector<DicomSlice>& slices, Steps& steps) {
    std::vector<double> thickness;
    for (const DicomSlice& slice : slices) {
        thickness.push_back(slice.thickness_mm.value_or(0));
    }
    const auto [thinnest, thickest] = std::minmax_element(thickness.begin(), thickness.end());
    if (!(*thinnest > 0) || is_close(*thinnest, *thickest)) {
        return;
    }
    std::vector<double> usual_mm(steps.mm.size()), shares(steps.mm.size());
    for (std::size_t i = 0; i < steps.mm.size(); ++i) {
        usual_mm[i] = (thickness[i] + thickness[i + 1]) / 2;
        shares[i] = steps.mm[i] / usual_mm[i];
    }
    const double share = median_of(shares);
    std::ptrdiff_t by_thickness = 0, by_median = 0;
    for (std::size_t i = 0; i < steps.mm.size(); ++i) {
        usual_mm[i] *= share;
        by_thickness += is_close(steps.mm[i], usual_mm[i]) ? 1 : 0;
        by_median += is_close(steps.mm[i], steps.median_mm) ? 1 : 0;
    }
    if (by_thickness > by_median) {
        steps.usual_mm = usual_mm;
        steps.per_thickness = share;
        steps.usual = fmt::format("as their thicknesses, {} to {} mm", *thinnest, *thickest);
    }
}

Steps steps_of(const OrderedSlices& ordered) {
    Steps steps;
    steps.mm.resize(ordered.along_mm.size());
    std::adjacent_difference(ordered.along_mm.begin(), ordered.along_mm.end(), steps.mm.begin());
    steps.mm.erase(steps.mm.begin());
    steps.median_mm = median_of(steps.mm);
    steps.usual_mm.assign(steps.mm.size(), steps.median_mm);
    steps.usual = fmt::format("{:.3f} mm", steps.median_mm);
    follow_thickness(ordered.slices, steps);
    return steps;
}

/// Whether nothing can be missing between two neighbors: each reaches halfway to the other.
bool touch(const DicomSlice& a, const DicomSlice& b, double step_mm) {
    const double reach_mm = (a.thickness_mm.value_or(0) + b.thickness_mm.value_or(0)) / 2;
    return step_mm <= reach_mm * (1 + max_uneven);
}

void report_steps(const OrderedSlices& ordered, const Steps& steps, Volume& volume) {
    std::vector<std::string> gaps, uneven;
    double missing_mm = 0;
    int missing = 0;
    for (std::size_t i = 0; i < steps.mm.size(); ++i) {
        const double step = steps.mm[i], usual = steps.usual_mm[i];
        const std::string text =
            fmt::format("{:.3f} mm from {} to {}", step, name_of(ordered.slices[i]),
                        name_of(ordered.slices[i + 1]));
        if (step > gap_steps * usual && !touch(ordered.slices[i], ordered.slices[i + 1], step)) {
            volume.gap_slabs.push_back(static_cast<int>(i));
            gaps.push_back(text);
            missing += static_cast<int>(std::lround(std::min(step / usual, 1e6))) - 1;
            missing_mm += step - usual;
        } else if (!is_close(step, steps.median_mm)) {
            uneven.push_back(text);
        }
    }
    if (!gaps.empty()) {
        volume.findings.push_back(
            {FindingKind::missing_slices,
             fmt::format("about {} {} missing, {:.3f} mm in all: {}; elsewhere {}", missing,
                         missing == 1 ? "slice is" : "slices are", missing_mm, few_of(gaps),
                         steps.usual)});
    }
    if (!uneven.empty()) {
        volume.findings.push_back(
            {FindingKind::uneven_slices,
             fmt::format("{} of {} steps between slices are uneven: {}; {}{}", uneven.size(),
                         steps.mm.size(), few_of(uneven),
                         steps.per_thickness > 0 ? "the usual ones are " : "the median is ",
                         steps.usual)});
    }
}

/// Slices that do not lie behind each other on one line.
void report_sideways(const OrderedSlices& ordered, Volume& volume) {
    const glm::dvec3 first = ordered.slices.front().origin_mm;
    const glm::dvec3 whole = ordered.slices.back().origin_mm - first;
    const double length = ordered.along_mm.back() - ordered.along_mm.front();
    double most_mm = 0;
    for (std::size_t i = 0; i < ordered.slices.size(); ++i) {
        const double part = (ordered.along_mm[i] - ordered.along_mm.front()) / length;
        most_mm =
            std::max(most_mm, glm::length(ordered.slices[i].origin_mm - first - whole * part));
    }
    if (most_mm > max_sideways_mm) {
        volume.findings.push_back(
            {FindingKind::uneven_slices,
             fmt::format("slices are shifted sideways by up to {:.3f} mm from a straight row; they "
                         "are shown in a straight row",
                         most_mm)});
    }
}

void report_thickness(const DicomSlice& first, const Steps& steps, double step_mm, Volume& volume) {
    const bool follows = steps.per_thickness > 0;
    if (!first.thickness_mm || (follows && is_close(steps.per_thickness, 1)) ||
        (!follows && is_close(*first.thickness_mm, step_mm))) {
        return;
    }
    const bool overlap = follows ? steps.per_thickness < 1 : *first.thickness_mm > step_mm;
    const std::string differs =
        follows ? fmt::format("slices are {:.3f} of their thickness apart", steps.per_thickness)
                : fmt::format("slices are {:.3f} mm apart and {:.3f} mm thick", step_mm,
                              *first.thickness_mm);
    volume.findings.push_back(
        {FindingKind::thickness_differs, fmt::format("{} ({}); the distance counts", differs,
                                                     overlap ? "they overlap" : "there are gaps")});
}

/// The z step of a single slice: nothing states one.
glm::dvec3 single_step(const DicomSlice& slice, const ImportRequest& request, Volume& volume) {
    const glm::dvec3 normal = glm::normalize(glm::cross(slice.x_step_mm, slice.y_step_mm));
    const double thickness = slice.thickness_mm.value_or(0);
    const double step = request.spacing_mm ? request.spacing_mm->z
                        : thickness > 0    ? thickness
                                           : 1.0;
    volume.findings.push_back(
        {request.spacing_mm ? FindingKind::note : FindingKind::assumption,
         fmt::format("a single slice has no distance to another: {} mm is taken along z ({})", step,
                     request.spacing_mm ? "as asked for"
                     : thickness > 0    ? "its thickness"
                                        : "its thickness is not stated either")});
    return normal * step;
}

}  // namespace

std::string few_of(const std::vector<std::string>& names) {
    const std::vector<std::string> few(
        names.begin(),
        names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), max_named)));
    const std::string rest =
        names.size() > max_named ? fmt::format(" and {} more", names.size() - max_named) : "";
    return fmt::format("{}{}", fmt::join(few, "; "), rest);
}

OrderedSlices order_slices(const std::string& source, std::vector<DicomSlice> series,
                           const ImportRequest& request, std::vector<Finding>& findings) {
    std::vector<DicomSlice> slices = largest_shape(source, std::move(series), findings);
    check_positions(source, slices, request, findings);
    const DicomSlice& shape = slices.front();
    const glm::dvec3 normal = glm::normalize(glm::cross(shape.x_step_mm, shape.y_step_mm));
    std::vector<std::size_t> order(slices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto along = [&](std::size_t i) { return glm::dot(slices[i].origin_mm, normal); };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return along(a) < along(b); });
    std::vector<std::vector<std::size_t>> places;
    for (const std::size_t i : order) {
        if (places.empty() || !(along(i) - along(places.back().front()) < same_position_mm)) {
            places.emplace_back();
        }
        places.back().push_back(i);
    }
    for (std::vector<std::size_t>& place : places) {
        std::ranges::stable_sort(place, {},
                                 [&](std::size_t i) { return slices[i].instance_number; });
    }
    const TimeOrder times = sort_by_time(slices, places);
    check_frame(source, "series", request.frame, static_cast<std::uint64_t>(times.frames),
                times.why_not);
    OrderedSlices ordered{{},
                          {},
                          std::max(static_cast<int>(request.frame), 1),
                          times.frames,
                          times.frame_ms,
                          times.times_ms};
    report_times(times, ordered.frame, findings);
    // Without an order in time, the first image of the series counts at each place.
    const auto taken = static_cast<std::size_t>(ordered.frame - 1);
    std::vector<std::string> copies;
    for (const std::vector<std::size_t>& place : places) {
        // All volumes of a time series have the places of the first.
        ordered.slices.push_back(slices[place[taken]]);
        ordered.slices.back().origin_mm = slices[place[0]].origin_mm;
        ordered.along_mm.push_back(along(place[0]));
        for (std::size_t copy = 1; copy < place.size() && times.frames == 1; ++copy) {
            copies.push_back(fmt::format("{} has that of {}", name_of(slices[place[copy]]),
                                         name_of(slices[place[0]])));
        }
    }
    report_duplicates(places, copies, times, findings);
    return ordered;
}

void place_slices(const OrderedSlices& ordered, const ImportRequest& request, Volume& volume) {
    const DicomSlice& first = ordered.slices.front();
    glm::dvec3 z_step_mm(0);
    if (ordered.slices.size() == 1) {
        z_step_mm = single_step(first, request, volume);
    } else {
        const Steps steps = steps_of(ordered);
        const auto [least, most] = std::minmax_element(steps.mm.begin(), steps.mm.end());
        const double median = steps.median_mm;
        const glm::dvec3 whole = ordered.slices.back().origin_mm - first.origin_mm;
        const double length = ordered.along_mm.back() - ordered.along_mm.front();
        const bool is_even = is_close(*least, median) && is_close(*most, median);
        // Over an even series the mean is the better estimate: each position is rounded.
        const double step = is_even ? length / static_cast<double>(steps.mm.size()) : median;
        z_step_mm = whole * (step / length);
        report_steps(ordered, steps, volume);
        for (const double along_mm : ordered.along_mm) {
            if (!is_even) {
                volume.slice_places.push_back((along_mm - ordered.along_mm.front()) / step);
            }
        }
        report_sideways(ordered, volume);
        report_thickness(first, steps, step, volume);
    }
    volume.voxel_to_patient =
        glm::dmat4(glm::dvec4(first.x_step_mm, 0), glm::dvec4(first.y_step_mm, 0),
                   glm::dvec4(z_step_mm, 0), glm::dvec4(first.origin_mm, 1));
}

}  // namespace pxpl5::host::io
