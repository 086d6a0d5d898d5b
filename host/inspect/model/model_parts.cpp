#include "host/inspect/model/model_parts.hpp"

#include <fmt/format.h>

#include <array>

#include "host/inspect/record/message_text.hpp"
#include "host/machine/timing_section.hpp"
#include "host/timing/counts/machine.hpp"

namespace pxpl5::host::inspect {

namespace {

using timing::Unit;

constexpr std::array units = {Unit::host, Unit::host_link, Unit::gp,
                              Unit::ring, Unit::renderer,  Unit::frame_buffer};
constexpr double percent = 100;

std::string_view word_of(timing::Sharing share) {
    return share_words[static_cast<std::size_t>(share)];
}

std::string_view word_of(timing::Assignment assignment) {
    return assignment_words[static_cast<std::size_t>(assignment)];
}

}  // namespace

std::string picture_text(std::string_view word, std::uint32_t first, std::uint32_t samples) {
    return samples == 1
               ? fmt::format("{} {}", word, first)
               : fmt::format("{}s {}..{}, {} samples", word, first, first + samples - 1, samples);
}

void add_use_headings(TableRow& heading) {
    heading.emplace_back("limit");
    for (const Unit unit : units) {
        heading.push_back(fmt::format("{} %", timing::name_of(unit)));
    }
}

void add_use(TableRow& row, Unit limit, const std::vector<timing::UnitUse>& use) {
    row.emplace_back(timing::name_of(limit));
    for (const timing::UnitUse& one : use) {
        row.push_back(fmt::format("{:.1f}", percent * one.busiest));
    }
}

std::vector<Fields> use_fields(const std::vector<timing::UnitUse>& use) {
    std::vector<Fields> rows;
    for (const timing::UnitUse& one : use) {
        rows.push_back({{"unit", std::string(timing::name_of(one.unit))},
                        {"mean", one.mean},
                        {"busiest", one.busiest},
                        {"index", std::int64_t{one.index}}});
    }
    return rows;
}

std::string machine_text(const Topology& plan) {
    const timing::Machine m = timing::machine_of(plan);
    return fmt::format("{}: {} at {} MHz, {} at {} MHz, {}, {} of {} MB/s; share {}, assignment {}",
                       plan.name, counted(m.gps, "GP"), m.gp_clock_mhz,
                       counted(m.renderers, "Renderer"), m.renderer_clock_mhz,
                       counted(m.frame_buffers, "frame buffer"),
                       counted(static_cast<std::uint64_t>(m.ring_channels), "channel"),
                       m.ring_channel_mb_s, word_of(m.share), word_of(m.assignment));
}

Fields machine_fields(const Topology& plan) {
    const timing::Machine machine = timing::machine_of(plan);
    Fields fields{{"topology", plan.name},
                  {"text", machine_text(plan)},
                  {"gp.count", std::int64_t{machine.gps}},
                  {"renderer.count", std::int64_t{machine.renderers}},
                  {"frame_buffer.count", std::int64_t{machine.frame_buffers}},
                  {"share", std::string(word_of(machine.share))},
                  {"assignment", std::string(word_of(machine.assignment))}};
    for (const timing::Parameter& parameter : timing::parameters()) {
        fields.push_back({std::string(parameter.name), machine.*parameter.value});
    }
    return fields;
}

std::string missing_text(const std::vector<std::string>& missing) {
    std::string text;
    for (const std::string& sentence : missing) {
        text += "Not counted: " + sentence + "\n";
    }
    return text;
}

std::vector<Fields> missing_fields(const std::vector<std::string>& missing) {
    std::vector<Fields> rows;
    for (const std::string& sentence : missing) {
        rows.push_back({{"text", sentence}});
    }
    return rows;
}

}  // namespace pxpl5::host::inspect
