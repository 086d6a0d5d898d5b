// pxpl5 trace shrink.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/diff/shrink.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/replaying_tools.hpp"
#include "isa/assemble.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;

/// A program to shrink, and what it shows.
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
        refuse(fmt::format("{} '{}': a number is expected", option, text));
    }
    return value;
}

RegionPixel parse_pixel(const std::string& text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos) {
        refuse(fmt::format("--pixel '{}' is not of the form X,Y", text));
    }
    constexpr std::uint64_t most = 1 << 20;
    const std::uint64_t x = number(std::string_view(text).substr(0, comma), "--pixel"),
                        y = number(std::string_view(text).substr(comma + 1), "--pixel");
    if (x > most || y > most) {
        refuse(fmt::format("--pixel '{}' is in no picture", text));
    }
    return {static_cast<int>(x), static_cast<int>(y)};
}

FieldValue64 parse_field(const std::string& text) {
    using namespace isa::region;
    const std::pair<const char*, isa::region::Field> fields[] = {
        {"surface", surface},   {"z", z},    {"normal_x", normal_x}, {"normal_y", normal_y},
        {"normal_z", normal_z}, {"rgb", rgb}};
    for (const auto& [name, field] : fields) {
        if (text == name) {
            return {field.address, field.width, 0};
        }
    }
    const std::size_t colon = text.find(':');
    if (!text.starts_with("m") || colon == std::string::npos) {
        refuse(
            fmt::format("--field '{}' is neither surface, z, normal_x, normal_y, normal_z, rgb "
                        "nor of the form m8:24",
                        text));
    }
    const std::uint64_t a = number(std::string_view(text).substr(1, colon - 1), "--field"),
                        n = number(std::string_view(text).substr(colon + 1), "--field");
    if (n < 1 || n > 64 || a >= isa::memory_bits || a + n > isa::memory_bits) {
        refuse(fmt::format("--field '{}' is not 1..64 of the {} bits of a pixel", text,
                           isa::memory_bits));
    }
    return {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(n), 0};
}

std::vector<std::uint32_t> read_program(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    if (!file) {
        refuse(path + ": cannot be read");
    }
    try {
        const std::vector<std::uint32_t> words = isa::assemble(text.str()).bind({});
        const isa::CheckResult checked = isa::check(words);
        if (!checked.ok()) {
            throw RequestError(
                ExitCode::bad_data,
                fmt::format("{}: word {}: {}", path, checked.error->word, checked.error->text));
        }
        return words;
    } catch (const isa::AssemblyError& error) {
        throw RequestError(ExitCode::bad_data, path + ": " + error.what());
    } catch (const isa::ParameterError& error) {
        throw RequestError(ExitCode::bad_data, path + ": " + error.what());
    }
}

/// Asked for: the pixel's field has the value that was given, or else that it has in the end.
Shows asked(const ShrinkTool& tool, RegionPixel pixel, std::span<const std::uint32_t> words,
            const NamedExecutor& trusted, std::string& title) {
    FieldValue64 field = parse_field(tool.field);
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
    task.words = read_program(tool.input);
    task.story.from = "from " + fs::path(tool.input).filename().string();
    if (!tool.pixel.empty()) {
        task.story.pixel = parse_pixel(tool.pixel);
        if (task.story.pixel.x >= isa::region::size_px ||
            task.story.pixel.y >= isa::region::size_px) {
            refuse(fmt::format("--pixel {}: a program has the pixels 0..{} of a region", tool.pixel,
                               isa::region::size_px - 1));
        }
        task.shows = asked(tool, task.story.pixel, task.words, options.trusted, task.story.title);
        return task;
    }
    const renderer::RegionPlan plan = plan_of_program(task.words);
    const auto divergence = first_divergence(plan, options.trusted.make, options.other.make);
    if (!divergence) {
        throw RequestError(ExitCode::failed, fmt::format("{}: {} and {} leave the same", tool.input,
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
            throw RequestError(
                ExitCode::bad_data,
                fmt::format("frame {}: region {} was not recorded whole", number, place.number));
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
    const RecordedRun run = open_run(tool.input);
    if (!tool.pixel.empty()) {
        return task_of_pixel(tool, run, options);
    }
    const DiffReport report = diff_executors(run, options);
    if (!report.difference) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{} and {} leave the same in {} regions; --pixel X,Y shrinks "
                        "to what makes one pixel",
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
        refuse(fmt::format("--executors {}: two are compared, {} are given", tool.executors,
                           kinds.size()));
    }
    DiffOptions options;
    options.selection = parse_selection(tool.selection);
    options.trusted = named(kinds[0]);
    options.other = named(kinds[1]);
    const bool is_program =
        fs::is_regular_file(tool.input) && fs::path(tool.input).extension() != ".mcap";
    const Task task = is_program ? task_of_program(tool, options) : task_of_run(tool, options);
    const Shrunk shrunk = shrink(task.words, task.shows);
    if (!isa::check(shrunk.words).ok() || !task.shows(shrunk.words)) {
        throw std::logic_error("the shrunk program does not show what it should");
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
