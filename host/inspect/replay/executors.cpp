#include "host/inspect/replay/executors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "host/base/error.hpp"
#include "host/inspect/replay/scoped_reference.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fast = renderer::fast;

constexpr std::array<std::pair<ExecutorKind, std::string_view>, 5> names = {{
    {ExecutorKind::reference, "reference"},
    {ExecutorKind::fast, "fast"},
    {ExecutorKind::sse4, "sse4"},
    {ExecutorKind::avx2, "avx2"},
    {ExecutorKind::avx512, "avx512"},
}};

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
    const auto found = std::ranges::find(names, text, [](const auto& row) { return row.second; });
    if (found == names.end()) {
        throw RequestError(ExitCode::usage,
                           fmt::format("executor '{}'; it must be reference, fast, sse4, avx2, "
                                       "avx512 or both",
                                       text));
    }
    const ExecutorKind kind = found->first;
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
    return std::ranges::find(names, kind, [](const auto& row) { return row.first; })->second;
}

std::vector<ExecutorKind> parse_executors(std::string_view text) {
    if (text == "both") {
        return {ExecutorKind::reference, ExecutorKind::fast};
    }
    std::vector<ExecutorKind> kinds;
    while (true) {
        const std::size_t comma = text.find(',');
        kinds.push_back(parse_one(text.substr(0, comma)));
        if (comma == std::string_view::npos) {
            return kinds;
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
