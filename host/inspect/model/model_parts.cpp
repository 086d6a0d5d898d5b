#include "host/inspect/model/model_parts.hpp"

#include <fmt/format.h>

#include <array>

#include "host/machine/timing_section.hpp"
#include "host/timing/counts/machine.hpp"

namespace pxpl5::host::inspect {

namespace {

using timing::Unit;

constexpr std::array units = {Unit::host, Unit::host_link, Unit::gp,
                              Unit::ring, Unit::renderer,  Unit::frame_buffer};

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

void add_use_columns(Table& table) {
    table.columns.push_back({"limit", "limit"});
    for (const Unit unit : units) {
        table.columns.push_back({"", fmt::format("{} %", timing::name_of(unit))});
    }
    table.columns.push_back({"use", ""});
}

void add_use(std::vector<Cell>& row, Unit limit, const std::vector<timing::UnitUse>& use) {
    row.emplace_back(timing::name_of(limit));
    for (const timing::UnitUse& one : use) {
        row.push_back(fixed_cell(100 * one.busiest, 1));
    }
    row.emplace_back(use_fields(use));
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

Answer machine_answer(const Topology& plan, const std::vector<std::string>& missing) {
    const timing::Machine m = timing::machine_of(plan);
    const std::string text = fmt::format(
        "{}: {} at {} MHz, {} at {} MHz, {}, {} of {} MB/s; share {}, assignment {}", plan.name,
        counted(m.gps, "GP"), m.gp_clock_mhz, counted(m.renderers, "Renderer"),
        m.renderer_clock_mhz, counted(m.frame_buffers, "frame buffer"),
        counted(static_cast<std::uint64_t>(m.ring_channels), "channel"), m.ring_channel_mb_s,
        word_of(m.share), word_of(m.assignment));
    Answer machine;
    machine.line("machine: " + text)
        .data("topology", plan.name)
        .data("text", text)
        .data("gp.count", m.gps)
        .data("renderer.count", m.renderers)
        .data("frame_buffer.count", m.frame_buffers)
        .data("share", word_of(m.share))
        .data("assignment", word_of(m.assignment));
    for (const timing::Parameter& parameter : timing::parameters()) {
        machine.data(std::string(parameter.name), m.*parameter.value);
    }
    return Answer()
        .object("machine", std::move(machine))
        .sentences("missing", "text", "Not counted: ", missing)
        .line("%: share of the time during which the busiest unit of its kind was busy");
}

}  // namespace pxpl5::host::inspect
