// Units and standardized uptake values of PET files.
#include <fmt/format.h>
#include <gdcmSequenceOfItems.h>

#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "host/io/dicom/dicom_elements.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double day_s = 86'400;

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

/// When the dose was given, in seconds: its own date and time, or a time of the scan's day. A time
/// after the scan is one of the day before.
std::optional<double> injection_s(const gdcm::DataSet& data, const gdcm::DataSet& dose,
                                  double scan_s) {
    const std::string stated = text_of(dose, gdcm::Tag(0x0018, 0x1078));
    if (stated.size() >= 10) {
        // An offset from UTC may follow. The scan's date and time have none, so it counts for both.
        const std::string clock = stated.substr(8, stated.find_first_of("+-", 8) - 8);
        const auto day = date_s(stated), within = time_s(clock);
        return day && within ? std::optional(*day + *within) : std::nullopt;
    }
    const auto day = date_s(text_of(data, gdcm::Tag(0x0008, 0x0021)));
    const auto within = time_s(text_of(dose, gdcm::Tag(0x0018, 0x1072)));
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
        return without(unit, "the patient's weight (0010,1030) is not stated");
    }
    gdcm::SmartPointer<gdcm::SequenceOfItems> items;
    const gdcm::DataSet* tracer = tracer_of(data, items);
    const auto dose_bq =
        tracer != nullptr ? positive(*tracer, gdcm::Tag(0x0018, 0x1074)) : std::nullopt;
    if (!dose_bq) {
        return without(unit, "the dose (0018,1074) is not stated");
    }
    constexpr double grams_per_kg = 1000;
    const std::string decay = text_of(data, gdcm::Tag(0x0054, 0x1102));
    if (decay == "ADMIN") {
        return {unit, *weight_kg * grams_per_kg / *dose_bq, ""};
    }
    if (decay != "START") {
        return without(unit, fmt::format("decay correction (0054,1102) is '{}', must be START or "
                                         "ADMIN",
                                         shown(decay)));
    }
    const auto half_life_s = positive(*tracer, gdcm::Tag(0x0018, 0x1075));
    const auto scan_s = moment_s(data, gdcm::Tag(0x0008, 0x0021), gdcm::Tag(0x0008, 0x0031));
    const auto acquired_s = moment_s(data, gdcm::Tag(0x0008, 0x0022), gdcm::Tag(0x0008, 0x0032));
    if (!half_life_s || !scan_s || !acquired_s) {
        return without(unit,
                       "half-life (0018,1075), time of the series or of the acquisition is "
                       "not stated");
    }
    if (*scan_s > *acquired_s) {
        return without(unit,
                       "the series is later than its acquisition: it was processed, and "
                       "does not state to which time its values are corrected");
    }
    const auto given_s = injection_s(data, *tracer, *scan_s);
    if (!given_s || *given_s > *scan_s) {
        return without(unit,
                       "the time of the injection (0018,1078 or 1072) is not stated, or is "
                       "after the scan");
    }
    const double left_bq = *dose_bq * std::exp2(-(*scan_s - *given_s) / *half_life_s);
    const double factor = *weight_kg * grams_per_kg / left_bq;
    return std::isfinite(factor) ? DicomUptake{unit, factor, ""}
                                 : without(unit, "nothing is left of the dose at the scan");
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
