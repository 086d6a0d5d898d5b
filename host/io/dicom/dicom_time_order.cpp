// The slices of one place in the order of time.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
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
};
constexpr TimeField position{&DicomTimes::position, "Temporal Position"},
    trigger{&DicomTimes::trigger_ms, "Trigger Time"},
    acquisition_time{&DicomTimes::acquisition_ms, "Acquisition Time"},
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
            if (place.size() != places_.front().size()) {
                return "not all places have as many slices";
            }
        }
        return "";
    }

    /// Leaves out slices whose number in time is not there at each place. Returns how many.
    std::size_t keep_whole_volumes() {
        std::set<double> whole = positions_at(places_.front());
        for (const std::vector<std::size_t>& place : places_) {
            const std::set<double> here = positions_at(place);
            std::erase_if(whole, [&](double number) { return !here.contains(number); });
        }
        std::size_t left_out = 0;
        for (std::vector<std::size_t>& place : places_) {
            if (!whole.empty()) {
                left_out += std::erase_if(place, [&](std::size_t i) {
                    return !whole.contains(*slice(i).times.position);
                });
            }
        }
        return left_out;
    }

    /// Time from one volume to the next; 0 if the steps differ, or an order is not that of the
    /// clock. A volume's time is the mean of its slices'.
    double step_ms(Time clock) const {
        if (!has(clock)) {
            return 0;
        }
        const double begin = *(slice(places_.front().front()).times.*clock);
        std::vector<double> times(places_.front().size());
        for (const std::vector<std::size_t>& place : places_) {
            for (std::size_t k = 0; k < times.size(); ++k) {
                times[k] +=
                    (*(slice(place[k]).times.*clock) - begin) / static_cast<double>(places_.size());
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

  private:
    const DicomSlice& slice(std::size_t i) const { return (*slices_)[i]; }

    std::set<double> positions_at(const std::vector<std::size_t>& place) const {
        std::set<double> numbers;
        for (const std::size_t i : place) {
            numbers.insert(*slice(i).times.position);
        }
        return numbers;
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

}  // namespace

TimeOrder sort_by_time(const std::vector<DicomSlice>& slices, Places& places) {
    TimeOrder found;
    Order whole(slices, places);
    if (std::ranges::all_of(places, [](const auto& place) { return place.size() == 1; })) {
        return found;
    }
    if (whole.has(position.time)) {
        found.left_out = whole.keep_whole_volumes();
    }
    found.why_not = whole.why_not();
    if (!found.why_not.empty() || whole.places().front().size() < 2) {
        found.left_out = 0;
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
        for (const TimeField& clock : {field, trigger, acquisition_time}) {
            const bool is_clock = clock.time == trigger.time || clock.time == acquisition_time.time;
            if (found.frame_ms == 0 && is_clock) {
                found.frame_ms = order.step_ms(clock.time);
            }
        }
        return found;
    }
    found.left_out = 0;
    found.why_not = "no element of time tells the slices of each place apart";
    return found;
}

}  // namespace pxpl5::host::io
