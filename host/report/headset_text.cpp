#include "host/report/headset_text.hpp"

#include <fmt/format.h>

#include "host/base/text_table.hpp"

namespace pxpl5::host::report {

namespace {

std::string number_text(double value, std::string_view unit) {
    return fmt::format("{:g} {}", value, unit);
}

}  // namespace

std::string text_of(const std::vector<HeadsetLine>& lines, const timing::Headset& headset) {
    std::vector<TableRow> rows;
    for (const auto& [name, time] : lines) {
        rows.push_back({name, fmt::format("{:.1f}", time.rate.frames_per_s),
                        std::string(timing::name_of(time.rate.limit)),
                        fmt::format("{:.0f}", time.drawn_ms),
                        fmt::format("{:.0f} to {:.0f}", time.least_ms, time.most_ms)});
    }
    std::string text = fmt::format(
        "\nIn stereo, for a head-mounted display: {:g} x {:g} pixels for each eye\n{}"
        "frames/s: pairs of pictures, modelled. GPs transform for both eyes, and extract once\n"
        "drawn: from the command to the last pixel of both eyes, while frames_in_flight pairs are "
        "drawn\n"
        "latency: the tracker's {:g} to {:g} ms, drawn, {:.1f} ms for the field on average, and "
        "{:.1f} ms of scan-out; the paper states none\n",
        headset.eye_width, headset.eye_height,
        text_table({"", "frames/s", "limit", "drawn, ms", "latency, ms"}, rows),
        headset.tracker_least_ms, headset.tracker_most_ms, headset.wait_ms(),
        headset.scan_out_ms());
    std::vector<TableRow> parameters;
    for (const timing::HeadsetRow& row : timing::headset_rows()) {
        parameters.push_back({std::string(row.name), number_text(headset.*row.value, row.unit),
                              std::string(enum_name(row.provenance)), std::string(row.source)});
    }
    constexpr std::size_t all_left = 4;
    return text + text_table({"of the display", "", "", ""}, parameters, all_left);
}

void add_fields(const timing::HeadsetTime& time, Fields& fields) {
    fields.push_back({"stereo_frames_per_s", time.rate.frames_per_s});
    fields.push_back({"stereo_limit", std::string(timing::name_of(time.rate.limit))});
    fields.push_back({"stereo_drawn_ms", time.drawn_ms});
    fields.push_back({"stereo_latency_least_ms", time.least_ms});
    fields.push_back({"stereo_latency_most_ms", time.most_ms});
}

std::vector<Fields> fields_of(const timing::Headset& headset) {
    std::vector<Fields> list;
    for (const timing::HeadsetRow& row : timing::headset_rows()) {
        list.push_back({{"name", std::string(row.name)},
                        {"unit", std::string(row.unit)},
                        {"value", headset.*row.value},
                        {"provenance", std::string(enum_name(row.provenance))},
                        {"source", std::string(row.source)}});
    }
    return list;
}

}  // namespace pxpl5::host::report
