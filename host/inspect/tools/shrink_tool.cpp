// pxpl5 trace shrink.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/diff/shrink.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/exec_fields.hpp"
#include "host/inspect/tools/program_files.hpp"
#include "host/inspect/tools/tools.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;

/// A program to shrink, and the behavior to keep.
struct Task {
    std::vector<std::uint32_t> words;
    ShrunkStory story;
    Shows shows;
};

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

/// All of `text` as a number, decimal or 0x hexadecimal.
std::uint64_t number(std::string_view text, std::string_view option) {
    const bool hexadecimal = text.starts_with("0x");
    const std::string_view digits = hexadecimal ? text.substr(2) : text;
    std::uint64_t value = 0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, hexadecimal ? 16 : 10);
    if (error != std::errc{} || end != digits.data() + digits.size() || digits.empty()) {
        refuse(fmt::format("{} '{}' is not a number", option, text));
    }
    return value;
}

RegionPixel parse_pixel(const std::string& text) {
    const auto [x, y] = parse_pair("--pixel", text);
    return {x, y};
}

/// A field of pixel memory. Throws RequestError (usage) for any other state of a pixel.
FieldValue64 memory_field(const std::string& text) {
    const isa::StateColumn column = parse_field(text).column;
    if (column.kind != isa::StateColumn::Kind::field) {
        refuse(
            fmt::format("--field '{}': only fields of pixel memory are supported, for example "
                        "rgb or m8:24",
                        text));
    }
    return {column.a, column.n, 0};
}

/// True if the field of the pixel has the value of --is, or else the value that it has at the end.
Shows asked(const ShrinkTool& tool, RegionPixel pixel, std::span<const std::uint32_t> words,
            const NamedExecutor& trusted, std::string& title) {
    FieldValue64 field = memory_field(tool.field);
    if (tool.is.empty()) {
        const auto executor = trusted.make();
        run_region(plan_of_program(words), *executor);
        field.value = executor->field(pixel.x, pixel.y, field.a, field.n);
    } else {
        field.value = number(tool.is, "--is");
    }
    title = fmt::format("{} of pixel {}, {} is 0x{:x}", tool.field, pixel.x, pixel.y, field.value);
    return holds_at(pixel, field, trusted);
}

/// Executors that leave a pixel differently.
Task differing(const renderer::RegionPlan& plan, const Divergence& divergence,
               const DiffOptions& options, const std::string& from) {
    Task task;
    task.story.pixel = {divergence.bit.x, divergence.bit.y};
    task.story.from = from;
    task.story.title =
        fmt::format("{} and {} leave the same", options.trusted.name, options.other.name);
    task.words = whole_program(plan, &divergence);
    task.shows = differ_at(task.story.pixel, options.trusted, options.other);
    return task;
}

Task task_of_program(const ShrinkTool& tool, const DiffOptions& options) {
    Task task;
    task.words = assemble_file(tool.run, read_file(tool.run), {});
    task.story.from = "from " + fs::path(tool.run).filename().string();
    if (!tool.pixel.empty()) {
        task.story.pixel = parse_pixel(tool.pixel);
        if (task.story.pixel.x >= region_px || task.story.pixel.y >= region_px) {
            refuse(fmt::format("--pixel {}: a program has the pixels 0..{} of a region", tool.pixel,
                               region_px - 1));
        }
        task.shows = asked(tool, task.story.pixel, task.words, options.trusted, task.story.title);
        return task;
    }
    const renderer::RegionPlan plan = plan_of_program(task.words);
    const auto divergence = first_divergence(plan, options.trusted.make, options.other.make);
    if (!divergence) {
        throw RequestError(ExitCode::failed,
                           fmt::format("{}: {} and {} leave the same state", tool.run,
                                       options.trusted.name, options.other.name));
    }
    return differing(plan, *divergence, options, task.story.from);
}

Task task_of_pixel(const ShrinkTool& tool, const RecordedRun& run, const DiffOptions& options) {
    for (const std::uint32_t number : run.frames()) {
        if (!options.selection.has_frame(number)) {
            continue;
        }
        const RecordedFrame frame = run.frame(number);
        const RegionPixel asked_for = parse_pixel(tool.pixel);
        const RegionPlace place = frame.region_at(asked_for.x, asked_for.y);
        const auto region = frame.regions.find(place.number);
        if (region == frame.regions.end()) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("frame {}: region {} was not recorded completely",
                                           number, place.number));
        }
        Task task;
        task.words = whole_program(region->second.plan);
        task.story.pixel = {asked_for.x - place.x0_px, asked_for.y - place.y0_px};
        task.story.from = fmt::format("from frame {}, region {}", number, place.number);
        task.shows = asked(tool, task.story.pixel, task.words, options.trusted, task.story.title);
        return task;
    }
    throw RequestError(ExitCode::bad_data, "no selected frame is in this run");
}

Task task_of_run(const ShrinkTool& tool, const DiffOptions& options) {
    const RecordedRun run = open_run(tool.run);
    if (!tool.pixel.empty()) {
        return task_of_pixel(tool, run, options);
    }
    const DiffReport report = diff_executors(run, options);
    if (!report.difference) {
        throw RequestError(ExitCode::failed,
                           fmt::format("{} and {} leave the same state in {} regions; --pixel X,Y "
                                       "shrinks to the instructions that draw one pixel",
                                       options.trusted.name, options.other.name, report.regions));
    }
    const RecordedFrame frame = run.frame(report.difference->frame);
    const RecordedRegion& region = frame.regions.at(*report.difference->region);
    const auto divergence = first_divergence(region.plan, options.trusted.make, options.other.make);
    return differing(region.plan, *divergence, options,
                     fmt::format("from frame {}, region {}", frame.number, region.place.number));
}

void write(const fs::path& path, const std::string& text) {
    TextOutput out(path.string());
    out.put(text);
    out.finish();
}

}  // namespace

int trace_shrink(const ShrinkTool& tool) {
    const std::vector<ExecutorKind> kinds = parse_executors(tool.executors);
    if (kinds.size() != 2) {
        refuse(fmt::format("--executors {}: give two executors, not {}", tool.executors,
                           kinds.size()));
    }
    DiffOptions options;
    options.selection = parse_selection(tool.selection);
    options.trusted = named(kinds[0]);
    options.other = named(kinds[1]);
    const bool is_program =
        fs::is_regular_file(tool.run) && fs::path(tool.run).extension() != ".mcap";
    const Task task = is_program ? task_of_program(tool, options) : task_of_run(tool, options);
    const Shrunk shrunk = shrink(task.words, task.shows);
    if (!isa::check(shrunk.words).ok() || !task.shows(shrunk.words)) {
        throw std::logic_error("the shrunk program does not reproduce the behavior");
    }
    TextOutput out("");
    if (tool.output.empty()) {
        out.put(as_assembly(shrunk, task.story));
    } else {
        fs::path base = tool.output;
        base.replace_extension();
        write(base.string() + ".pxasm", as_assembly(shrunk, task.story));
        write(base.string() + "_test.cpp", as_doctest(shrunk, task.story));
        write(base.string() + ".pxt", as_conformance(shrunk, task.story));
        out.line(fmt::format(
            "{} instructions of {}, after {} programs; pixel ({}, {}) of the "
            "region: {}.pxasm, {}_test.cpp, {}.pxt",
            shrunk.instructions, shrunk.instructions_before, shrunk.tried, task.story.pixel.x,
            task.story.pixel.y, base.string(), base.string(), base.string()));
    }
    out.finish();
    return 0;
}

}  // namespace pxpl5::host::inspect
