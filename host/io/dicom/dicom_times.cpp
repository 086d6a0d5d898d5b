// Reads what tells DICOM slices of one place apart.
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "host/io/dicom/dicom_frame_groups.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

const gdcm::Tag frame_content(0x0020, 0x9111), heart_beat(0x0018, 0x9118), echo(0x0018, 0x9114),
    diffusion(0x0018, 0x9117);

std::optional<double> finite(std::optional<double> value) {
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// A text that is one number.
std::optional<double> number_in(const std::string& text) {
    const std::string word = trimmed(text);
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

std::optional<double> acquisition_ms(const gdcm::DataSet& data, const FrameGroups& groups) {
    constexpr std::size_t date_digits = 8;
    const std::string frame = groups.text(frame_content, gdcm::Tag(0x0018, 0x9074));
    return frame.size() > date_digits ? time_of_day_ms(frame.substr(date_digits))
                                      : time_of_day_ms(text_of(data, gdcm::Tag(0x0008, 0x0032)));
}

/// A number that is text in a file of one slice, and binary in a group of a frame.
template <typename T>
std::optional<double> number_of(const gdcm::DataSet& data, gdcm::Tag text,
                                const FrameGroups& groups, gdcm::Tag macro, gdcm::Tag binary) {
    const std::optional<T> found = groups.binary<T>(macro, binary);
    return found ? finite(static_cast<double>(*found)) : number_in(text_of(data, text));
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
    const std::optional<double> echo_ms =
        number_of<double>(data, gdcm::Tag(0x0018, 0x0081), groups, echo, gdcm::Tag(0x0018, 0x9082));
    times.kind =
        fmt::format("{}, {}, {}", text_of(data, gdcm::Tag(0x0008, 0x0008)), echo_ms.value_or(0),
                    groups.binary<double>(diffusion, gdcm::Tag(0x0018, 0x9087)).value_or(0));
    return times;
}

}  // namespace pxpl5::host::io
