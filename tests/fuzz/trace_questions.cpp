// Each question of `pxpl5 trace`, `why`, `why-not` and `model` on a recorded run whose messages
// were changed: it is answered, or refused with a named error.
#include <fmt/format.h>

#include <array>

#include "host/base/error.hpp"
#include "host/inspect/tools/tools.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/recordings.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace host::inspect;

/// The parameters of a question.
struct Asked {
    std::string run;       ///< The changed run.
    std::string original;  ///< The run before the changes.
    std::string output;    ///< A file.
    int x = 0, y = 0;
    std::uint8_t choice = 0;

    RunOptions options() const { return {run, {}, output, (choice & 1U) != 0}; }
    std::string number() const { return std::to_string(choice / 2 % 32); }
};

int ask_ls(const Asked& asked) {
    return trace_ls(asked.options());
}

int ask_dump(const Asked& asked) {
    DumpOptions options{asked.options()};
    options.lines = 500;
    options.instructions = (asked.choice & 2U) != 0;
    if ((asked.choice & 4U) != 0) {
        options.pixel = {asked.x, asked.y};
    }
    return trace_dump(options);
}

int ask_stats(const Asked& asked) {
    StatsOptions options{asked.options()};
    options.csv = !options.json && (asked.choice & 2U) != 0;
    if ((asked.choice & 4U) != 0) {
        options.selection.slab = {asked.number()};
    }
    return trace_stats(options);
}

int ask_export(const Asked& asked) {
    ExportOptions options{asked.options()};
    options.json = false;
    switch (asked.choice % 4) {
        case 0:
            options.chrome = asked.output + ".json";
            break;
        case 1:
            options.messages = "json";
            break;
        case 2:
            options.messages = "csv";
            break;
        default:
            options.streams = asked.output + "-streams";
    }
    options.events = 2000;
    return trace_export(options);
}

int ask_replay(const Asked& asked) {
    ReplayTool tool{asked.options()};
    tool.threads = 1;
    return trace_replay(tool);
}

int ask_diff(const Asked& asked) {
    DiffTool tool{asked.options()};
    if ((asked.choice & 2U) != 0) {
        tool.other = asked.original;
    } else {
        tool.executors = "sse4,fast";
    }
    return trace_diff(tool);
}

int ask_step(const Asked& asked) {
    constexpr std::array walks = {
        "s 3;where;print z;list;pixel 64 64", "t 2;T;b 4;goto end;b;where",
        "break pixel 64 64;c;c;rc;info",      "break empty;c;goto pixel 60 60;list 5",
        "part;part;part -1;region;show z",    "break op TREE*;c;s -2;print rgb 10 10 8 8",
        "break cell 30,30,20;c;where",        "break z 64 64 < 900000;c;pixel 64 64",
    };
    StepOptions options{asked.options()};
    options.commands = {walks.at(asked.choice / 2 % walks.size())};
    return trace_step(options);
}

int ask_map(const Asked& asked) {
    constexpr std::array maps = {"idle",     "busy",      "covered", "overdraw", "cost",  "gp",
                                 "renderer", "cell_case", "slab",    "depth",    "normal"};
    MapOptions options{asked.options()};
    options.map = maps.at(asked.choice % maps.size());
    options.raw = true;
    return trace_map(options);
}

int ask_why(const Asked& asked) {
    PixelOptions options{asked.options()};
    options.x = asked.x;
    options.y = asked.y;
    return run_why(options);
}

int ask_why_not(const Asked& asked) {
    WhyNotTool tool;
    static_cast<RunOptions&>(tool) = asked.options();
    tool.x = asked.x;
    tool.y = asked.y;
    if ((asked.choice & 2U) != 0) {
        tool.cell = fmt::format("{},{},{}", asked.x / 2, asked.y / 2, asked.number());
        tool.triangle = (asked.choice & 4U) != 0 ? std::optional(asked.choice / 64) : std::nullopt;
    }
    return run_why_not(tool);
}

int ask_model(const Asked& asked) {
    ModelOptions options{asked.options()};
    if ((asked.choice & 2U) != 0) {
        options.sweeps = {"gp.count=1..4"};
    }
    return run_model(options);
}

int ask_shrink(const Asked& asked) {
    ShrinkTool tool{asked.options()};
    tool.executors = "fast,sse4";
    tool.output = {};
    tool.pixel = fmt::format("{},{}", asked.x, asked.y);
    tool.field = "surface";  // Fields that shading computes take seconds.
    return trace_shrink(tool);
}

constexpr std::array questions = {ask_ls,     ask_dump,    ask_stats, ask_export,
                                  ask_replay, ask_diff,    ask_step,  ask_map,
                                  ask_why,    ask_why_not, ask_model, ask_shrink};

struct Runs {
    Runs() {
        for (RecordedFiles& run : files) {
            std::filesystem::copy(run.path(), original_of(run),
                                  std::filesystem::copy_options::recursive);
        }
    }
    static std::string original_of(const RecordedFiles& run) { return run.path() + "-original"; }

    Scratch scratch;
    std::array<RecordedFiles, 2> files{RecordedFiles(scratch.path() / "one", 1),
                                       RecordedFiles(scratch.path() / "four", 4)};
};

}  // namespace

/// Input: the question, its choice, the recording, a pixel; then edits of messages.
bool accepts(Input input) {
    static Runs runs;
    Bytes bytes(input);
    const auto question = questions.at(bytes.take<std::uint8_t>() % questions.size());
    Asked asked;
    asked.choice = bytes.take<std::uint8_t>();
    const std::size_t which = bytes.take<std::uint8_t>() % 8 == 7 ? 1 : 0;
    asked.x = bytes.take<std::uint8_t>();
    asked.y = bytes.take<std::uint8_t>();
    asked.run = runs.files.at(which).path();
    asked.original = Runs::original_of(runs.files.at(which));
    asked.output = runs.scratch.at("answer");
    runs.files.at(which).edit(bytes);
    try {
        const int code = question(asked);
        const bool is_refused_step = question == ask_step && code >= 64;
        require(code == 0 || code == 1 || is_refused_step, fmt::format("exit code {}", code));
        return true;
    } catch (const host::RequestError& error) {
        require(*error.what() != 0, "an error without a text");
        return false;
    }
}

}  // namespace pxpl5::fuzz
