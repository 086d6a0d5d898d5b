#include "host/io/dicom/dicom_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t max_listed_series = 50;

using Series = std::vector<DicomSlice>;

/// Values that slices of one series share. Without a UID, other values distinguish series.
using SeriesKey = std::tuple<int, std::string, std::string, std::string, int, int>;

SeriesKey key_of(const DicomSlice& slice) {
    if (!slice.series.empty()) {
        return {slice.series_number, slice.series, "", "", 0, 0};
    }
    return {slice.series_number, "", slice.modality, slice.description, slice.columns, slice.rows};
}

/// "2: 1.2.840.1 'Thorax 3 mm', CT, 512x512x112, SeriesNumber 3".
std::string line_of(std::size_t number, const Series& series) {
    const DicomSlice& first = series.front();
    const std::string uid = first.series.empty() ? "(no UID)" : shown(first.series);
    return fmt::format(
        "{}: {} '{}', {}, {}x{}x{}{}", number, uid, shown(first.description),
        first.modality.empty() ? "no modality" : shown(first.modality), first.columns, first.rows,
        series.size(),
        first.series_number == 0 ? "" : fmt::format(", SeriesNumber {}", first.series_number));
}

std::string list_of(const std::vector<Series>& all) {
    std::string list;
    for (std::size_t i = 0; i < std::min(all.size(), max_listed_series); ++i) {
        list += "\n  " + line_of(i + 1, all[i]);
    }
    if (all.size() > max_listed_series) {
        list += fmt::format("\n  and {} more", all.size() - max_listed_series);
    }
    return list;
}

std::vector<std::size_t> with_number(const std::vector<Series>& all, const std::string& wish) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const int number = all[i].front().series_number;
        if (number != 0 && wish == std::to_string(number)) {
            found.push_back(i);
        }
    }
    return found;
}

/// Index of the series that is asked for, by its place in the list, its UID or its SeriesNumber. If
/// the place of one is the SeriesNumber of another, the place counts, and a finding says so.
std::size_t choose(const std::string& source, const std::vector<Series>& all,
                   const std::string& wish, std::vector<Finding>& findings) {
    if (wish.empty() && all.size() == 1) {
        return 0;
    }
    const std::vector<std::size_t> numbered = with_number(all, wish);
    for (std::size_t i = 0; i < all.size() && !wish.empty(); ++i) {
        if (wish == std::to_string(i + 1) && !numbered.empty() && numbered[0] != i) {
            findings.push_back(
                {FindingKind::other_series,
                 fmt::format("series={0} is number {0} of the list; the series with SeriesNumber "
                             "{0} is left out, its UID is {1}",
                             wish, shown(all[numbered[0]].front().series))});
        }
        if (wish == std::to_string(i + 1) || wish == all[i].front().series) {
            return i;
        }
    }
    if (numbered.size() == 1) {
        return numbered[0];
    }
    if (wish.empty() || !numbered.empty()) {
        throw ImportError(fmt::format(
            "{}: holds {} series{}: choose one by series=N or its UID:{}", source, all.size(),
            wish.empty() ? "" : " and more than one of that SeriesNumber", list_of(all)));
    }
    throw ImportError(fmt::format("{}: has no series '{}', it holds {}:{}", source, shown(wish),
                                  all.size(), list_of(all)));
}

/// Slices with one key are the same image of an archive. Equal UIDs are not enough: some programs
/// that remove names give all images one UID.
std::string copy_key(const DicomSlice& slice) {
    const glm::dvec3& at = slice.origin_mm;
    const DicomTimes& times = slice.times;
    const glm::dvec3 &x = slice.x_step_mm, &y = slice.y_step_mm;
    std::string key =
        fmt::format("{} {} {} {} {}x{} {} {} {} {} {} {} {} {} {} {}", slice.instance, slice.frame,
                    slice.tile, slice.instance_number, slice.columns, slice.rows, at.x, at.y, at.z,
                    x.x, x.y, x.z, y.x, y.y, y.z, times.kind);
    for (const std::optional<double>& time :
         {times.position, times.trigger_ms, times.acquisition_ms, times.acquisition}) {
        key += time ? fmt::format(" {}", *time) : " -";
    }
    return key;
}

/// The slices of a series without copies of images, for example from a second folder.
Series without_copies(Series series, std::vector<Finding>& findings) {
    std::map<std::string, std::string> names;  // Of the slices that stay, by their keys.
    std::size_t copies = 0;
    std::string first_copy;
    std::erase_if(series, [&](const DicomSlice& slice) {
        if (slice.instance.empty()) {
            return false;
        }
        const auto [kept, is_new] = names.try_emplace(copy_key(slice), name_of(slice));
        if (!is_new && copies++ == 0) {
            first_copy = fmt::format("{} has the image of {} (SOP Instance UID {})", name_of(slice),
                                     kept->second, shown(slice.instance));
        }
        return !is_new;
    });
    if (copies > 0) {
        findings.push_back(
            {FindingKind::note,
             fmt::format("{} left out: {}{}",
                         copies == 1 ? "1 copy of a slice is"
                                     : fmt::format("{} copies of slices are", copies),
                         first_copy, copies == 1 ? "" : ", for example")});
    }
    return series;
}

void report_slices(const Series& slices, std::vector<Finding>& findings) {
    const auto [low, high] = std::minmax_element(
        slices.begin(), slices.end(),
        [](const DicomSlice& a, const DicomSlice& b) { return a.scale.slope < b.scale.slope; });
    const bool same = std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& slice) {
        return slice.scale == slices.front().scale;
    });
    if (!same) {
        findings.push_back(
            {FindingKind::note,
             fmt::format("each slice has its own rescale slope, {} to {}, and intercept",
                         low->scale.slope, high->scale.slope)});
    }
    const auto lossy = std::count_if(slices.begin(), slices.end(),
                                     [](const DicomSlice& slice) { return slice.is_lossy; });
    if (lossy > 0) {
        findings.push_back(
            {FindingKind::note, fmt::format("{} of {} slices were compressed with loss: their "
                                            "values are not those of the scanner",
                                            lossy, slices.size())});
    }
    if (slices.front().tiles_across > 1) {
        findings.push_back({FindingKind::note,
                            fmt::format("a Siemens mosaic of {} slices, placed by its CSA header",
                                        slices.size())});
    }
    if (slices.front().is_inverted()) {
        findings.push_back({FindingKind::note,
                            "MONOCHROME1: small values are meant to look bright; the values are "
                            "as stored"});
    }
}

/// Windows and unit of the slices. Where they differ, as windows of MR often do, those of the
/// middle slice count. A factor to standardized uptake values must be that of all slices.
void take_display(const Series& slices, Volume& volume) {
    constexpr double tolerance = 1e-6;
    const DicomSlice& middle = slices[slices.size() / 2];
    volume.windows = middle.windows;
    if (!middle.uptake) {
        return;
    }
    const DicomUptake& uptake = *middle.uptake;
    volume.unit = uptake.unit;
    const auto other = std::ranges::find_if(slices, [&](const DicomSlice& slice) {
        return !slice.uptake || slice.uptake->unit != uptake.unit ||
               !(std::abs(slice.uptake->suv_per_value - uptake.suv_per_value) <=
                 tolerance * uptake.suv_per_value);
    });
    std::string reason = uptake.reason;
    if (reason.empty() && other != slices.end()) {
        const DicomUptake found =
            other->uptake.value_or(DicomUptake{"", 0, "it has no values of PET"});
        reason = fmt::format("slices differ: {}: {}; {}: a value of 1 {} is {:.6g} g/ml",
                             other->path.filename().string(),
                             !found.reason.empty() ? found.reason
                                                   : fmt::format("a value of 1 {} is {:.6g} g/ml",
                                                                 found.unit, found.suv_per_value),
                             middle.path.filename().string(), uptake.unit, uptake.suv_per_value);
    }
    if (reason.empty()) {
        volume.suv_per_value = uptake.suv_per_value;
        volume.findings.push_back(
            {FindingKind::note, fmt::format("the standardized uptake value (SUV) by body weight "
                                            "is the value x {:.6g}",
                                            volume.suv_per_value)});
    } else {
        volume.findings.push_back(
            {FindingKind::note, "no standardized uptake values (SUV): " + reason});
    }
}

std::array<bool, 3> spacing_stated(const Series& slices) {
    const bool pixels = std::all_of(slices.begin(), slices.end(),
                                    [](const DicomSlice& slice) { return slice.spacing_stated; });
    const DicomSlice& first = slices.front();
    return {pixels, pixels,
            slices.size() > 1 && (first.position_stated || first.frame_step_mm.has_value())};
}

}  // namespace

std::string name_of(const DicomSlice& slice) {
    const std::string file = shown(slice.path.filename().string());
    if (slice.tiles_across > 1) {
        return fmt::format("tile {} of {}", slice.tile + 1, file);
    }
    return slice.frames == 1 ? file : fmt::format("frame {} of {}", slice.frame + 1, file);
}

std::vector<Series> series_of(std::vector<DicomSlice> slices) {
    std::map<SeriesKey, Series> by_key;
    for (DicomSlice& slice : slices) {
        by_key[key_of(slice)].push_back(std::move(slice));
    }
    std::vector<Series> all;
    for (auto& [key, series] : by_key) {
        all.push_back(std::move(series));
    }
    return all;
}

OrderedSeries order_series(const std::string& source, std::vector<DicomSlice> slices,
                           const ImportRequest& request) {
    const std::vector<Series> all = series_of(std::move(slices));
    Volume volume;
    const std::size_t chosen = choose(source, all, request.series, volume.findings);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i != chosen) {
            volume.findings.push_back({FindingKind::other_series,
                                       "another series is left out: " + line_of(i + 1, all[i])});
        }
    }
    OrderedSlices ordered = order_slices(source, without_copies(all[chosen], volume.findings),
                                         request, volume.findings);
    const DicomSlice& first = ordered.slices.front();
    if (ordered.slices.size() > max_volume_voxels) {
        throw ImportError(fmt::format("{}: {} voxels along z, must be 1 to {}", source,
                                      ordered.slices.size(), max_volume_voxels));
    }
    volume.nx = first.columns;
    volume.ny = first.rows;
    volume.nz = static_cast<int>(ordered.slices.size());
    volume.modality = first.modality;
    volume.series = first.series;
    volume.frame = ordered.frame;
    volume.frames = ordered.frames;
    volume.frame_ms = ordered.frame_ms;
    volume.times_ms = ordered.times_ms;
    place_slices(ordered, request, volume);
    report_slices(ordered.slices, volume.findings);
    take_display(ordered.slices, volume);
    const std::array<bool, 3> stated = spacing_stated(ordered.slices);
    return {{std::move(volume), stated}, std::move(ordered.slices)};
}

SeriesVolume decode_series(const std::string& source, OrderedSeries series,
                           const DecodeSlice& decode) {
    Volume& volume = series.result.volume;
    const std::size_t slice_values =
        static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny);
    check_volume_bytes(source, fmt::format("{}x{}x{} of 2 bytes", volume.nx, volume.ny, volume.nz),
                       slice_values * series.slices.size() * 2);
    ValueSink sink(slice_values * series.slices.size());
    for (const DicomSlice& slice : series.slices) {
        decode(slice, sink);
    }
    sink.finish(source, volume);
    return std::move(series.result);
}

SeriesVolume assemble_series(const std::string& source, std::vector<DicomSlice> slices,
                             const ImportRequest& request, const DecodeSlice& decode) {
    return decode_series(source, order_series(source, std::move(slices), request), decode);
}

}  // namespace pxpl5::host::io
