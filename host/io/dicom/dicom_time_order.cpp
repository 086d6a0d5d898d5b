// The slices of one place in the order of time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <set>

#include "host/io/dicom/dicom_series.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double per_ms = 1000;      // Steps are rounded to microseconds, as sums are not exact.
constexpr double most_uneven = 0.1;  // Share of the mean step: a heart's beats differ a little.
constexpr double same_place_mm = 0.05;

using Places = std::vector<std::vector<std::size_t>>;
using Time = std::optional<double> DicomTimes::*;

struct TimeField {
    Time time;
    const char* name;
    bool is_clock = false;    ///< In milliseconds.
    bool is_readable = true;  ///< The value is that of the file.
};
constexpr TimeField position{&DicomTimes::position, "Temporal Position"},
    trigger{&DicomTimes::trigger_ms, "Trigger Time", true},
    acquisition_time{&DicomTimes::acquisition_ms, "Acquisition Time", true, false},
    acquisition_number{&DicomTimes::acquisition, "Acquisition Number"};

/// The slices of one series and their places.
class Order {
  public:
    Order(const std::vector<DicomSlice>& slices, Places places)
        : slices_(&slices), places_(std::move(places)) {}

    const Places& places() const { return places_; }

    bool has(Time time) const {
        return std::ranges::all_of(places_, [&](const std::vector<std::size_t>& place) {
            return std::ranges::all_of(
                place, [&](std::size_t i) { return (slice(i).times.*time).has_value(); });
        });
    }

    /// Sorts the slices of each place. Returns whether no two of one place have the same time.
    bool sort_by(Time time) {
        bool differ = has(time);
        for (std::vector<std::size_t>& place : places_) {
            const auto value = [&](std::size_t i) { return slice(i).times.*time; };
            std::ranges::stable_sort(place, {}, value);
            differ = differ && std::ranges::adjacent_find(place, {}, value) == place.end();
        }
        return differ;
    }

    bool has_as_many_everywhere() const {
        return std::ranges::all_of(places_, [&](const std::vector<std::size_t>& place) {
            return place.size() == places_.front().size();
        });
    }

    /// Why the slices of a place cannot differ in time alone; empty if they can.
    std::string why_not() const {
        for (const std::vector<std::size_t>& place : places_) {
            const DicomSlice& first = slice(place.front());
            for (const std::size_t i : place) {
                if (slice(i).times.kind != first.times.kind) {
                    return "slices of one place differ in more than their time";
                }
                if (glm::distance(slice(i).origin_mm, first.origin_mm) > same_place_mm) {
                    return "slices of one place are shifted sideways";
                }
            }
        }
        if (!has_as_many_everywhere()) {
            return "the number of slices differs from place to place";
        }
        return "";
    }

    /// Removes slices whose time does not occur at every place, if at least half of the times do.
    LeftOut keep_whole_volumes(const TimeField& field) {
        std::map<double, std::size_t> counts;  // Places that have the time.
        std::size_t most = 0;
        for (const std::vector<std::size_t>& place : places_) {
            for (const double time : times_at(place, field.time)) {
                ++counts[time];
            }
            most = std::max(most, place.size());
        }
        const auto is_whole = [&](const auto& each) { return each.second == places_.size(); };
        const auto whole = static_cast<std::size_t>(std::ranges::count_if(counts, is_whole));
        LeftOut left_out;
        if (whole < 2 || 2 * whole < most) {
            return left_out;
        }
        for (std::vector<std::size_t>& place : places_) {
            left_out.slices += std::erase_if(place, [&](std::size_t i) {
                return counts.at(*(slice(i).times.*field.time)) != places_.size();
            });
        }
        std::size_t number = 0;
        for (const auto& each : counts) {
            ++number;
            if (!is_whole(each)) {
                left_out.volumes.push_back(fmt::format(
                    "volume {} of {}{} has {} of {} slices", number, counts.size(),
                    field.is_readable ? fmt::format(" ({} {:g})", field.name, each.first) : "",
                    each.second, places_.size()));
                left_out.has_first = left_out.has_first || number == 1;
            }
        }
        return left_out;
    }

    /// Times from each volume to the next. A volume's time is the mean of its slices'.
    std::vector<double> steps_ms(Time clock) const {
        std::vector<double> steps(places_.front().size() - 1);
        for (const std::vector<std::size_t>& place : places_) {
            for (std::size_t k = 0; k < steps.size(); ++k) {
                const double step =
                    *(slice(place[k + 1]).times.*clock) - *(slice(place[k]).times.*clock);
                steps[k] += step / static_cast<double>(places_.size());
            }
        }
        for (double& step : steps) {
            step = std::round(step * per_ms) / per_ms;
        }
        return steps;
    }

    /// Time from one volume to the next; 0 if the steps differ, or the clock tells another order.
    double step_ms(Time clock) const {
        if (!has(clock)) {
            return 0;
        }
        const std::vector<double> steps = steps_ms(clock);
        const double mean =
            std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
        const bool is_even = std::ranges::all_of(
            steps, [&](double step) { return std::abs(step - mean) <= most_uneven * mean; });
        return is_even && mean <= max_frame_ms ? std::round(mean * per_ms) / per_ms : 0;
    }

    /// Time of each volume after the first; empty if the clock does not ascend with them.
    std::vector<double> times_ms(Time clock) const {
        if (!has(clock)) {
            return {};
        }
        std::vector<double> times = {0};
        for (const double step : steps_ms(clock)) {
            times.push_back(std::round((times.back() + step) * per_ms) / per_ms);
        }
        const bool ascends = std::ranges::adjacent_find(times, std::greater_equal{}) == times.end();
        return ascends && times.back() <= max_frame_ms ? times : std::vector<double>{};
    }

  private:
    const DicomSlice& slice(std::size_t i) const { return (*slices_)[i]; }

    std::set<double> times_at(const std::vector<std::size_t>& place, Time time) const {
        std::set<double> times;
        for (const std::size_t i : place) {
            times.insert(*(slice(i).times.*time));
        }
        return times;
    }

    const std::vector<DicomSlice>* slices_;
    Places places_;
};

/// The fields in the order in which they count. A number in time states the order. After it the
/// heart's clock, but not if it ticks unevenly and the wall's clock evenly: images of contrast
/// medium are taken once a beat, each at about the same time after it.
std::vector<TimeField> fields_of(const Order& order) {
    Order by_trigger = order, by_time = order;
    const bool trigger_is_even =
        by_trigger.sort_by(trigger.time) && by_trigger.step_ms(trigger.time) > 0;
    const bool time_is_even =
        by_time.sort_by(acquisition_time.time) && by_time.step_ms(acquisition_time.time) > 0;
    if (time_is_even && !trigger_is_even) {
        return {position, acquisition_time, trigger, acquisition_number};
    }
    return {position, trigger, acquisition_time, acquisition_number};
}

/// Removes the slices of incomplete volumes. Where all places have the same number of slices, only
/// the number in time shows which volume is incomplete: clocks may differ from place to place.
LeftOut keep_whole_volumes(Order& order) {
    for (const TimeField& field : {position, trigger, acquisition_time, acquisition_number}) {
        Order kept = order;
        const bool tells = field.time == position.time || !order.has_as_many_everywhere();
        if (!tells || !order.has(field.time) || !kept.sort_by(field.time)) {
            continue;
        }
        LeftOut left_out = kept.keep_whole_volumes(field);
        if (left_out.slices > 0) {
            order = kept;
            return left_out;
        }
    }
    return {};
}

/// The time from one volume to the next, or the time of each volume if that differs.
void take_times(const Order& order, const TimeField& field, TimeOrder& found) {
    for (const TimeField& clock : {field, trigger, acquisition_time}) {
        if (found.frame_ms == 0 && clock.is_clock) {
            found.frame_ms = order.step_ms(clock.time);
        }
    }
    for (const TimeField& clock : {field, trigger, acquisition_time}) {
        if (found.frame_ms == 0 && found.times_ms.empty() && clock.is_clock) {
            found.times_ms = order.times_ms(clock.time);
        }
    }
}

}  // namespace

TimeOrder sort_by_time(const std::vector<DicomSlice>& slices, Places& places) {
    TimeOrder found;
    Order whole(slices, places);
    if (std::ranges::all_of(places, [](const auto& place) { return place.size() == 1; })) {
        return found;
    }
    found.left_out = keep_whole_volumes(whole);
    found.why_not = whole.why_not();
    if (!found.why_not.empty() || whole.places().front().size() < 2) {
        found.left_out = {};
        return found;
    }
    for (const TimeField& field : fields_of(whole)) {
        Order order = whole;
        if (!order.sort_by(field.time)) {
            continue;
        }
        places = order.places();
        found.frames = static_cast<int>(places.front().size());
        found.told_by = field.name;
        take_times(order, field, found);
        return found;
    }
    found.left_out = {};
    found.why_not = "no element of time tells the slices of each place apart";
    return found;
}

void report_times(const TimeOrder& times, int frame, std::vector<Finding>& findings) {
    if (times.frames == 1) {
        return;
    }
    findings.push_back(
        {FindingKind::note, fmt::format("volume {} of {} of a time series: {} tells them apart",
                                        frame, times.frames, times.told_by)});
    const LeftOut& left_out = times.left_out;
    const bool has_times = times.frame_ms > 0 || !times.times_ms.empty();
    if (left_out.slices > 0) {
        findings.push_back(
            {FindingKind::missing_volumes,
             fmt::format("{} left out, because their volumes are not whole: {}{}",
                         left_out.slices == 1 ? "1 slice is"
                                              : fmt::format("{} slices are", left_out.slices),
                         few_of(left_out.volumes),
                         left_out.has_first && has_times
                             ? "; times count from the first whole volume"
                             : "")});
    }
}

}  // namespace pxpl5::host::io
