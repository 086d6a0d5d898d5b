// Reads what tells DICOM slices of one place apart.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include "host/io/dicom/dicom_frame_groups.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

const gdcm::Tag frame_content(0x0020, 0x9111), heart_beat(0x0018, 0x9118), echo(0x0018, 0x9114),
    diffusion(0x0018, 0x9117), gradient(0x0018, 0x9076);

std::optional<double> finite(std::optional<double> value) {
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// A text that is one number.
std::optional<double> number_in(const std::string& text) {
    const std::string all = trimmed(text), word = all.starts_with('+') ? all.substr(1) : all;
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool is_whole = error == std::errc() && end == word.data() + word.size();
    return is_whole ? finite(value) : std::nullopt;
}

/// Milliseconds after midnight of a time of day, "142359.25" or, of old files, "14:23:59.25".
std::optional<double> time_of_day_ms(std::string text) {
    std::erase(text, ':');
    constexpr std::size_t digits = 6;
    if (text.size() < digits) {
        return std::nullopt;
    }
    const auto hours = number_in(text.substr(0, 2)), minutes = number_in(text.substr(2, 2)),
               seconds = number_in(text.substr(4));
    const bool is_time = hours && minutes && seconds && *hours >= 0 && *hours < 24 &&
                         *minutes >= 0 && *minutes < 60 && *seconds >= 0 && *seconds <= 60;
    if (!is_time) {
        return std::nullopt;
    }
    return ((*hours * 60 + *minutes) * 60 + *seconds) * 1000;
}

constexpr std::size_t date_digits = 8;

/// Milliseconds from 1970 to the begin of a day "20261128" or, of old files, "2026.11.28"; 0 if
/// there is none.
double day_ms(std::string text) {
    std::erase(text, '.');
    const auto year = number_in(text.substr(0, 4)),
               month = number_in(text.size() == date_digits ? text.substr(4, 2) : ""),
               day = number_in(text.size() == date_digits ? text.substr(6, 2) : "");
    if (!year || !month || !day || *year < 0) {
        return 0;
    }
    const std::chrono::year_month_day date{
        std::chrono::year(static_cast<int>(*year)),
        std::chrono::month(static_cast<unsigned>(std::max(*month, 0.0))),
        std::chrono::day(static_cast<unsigned>(std::max(*day, 0.0)))};
    return date.ok() ? static_cast<double>(
                           std::chrono::milliseconds(std::chrono::sys_days(date).time_since_epoch())
                               .count())
                     : 0;
}

/// The time of a date and a time "20261128142359.25+0100". All slices of a series have one time
/// zone, which is left out.
std::optional<double> date_time_ms(const std::string& text) {
    if (text.size() <= date_digits) {
        return std::nullopt;
    }
    const std::size_t zone = text.find_first_of("+-", date_digits);
    const auto time = time_of_day_ms(text.substr(date_digits, zone - date_digits));
    return time ? std::optional(day_ms(text.substr(0, date_digits)) + *time) : std::nullopt;
}

std::optional<double> acquisition_ms(const gdcm::DataSet& data, const FrameGroups& groups) {
    for (const std::string& text : {groups.text(frame_content, gdcm::Tag(0x0018, 0x9074)),
                                    text_of(data, gdcm::Tag(0x0008, 0x002a))}) {
        if (const auto found = date_time_ms(text)) {
            return found;
        }
    }
    const auto time = time_of_day_ms(text_of(data, gdcm::Tag(0x0008, 0x0032)));
    return time ? std::optional(day_ms(text_of(data, gdcm::Tag(0x0008, 0x0022))) + *time)
                : std::nullopt;
}

/// A number that is text in a file of one slice, and binary in a group of a frame.
template <typename T>
std::optional<double> number_of(const gdcm::DataSet& data, gdcm::Tag text,
                                const FrameGroups& groups, gdcm::Tag macro, gdcm::Tag binary) {
    const std::optional<T> found = groups.binary<T>(macro, binary);
    return found ? finite(static_cast<double>(*found)) : number_in(text_of(data, text));
}

/// Elements beside time in which slices of one place may differ, as one text.
std::string kind_of(const gdcm::DataSet& data, const FrameGroups& groups) {
    const auto echo_ms =
        number_of<double>(data, gdcm::Tag(0x0018, 0x0081), groups, echo, gdcm::Tag(0x0018, 0x9082));
    const auto weight = groups.binary<double>(diffusion, gdcm::Tag(0x0018, 0x9087));
    const std::string direction = groups.bytes(gradient, gdcm::Tag(0x0018, 0x9089));
    std::string kind =
        fmt::format("{}, {}, {}", echo_ms.value_or(0), weight.value_or(0), direction);
    for (const gdcm::Tag& tag :
         {gdcm::Tag(0x0008, 0x0008), gdcm::Tag(0x0018, 0x0024), gdcm::Tag(0x0018, 0x0082)}) {
        kind += ", " + text_of(data, tag);
    }
    for (const gdcm::Tag& macro : {gdcm::Tag(0x0018, 0x9226), gdcm::Tag(0x0018, 0x9329)}) {
        kind += ", " + groups.text(macro, gdcm::Tag(0x0008, 0x9007));
    }
    return kind;
}

}  // namespace

DicomTimes read_times(const gdcm::DataSet& data, const FrameGroups& groups) {
    DicomTimes times;
    times.position = number_of<std::uint32_t>(data, gdcm::Tag(0x0020, 0x0100), groups,
                                              frame_content, gdcm::Tag(0x0020, 0x9128));
    times.trigger_ms = number_of<double>(data, gdcm::Tag(0x0018, 0x1060), groups, heart_beat,
                                         gdcm::Tag(0x0020, 0x9153));
    times.acquisition_ms = acquisition_ms(data, groups);
    times.acquisition = number_of<std::uint16_t>(data, gdcm::Tag(0x0020, 0x0012), groups,
                                                 frame_content, gdcm::Tag(0x0020, 0x9156));
    times.kind = kind_of(data, groups);
    return times;
}

}  // namespace pxpl5::host::io
