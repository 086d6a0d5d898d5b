#include "host/inspect/replay/executors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <ranges>

#include "host/base/error.hpp"
#include "host/inspect/replay/scoped_reference.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fast = renderer::fast;

constexpr std::array kinds = {ExecutorKind::reference, ExecutorKind::fast, ExecutorKind::sse4,
                              ExecutorKind::avx2, ExecutorKind::avx512};

/// The vector target of a kind that is not the reference.
fast::Target target_of(ExecutorKind kind) {
    switch (kind) {
        case ExecutorKind::sse4:
            return fast::Target::sse4;
        case ExecutorKind::avx2:
            return fast::Target::avx2;
        case ExecutorKind::avx512:
            return fast::Target::avx512;
        default:
            return fast::Target::best;
    }
}

ExecutorKind parse_one(std::string_view text) {
    const auto found = std::ranges::find(kinds, text, name_of);
    if (found == kinds.end()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("executor '{}'; it must be {} or both", text,
                                       fmt::join(kinds | std::views::transform(name_of), ", ")));
    }
    const ExecutorKind kind = *found;
    const fast::Target target = target_of(kind);
    const std::vector<fast::Target> there = isa::available_targets();
    if (target != fast::Target::best && std::ranges::find(there, target) == there.end()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("executor '{}': this machine lacks it", text));
    }
    return kind;
}

}  // namespace

std::string_view name_of(ExecutorKind kind) {
    switch (kind) {
        case ExecutorKind::reference:
            return "reference";
        case ExecutorKind::fast:
            return "fast";
        default:
            return enum_name(target_of(kind));
    }
}

std::vector<ExecutorKind> parse_executors(std::string_view text) {
    if (text == "both") {
        return {ExecutorKind::reference, ExecutorKind::fast};
    }
    std::vector<ExecutorKind> chosen;
    while (true) {
        const std::size_t comma = text.find(',');
        chosen.push_back(parse_one(text.substr(0, comma)));
        if (comma == std::string_view::npos) {
            return chosen;
        }
        text.remove_prefix(comma + 1);
    }
}

std::unique_ptr<isa::Executor> make_executor(ExecutorKind kind) {
    if (kind == ExecutorKind::reference) {
        return std::make_unique<ScopedReference>();
    }
    return std::make_unique<fast::Fast>(target_of(kind));
}

RegionRun run_region(const renderer::RegionPlan& plan, isa::Executor& executor) {
    RegionRun run;
    std::vector<std::uint32_t>* read_out = nullptr;
    executor.set_readout([&](std::span<const std::uint32_t> pixels) {
        read_out->insert(read_out->end(), pixels.begin(), pixels.end());
    });
    RegionWalk walk(plan, executor);
    while (!walk.done()) {
        const bool is_depths = plan.parts[walk.at().part].kind == PartKind::depths;
        read_out = is_depths ? &run.depths : &run.pixels;
        walk.run_part();
    }
    run.counts = walk.counts();
    executor.set_readout({});
    return run;
}

void prepare(const RecordedRegion& region, isa::Executor& executor) {
    RegionWalk walk(region.before, executor);
    while (!walk.done()) {
        walk.run_part();
    }
}

RegionRun run_region(const RecordedRegion& region, isa::Executor& executor) {
    prepare(region, executor);
    return run_region(region.plan, executor);
}

}  // namespace pxpl5::host::inspect
