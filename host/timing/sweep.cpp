#include "host/timing/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "host/base/error.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host::timing {

namespace {

[[noreturn]] void refuse_sweep(std::string_view text, const std::string& why) {
    throw RequestError(ExitCode::usage, fmt::format("--sweep {}: {}", text, why));
}

std::optional<std::int64_t> whole_number(std::string_view text) {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(number)
                                                                    : std::nullopt;
}

/// "1..64" or "1..64*2".
std::vector<std::string> range_of(std::string_view whole, std::string_view text) {
    const std::size_t dots = text.find(".."), star = text.find('*');
    const auto first = whole_number(text.substr(0, dots));
    const auto last = whole_number(text.substr(dots + 2, star - dots - 2));
    const auto factor = star == std::string_view::npos ? std::optional<std::int64_t>(1)
                                                       : whole_number(text.substr(star + 1));
    if (!first || !last || !factor) {
        refuse_sweep(
            whole,
            fmt::format("'{}' must be FIRST..LAST or FIRST..LAST*FACTOR, whole numbers", text));
    }
    if (*first > *last) {
        refuse_sweep(whole, fmt::format("{} is greater than {}", *first, *last));
    }
    if (star != std::string_view::npos && (*factor < 2 || *first < 1)) {
        refuse_sweep(whole,
                     fmt::format("a factor must be 2 or more, and begin at 1 or more; they are {} "
                                 "and {}",
                                 *factor, *first));
    }
    std::vector<std::string> values;
    for (std::int64_t n = *first;;) {
        values.push_back(fmt::format("{}", n));
        if (*factor > 1 ? n > *last / *factor : n == *last) {
            break;
        }
        n = *factor > 1 ? n * *factor : n + 1;
        if (values.size() == max_swept_machines) {
            refuse_sweep(whole, fmt::format("more than {} values", max_swept_machines));
        }
    }
    return values;
}

std::vector<std::string> list_of(std::string_view whole, std::string_view text) {
    std::vector<std::string> values;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t comma = std::min(text.find(',', at), text.size());
        values.emplace_back(text.substr(at, comma - at));
        if (values.back().empty()) {
            refuse_sweep(whole, "there is an empty value");
        }
        at = comma + 1;
    }
    return values;
}

/// How many machines the keys make.
std::size_t machine_count(std::span<const SweptKey> keys) {
    std::size_t machines = 1;
    for (const SweptKey& key : keys) {
        machines *= key.values.size();
    }
    if (keys.empty() || keys.size() > max_swept_keys || machines > max_swept_machines) {
        refuse_sweep(keys.empty() ? "" : keys.front().key,
                     fmt::format("{} keys and {} machines; at most {} and {}", keys.size(),
                                 machines, max_swept_keys, max_swept_machines));
    }
    if (keys.size() > 1 && keys[0].key == keys[1].key) {
        refuse_sweep(keys[0].key, "the key is there twice; list all its values once");
    }
    return machines;
}

SweptMachine time_on(const Machine& machine, const RunWork& setting, const Picture& picture) {
    SweptMachine result;
    Ns longest = -1;
    for (const StepTime& time : simulate(machine, setting).steps) {
        const Ns took = time.end - time.begin;
        if (std::holds_alternative<VolumeWork>(setting.steps[time.step])) {
            result.load = result.load.value_or(0) + took;
        } else {
            result.build = result.build.value_or(0) + took;
            result.build_limit = took > longest ? time.limit : result.build_limit;
            longest = std::max(longest, took);
        }
    }
    result.rate = picture_rate(machine, picture);
    return result;
}

}  // namespace

SweptKey parse_sweep(std::string_view text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0) {
        refuse_sweep(text, "must be KEY=VALUES, as gp.count=1..64 or ring.channel_mb_s=40,80,160");
    }
    const std::string_view values = text.substr(equals + 1);
    return {std::string(text.substr(0, equals)), values.find("..") == std::string_view::npos
                                                     ? list_of(text, values)
                                                     : range_of(text, values)};
}

RunWork setting_of(const RunWork& run, std::size_t frame_step) {
    RunWork setting;
    std::map<std::uint16_t, std::size_t> newest;  ///< Step of each surface's revision.
    std::optional<std::size_t> volume;
    for (std::size_t step = 0; step < frame_step; ++step) {
        if (std::holds_alternative<VolumeWork>(run.steps[step])) {
            volume = step;
            newest.clear();
        } else if (const auto* build = std::get_if<BuildWork>(&run.steps[step])) {
            newest[build->surface] = step;
        }
    }
    std::vector<std::size_t> steps;
    if (volume) {
        steps.push_back(*volume);
    }
    for (const auto& [surface, step] : newest) {
        steps.push_back(step);
    }
    std::ranges::sort(steps);
    for (const std::size_t step : steps) {
        setting.steps.push_back(run.steps[step]);
    }
    return setting;
}

std::vector<TriedMachine> machines_of(const Topology& plan, std::span<const SweptKey> keys) {
    const std::size_t count = machine_count(keys);
    std::vector<TriedMachine> machines;
    for (std::size_t n = 0; n < count; ++n) {
        TriedMachine& one = machines.emplace_back();
        std::size_t rest = n;
        for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
            one.values.insert(one.values.begin(), key->values[rest % key->values.size()]);
            rest /= key->values.size();
        }
        Topology topology = plan;
        for (std::size_t k = 0; k < keys.size(); ++k) {
            apply_modelled_override(topology, keys[k].key + "=" + one.values[k]);
        }
        one.machine = machine_of(topology);
    }
    return machines;
}

std::vector<SweptMachine> sweep(const Topology& plan, std::span<const SweptKey> keys,
                                const RunWork& run, std::size_t frame_step) {
    const std::vector<TriedMachine> machines = machines_of(plan, keys);
    const std::optional<Picture> picture = picture_at(run, frame_step);
    if (!picture) {
        refuse_sweep("", fmt::format("step {} is no frame of a whole picture", frame_step));
    }
    const RunWork setting = setting_of(run, frame_step);
    std::vector<SweptMachine> results;
    for (const TriedMachine& one : machines) {
        results.push_back(time_on(one.machine, setting, *picture));
        results.back().values = one.values;
    }
    return results;
}

}  // namespace pxpl5::host::timing
