#include "host/machine/timing_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

namespace pxpl5::host {

namespace {

constexpr std::array rows = {
#define PXPL5_TIMING(field, name, unit, least, most, whole) \
    TimingRow{name, unit, least, most, whole, false},
#define PXPL5_TIMING_RING(field, name, unit, least, most) \
    TimingRow{name, unit, least, most, true, true},
#include "host/machine/timing_parameters.def"
};

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

template <typename Named>
const Named* named(std::span<const Named> all, std::string_view name) {
    const auto found =
        std::find_if(all.begin(), all.end(), [name](const Named& n) { return n.name == name; });
    return found == all.end() ? nullptr : &*found;
}

const TimingRow* row_of(std::string_view name) {
    return named(timing_rows(), name);
}

const TimingChoice* choice_of(std::string_view name) {
    return named(std::span<const TimingChoice>(timing_choices), name);
}

void check_choice(const TimingValue& entry, const TimingChoice& choice, const std::string& where) {
    if (std::find(choice.words.begin(), choice.words.end(), entry.word) == choice.words.end()) {
        refuse(fmt::format("{}: {} is '{}', must be {} or {}", where, entry.name, entry.word,
                           fmt::join(choice.words.first(choice.words.size() - 1), ", "),
                           choice.words.back()));
    }
    if (entry.value || !entry.unit.empty()) {
        refuse(fmt::format("{}: {} is a word, without value and unit", where, entry.name));
    }
}

void check_number(const TimingValue& entry, const TimingRow& row, const std::string& where) {
    if (entry.unit != row.unit) {
        refuse(fmt::format("{}: {} is in '{}', must be in {}", where, entry.name, entry.unit,
                           row.unit));
    }
    if (row.of_ring && entry.value) {
        refuse(fmt::format("{}: {} is {} in section timing; its value belongs to section ring",
                           where, entry.name, *entry.value));
    }
    if (row.of_ring) {
        return;
    }
    if (!entry.value || !entry.word.empty()) {
        refuse(fmt::format("{}: {} has no value, must be a number of {}", where, entry.name,
                           row.unit));
    }
    const double value = *entry.value;
    const bool fits = value >= row.least && value <= row.most;  // False for NaN.
    if (!fits || (row.whole && value != std::floor(value))) {
        refuse(fmt::format("{}: {} is {}, must be {}{}..{} {}", where, entry.name, value,
                           row.whole ? "a whole number, " : "", row.least, row.most, row.unit));
    }
}

void check_present(const std::vector<TimingValue>& timing, std::string_view name,
                   const std::string& where) {
    const auto times =
        std::count_if(timing.begin(), timing.end(),
                      [name](const TimingValue& entry) { return entry.name == name; });
    if (times == 0) {
        refuse(fmt::format("{}: section timing has no {}", where, name));
    }
    if (times > 1) {
        refuse(fmt::format("{}: section timing has {} {} times", where, name, times));
    }
}

}  // namespace

std::span<const TimingRow> timing_rows() {
    return rows;
}

std::vector<std::string_view> timing_names() {
    std::vector<std::string_view> names;
    for (const TimingRow& row : rows) {
        names.push_back(row.name);
    }
    for (const TimingChoice& choice : timing_choices) {
        names.push_back(choice.name);
    }
    return names;
}

const TimingValue* find_timing(const std::vector<TimingValue>& timing, std::string_view name) {
    return named(std::span<const TimingValue>(timing), name);
}

void check_timing(const std::vector<TimingValue>& timing, const std::string& where) {
    for (const TimingValue& entry : timing) {
        if (const TimingRow* row = row_of(entry.name); row != nullptr) {
            check_number(entry, *row, where);
        } else if (const TimingChoice* choice = choice_of(entry.name); choice != nullptr) {
            check_choice(entry, *choice, where);
        } else {
            refuse(fmt::format("{}: section timing has an unknown parameter '{}'{}", where,
                               entry.name, did_you_mean(entry.name, timing_names())));
        }
    }
    for (const std::string_view name : timing_names()) {
        check_present(timing, name, where);
    }
}

bool override_timing(std::vector<TimingValue>& timing, std::string_view name,
                     std::string_view text) {
    const auto entry =
        std::find_if(timing.begin(), timing.end(),
                     [name](const TimingValue& candidate) { return candidate.name == name; });
    const TimingRow* row = row_of(name);
    if (entry == timing.end() || (row != nullptr && row->of_ring)) {
        return false;
    }
    if (row == nullptr) {
        entry->word = text;
    } else {
        double value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || end != text.data() + text.size()) {
            refuse(fmt::format("{} is '{}', must be a number of {}", name, text, row->unit));
        }
        entry->value = value;
    }
    mark_overridden(timing, name);
    return true;
}

void mark_overridden(std::vector<TimingValue>& timing, std::string_view name) {
    for (TimingValue& entry : timing) {
        if (entry.name == name) {
            entry.provenance = Provenance::ours;
            entry.note = "set for this machine";
        }
    }
}

}  // namespace pxpl5::host
