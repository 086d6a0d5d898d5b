// The slices of one place in the order of time.
#include <algorithm>
#include <array>
#include <cmath>

#include "host/io/dicom/dicom_series.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double per_ms = 1000;      // Steps are rounded to microseconds, as sums are not exact.
constexpr double most_uneven = 0.1;  // Share of the mean step: a heart's beats differ a little.

using Places = std::vector<std::vector<std::size_t>>;
using Time = std::optional<double> DicomTimes::*;

struct TimeField {
    Time time;
    const char* name;
};
/// Elements that state an order come first, those that only suggest it last.
constexpr std::array time_fields = {
    TimeField{&DicomTimes::position, "Temporal Position (0020,0100)"},
    TimeField{&DicomTimes::trigger_ms, "Trigger Time (0018,1060)"},
    TimeField{&DicomTimes::acquisition_ms, "Acquisition Time (0008,0032)"},
    TimeField{&DicomTimes::acquisition, "Acquisition Number (0020,0012)"}};
constexpr std::array clocks = {&DicomTimes::trigger_ms, &DicomTimes::acquisition_ms};

/// Whether there are as many slices at each place, of one kind.
bool is_regular(const std::vector<DicomSlice>& slices, const Places& places) {
    return std::ranges::all_of(places, [&](const std::vector<std::size_t>& place) {
        return place.size() == places.front().size() &&
               std::ranges::all_of(place, [&](std::size_t i) {
                   return slices[i].times.kind == slices[place.front()].times.kind;
               });
    });
}

bool has(const std::vector<DicomSlice>& slices, const Places& places, Time time) {
    return std::ranges::all_of(places, [&](const std::vector<std::size_t>& place) {
        return std::ranges::all_of(
            place, [&](std::size_t i) { return (slices[i].times.*time).has_value(); });
    });
}

/// Sorts the slices of each place. Returns whether no two of one place have the same time.
bool sort_by(const std::vector<DicomSlice>& slices, Places& places, Time time) {
    const auto value = [&](std::size_t i) { return *(slices[i].times.*time); };
    bool differ = true;
    for (std::vector<std::size_t>& place : places) {
        std::ranges::stable_sort(place, {}, value);
        differ = differ && std::ranges::adjacent_find(place, {}, value) == place.end();
    }
    return differ;
}

/// Time from one volume to the next; 0 if the steps differ. A volume's time is the mean of its
/// slices'.
double step_ms(const std::vector<DicomSlice>& slices, const Places& places, Time clock) {
    std::vector<double> times(places.front().size());
    for (const std::vector<std::size_t>& place : places) {
        for (std::size_t k = 0; k < times.size(); ++k) {
            times[k] += *(slices[place[k]].times.*clock) / static_cast<double>(places.size());
        }
    }
    const double mean = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
    for (std::size_t k = 1; k < times.size(); ++k) {
        if (!(std::abs(times[k] - times[k - 1] - mean) <= most_uneven * mean)) {
            return 0;
        }
    }
    return mean <= max_frame_ms ? std::round(mean * per_ms) / per_ms : 0;
}

}  // namespace

TimeOrder sort_by_time(const std::vector<DicomSlice>& slices, Places& places) {
    if (places.front().size() < 2 || !is_regular(slices, places)) {
        return {};
    }
    for (const TimeField& field : time_fields) {
        Places sorted = places;
        if (!has(slices, places, field.time) || !sort_by(slices, sorted, field.time)) {
            continue;
        }
        places = std::move(sorted);
        TimeOrder order{static_cast<int>(places.front().size()), 0, field.name};
        for (const Time clock : clocks) {
            if (order.frame_ms <= 0 && has(slices, places, clock)) {
                order.frame_ms = step_ms(slices, places, clock);
            }
        }
        return order;
    }
    return {};
}

}  // namespace pxpl5::host::io
