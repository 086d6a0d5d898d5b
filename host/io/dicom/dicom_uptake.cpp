// Units and standardized uptake values of PET files.
#include <fmt/format.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/dicom/dicom_elements.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double day_s = 86'400;
// Limits of what a scanner can have measured. A dose in MBq, for example, is below.
constexpr double least_kg = 0.1, most_kg = 1000, least_bq = 1e5, most_bq = 1e11;
constexpr double most_half_lives = 10;  ///< A thousandth is left then.

/// The number that the digits from `first` on are; nothing if one is no digit.
std::optional<int> digits(std::string_view text, std::size_t first, std::size_t count) {
    if (text.size() < first + count) {
        return std::nullopt;
    }
    int number = 0;
    for (const char digit : text.substr(first, count)) {
        if (digit < '0' || digit > '9') {
            return std::nullopt;
        }
        number = 10 * number + (digit - '0');
    }
    return number;
}

/// Seconds from 1 January 1970 to a date (YYYYMMDD).
std::optional<double> date_s(std::string_view text) {
    const auto year = digits(text, 0, 4), month = digits(text, 4, 2), day = digits(text, 6, 2);
    if (!year || !month || !day) {
        return std::nullopt;
    }
    const std::chrono::year_month_day date{std::chrono::year{*year},
                                           std::chrono::month{static_cast<unsigned>(*month)},
                                           std::chrono::day{static_cast<unsigned>(*day)}};
    if (!date.ok()) {
        return std::nullopt;
    }
    return static_cast<double>(std::chrono::sys_days{date}.time_since_epoch().count()) * day_s;
}

/// Seconds from midnight to a time (HH, HHMM, HHMMSS or HHMMSS.FFFFFF).
std::optional<double> time_s(std::string_view text) {
    const auto hour = digits(text, 0, 2);
    const auto minute = text.size() <= 2 ? 0 : digits(text, 2, 2);
    const auto second = text.size() <= 4 ? 0 : digits(text, 4, 2);
    if (!hour || !minute || !second || *hour > 23 || *minute > 59 || *second > 60) {
        return std::nullopt;
    }
    double fraction = 0, place = 0.1;
    for (std::size_t k = 7; k < text.size() && text[6] == '.'; ++k, place /= 10) {
        const auto digit = digits(text, k, 1);
        if (!digit) {
            return std::nullopt;
        }
        fraction += *digit * place;
    }
    return *hour * 3600.0 + *minute * 60.0 + *second + fraction;
}

/// A date and a time of the data set, in seconds.
std::optional<double> moment_s(const gdcm::DataSet& data, gdcm::Tag date, gdcm::Tag time) {
    const auto day = date_s(text_of(data, date)), within = time_s(text_of(data, time));
    return day && within ? std::optional(*day + *within) : std::nullopt;
}

/// The first number of an element; nothing if there is none above 0.
std::optional<double> positive(const gdcm::DataSet& data, gdcm::Tag tag) {
    try {
        const std::vector<double> numbers = numbers_of("", data, tag);
        return !numbers.empty() && numbers[0] > 0 && std::isfinite(numbers[0])
                   ? std::optional(numbers[0])
                   : std::nullopt;
    } catch (const ImportError&) {
        return std::nullopt;
    }
}

/// Seconds by which a stated offset from UTC ("+0100", "-0530") is east of it.
std::optional<double> offset_s(std::string_view text) {
    const auto hours = digits(text, 1, 2), minutes = digits(text, 3, 2);
    if (!hours || !minutes || (text[0] != '+' && text[0] != '-')) {
        return std::nullopt;
    }
    const double east_s = *hours * 3600.0 + *minutes * 60.0;
    return text[0] == '-' ? -east_s : east_s;
}

/// When the dose was given, in seconds of the scan's clock: its own date and time, or a time of the
/// scan's day. A time after the scan is one of the day before.
std::optional<double> injection_s(const gdcm::DataSet& data, const gdcm::DataSet& dose,
                                  double scan_s) {
    const std::string stated = text_of(dose, gdcm::Tag(0x0018, 0x1078));
    const std::string clock_of_day = text_of(dose, gdcm::Tag(0x0018, 0x1072));
    if (stated.size() >= 10) {
        const std::size_t sign = std::min(stated.find_first_of("+-", 8), stated.size());
        const std::string clock = stated.substr(8, sign - 8);
        const auto day = date_s(stated), within = time_s(clock);
        if (!day || !within) {
            return std::nullopt;
        }
        if (sign == stated.size()) {
            return *day + *within;
        }
        // The scan's own offset. Without it, the clock must be the one that 1072 has.
        const auto east_s = offset_s(std::string_view(stated).substr(sign));
        const auto scan_east_s = offset_s(text_of(data, gdcm::Tag(0x0008, 0x0201)));
        if (east_s && scan_east_s) {
            return *day + *within - *east_s + *scan_east_s;
        }
        const auto local = time_s(clock_of_day);
        return local && std::abs(*local - *within) < 1 ? std::optional(*day + *within)
                                                       : std::nullopt;
    }
    const auto day = date_s(text_of(data, gdcm::Tag(0x0008, 0x0021)));
    const auto within = time_s(clock_of_day);
    if (!day || !within) {
        return std::nullopt;
    }
    const double moment = *day + *within;
    return moment > scan_s ? moment - day_s : moment;
}

/// The item of the tracer, with dose and half-life; nothing if there is none.
const gdcm::DataSet* tracer_of(const gdcm::DataSet& data,
                               gdcm::SmartPointer<gdcm::SequenceOfItems>& items) {
    const gdcm::Tag tag(0x0054, 0x0016);
    if (!data.FindDataElement(tag)) {
        return nullptr;
    }
    items = data.GetDataElement(tag).GetValueAsSQ();
    return items != nullptr && items->GetNumberOfItems() > 0 ? &items->GetItem(1).GetNestedDataSet()
                                                             : nullptr;
}

DicomUptake without(std::string unit, std::string reason) {
    return {std::move(unit), 0, std::move(reason)};
}

/// An element's text with its tag, for a reason.
std::string stated(const gdcm::DataSet& data, gdcm::Tag tag) {
    return fmt::format("'{}' ({:04x},{:04x})", shown(text_of(data, tag)), tag.GetGroup(),
                       tag.GetElement());
}

/// The factor for a dose that has decayed for `halves` half-lives.
DicomUptake from_dose(const std::string& unit, double weight_kg, double dose_bq, double halves) {
    if (weight_kg < least_kg || weight_kg > most_kg) {
        return without(unit, fmt::format("the patient's weight (0010,1030) is {} kg, must be {} to "
                                         "{}",
                                         weight_kg, least_kg, most_kg));
    }
    if (dose_bq < least_bq || dose_bq > most_bq) {
        return without(unit, fmt::format("the dose (0018,1074) is {} Bq, must be {} to {}", dose_bq,
                                         least_bq, most_bq));
    }
    if (halves > most_half_lives) {
        return without(unit, fmt::format("{:.4g} half-lives lie between the injection and the "
                                         "scan, must be at most {}: one of the times may be wrong",
                                         halves, most_half_lives));
    }
    constexpr double grams_per_kg = 1000;
    return {unit, weight_kg * grams_per_kg / (dose_bq * std::exp2(-halves)), ""};
}

/// The factor of values in Bq/ml.
DicomUptake from_activity(const gdcm::DataSet& data) {
    const std::string unit = "Bq/ml";
    const std::string corrected = text_of(data, gdcm::Tag(0x0028, 0x0051));
    for (const char* word : {"ATTN", "DECY"}) {
        if (corrected.find(word) == std::string::npos) {
            return without(unit, fmt::format("corrected image (0028,0051) is '{}', must have {}",
                                             shown(corrected), word));
        }
    }
    const auto weight_kg = positive(data, gdcm::Tag(0x0010, 0x1030));
    if (!weight_kg) {
        return without(unit, fmt::format("the patient's weight is {}, must be above 0 kg",
                                         stated(data, gdcm::Tag(0x0010, 0x1030))));
    }
    gdcm::SmartPointer<gdcm::SequenceOfItems> items;
    const gdcm::DataSet* tracer = tracer_of(data, items);
    const auto dose_bq =
        tracer != nullptr ? positive(*tracer, gdcm::Tag(0x0018, 0x1074)) : std::nullopt;
    if (!dose_bq) {
        return without(unit, tracer == nullptr
                                 ? "the dose is not stated: there is no tracer (0054,0016)"
                                 : fmt::format("the dose is {}, must be above 0 Bq",
                                               stated(*tracer, gdcm::Tag(0x0018, 0x1074))));
    }
    const std::string decay = text_of(data, gdcm::Tag(0x0054, 0x1102));
    if (decay == "ADMIN") {
        return from_dose(unit, *weight_kg, *dose_bq, 0);
    }
    if (decay != "START") {
        return without(unit, fmt::format("decay correction (0054,1102) is '{}', must be START or "
                                         "ADMIN",
                                         shown(decay)));
    }
    const auto half_life_s = positive(*tracer, gdcm::Tag(0x0018, 0x1075));
    if (!half_life_s) {
        return without(unit, fmt::format("the half-life is {}, must be above 0 s",
                                         stated(*tracer, gdcm::Tag(0x0018, 0x1075))));
    }
    const gdcm::Tag series_date(0x0008, 0x0021), series_time(0x0008, 0x0031);
    const gdcm::Tag acquired_date(0x0008, 0x0022), acquired_time(0x0008, 0x0032);
    const auto scan_s = moment_s(data, series_date, series_time);
    if (!scan_s) {
        return without(unit, fmt::format("the series has no valid date {} or time {}",
                                         stated(data, series_date), stated(data, series_time)));
    }
    const auto acquired_s = moment_s(data, acquired_date, acquired_time);
    if (!acquired_s) {
        return without(unit, fmt::format("the acquisition has no valid date {} or time {}",
                                         stated(data, acquired_date), stated(data, acquired_time)));
    }
    if (*scan_s > *acquired_s) {
        return without(unit, fmt::format("the series {} is later than its acquisition {}: it was "
                                         "processed, and does not state to which time its values "
                                         "are corrected",
                                         stated(data, series_time), stated(data, acquired_time)));
    }
    const gdcm::Tag moment(0x0018, 0x1078), clock(0x0018, 0x1072);
    const auto given_s = injection_s(data, *tracer, *scan_s);
    if (!given_s || *given_s > *scan_s) {
        return without(unit, fmt::format("the injection has no usable time: {} or {}, must be "
                                         "before that of the series, {}",
                                         stated(*tracer, moment), stated(*tracer, clock),
                                         stated(data, series_time)));
    }
    return from_dose(unit, *weight_kg, *dose_bq, (*scan_s - *given_s) / *half_life_s);
}

}  // namespace

DicomUptake read_uptake(const gdcm::DataSet& data) {
    const std::string units = text_of(data, gdcm::Tag(0x0054, 0x1001));
    if (units == "BQML") {
        return from_activity(data);
    }
    if (units == "GML") {
        const std::string type = text_of(data, gdcm::Tag(0x0054, 0x1006));
        return type.empty() || type == "BW"
                   ? DicomUptake{"g/ml", 1, ""}
                   : without("g/ml",
                             fmt::format("SUV type (0054,1006) is {}, must be BW", shown(type)));
    }
    return without(shown(units),
                   fmt::format("units (0054,1001) are '{}', must be BQML or GML", shown(units)));
}

}  // namespace pxpl5::host::io
