// pxpl5 exec: runs assembly on a pixel array and prints pixels.
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/map/picture_file.hpp"
#include "host/inspect/record/message_text.hpp"
#include "host/inspect/replay/executors.hpp"
#include "host/inspect/tools/exec_fields.hpp"
#include "host/inspect/tools/program_files.hpp"
#include "host/inspect/tools/tools.hpp"
#include "isa/conformance/conformance_run.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::uint32_t whole_word = 64;

/// The program to run.
struct Work {
    std::vector<std::vector<std::uint32_t>> programs;
    std::vector<isa::StateTable> given;
    std::optional<isa::ConformanceCase> test;
};

/// One executor behind the run.
struct Ran {
    ExecutorKind kind{};
    std::unique_ptr<isa::Executor> executor;
    std::vector<std::uint32_t> readout;
    std::vector<std::uint32_t> signals;
    isa::RunCounts counts;
    std::string stopped;  ///< Why it did not reach its end; empty if it did.

    PixelsBehind pixels() const { return {*executor, readout}; }
};

/// A conformance case opens with its title or its given state; no assembly does.
bool is_case(const std::string& text) {
    const std::string with_line = "\n" + text;
    return with_line.find("\nrun") != std::string::npos &&
           (with_line.find("\ngiven") != std::string::npos ||
            with_line.find("\ntitle") != std::string::npos);
}

/// "FIELD[@PIXELS]=VALUE" of --init as a table; the values are those of conformance cases.
isa::StateTable parse_init(const std::string& text) {
    const std::size_t equals = text.find('='), at = text.find('@');
    if (equals == std::string::npos || (at != std::string::npos && at > equals)) {
        throw RequestError(ExitCode::usage,
                           fmt::format("--init '{}'; it must be FIELD=VALUE or FIELD@PIXELS=VALUE, "
                                       "e.g. m0:8=x+2*y or enable@0..63,*=1",
                                       text));
    }
    const ShownField field = parse_field(text.substr(0, std::min(at, equals)));
    const std::string where =
        at == std::string::npos ? "all" : text.substr(at + 1, equals - at - 1);
    using Column = isa::StateColumn::Kind;
    const isa::StateColumn& column = field.column;
    const std::string name =
        column.kind == Column::field ? fmt::format("m{}:{}", column.a, column.n) : field.name;
    try {
        return isa::parse_conformance(fmt::format("title --init\ngiven {}\n  {} {}\nrun\n", name,
                                                  where, text.substr(equals + 1)))
            .given.at(0);
    } catch (const isa::ConformanceError& error) {
        throw RequestError(ExitCode::usage, fmt::format("--init '{}': {}", text, error.what()));
    }
}

Work read_work(const ExecOptions& options) {
    Work work;
    const isa::Parameters parameters = parse_parameters(options.parameters);
    for (const std::string& path : options.programs) {
        const std::string text = read_file(path);
        if (!is_case(text)) {
            work.programs.push_back(assemble_file(path, text, parameters));
            continue;
        }
        if (options.programs.size() > 1 || !options.init.empty()) {
            throw RequestError(ExitCode::usage,
                               path + " is a conformance case: it runs alone, without --init");
        }
        try {
            work.test = isa::parse_conformance(text);
        } catch (const isa::ConformanceError& error) {
            throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", path, error.what()));
        }
        work.programs.push_back(work.test->program.bind(parameters));
        work.given = work.test->given;
    }
    for (const std::string& text : options.init) {
        work.given.push_back(parse_init(text));
    }
    return work;
}

Ran run(const Work& work, ExecutorKind kind) {
    Ran ran{kind, make_executor(kind), {}, {}, {}, {}};
    try {
        isa::set_up(work.given, *ran.executor);
    } catch (const std::invalid_argument& error) {
        throw RequestError(ExitCode::usage, error.what());
    }
    ran.executor->set_readout([&ran](std::span<const std::uint32_t> pixels) {
        ran.readout.assign(pixels.begin(), pixels.end());
    });
    isa::Controller controller;
    controller.on_signal = [&ran](std::uint32_t number) { ran.signals.push_back(number); };
    for (const std::vector<std::uint32_t>& words : work.programs) {
        isa::Sequencer sequencer(words, *ran.executor, controller);
        try {
            sequencer.run();
        } catch (const isa::RunError& error) {
            ran.stopped = error.what();
        }
        ran.counts.instructions += sequencer.counts().instructions;
        ran.counts.cycles += sequencer.counts().cycles;
    }
    ran.executor->set_readout({});
    return ran;
}

std::string counts_text(const Ran& ran) {
    std::size_t enabled = 0;
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            enabled += ran.executor->enabled(x, y) ? 1 : 0;
        }
    }
    std::string text =
        fmt::format("{}: {} instructions, {} cycles at 40 MHz; {} of {} pixels enabled at the end",
                    name_of(ran.kind), grouped(ran.counts.instructions), grouped(ran.counts.cycles),
                    grouped(enabled), grouped(region_pixels));
    for (const std::uint32_t number : ran.signals) {
        text += fmt::format("\nSIGNAL #{}", number);
    }
    return ran.stopped.empty() ? text : text + "\nstopped: " + ran.stopped;
}

/// The first pixel and what of it differs; empty if all is equal.
std::string first_difference(const Ran& a, const Ran& b) {
    const auto differ = [&](int x, int y, const ShownField& field) {
        const std::uint64_t in_a = value_of(a.pixels(), field.column, x, y);
        const std::uint64_t in_b = value_of(b.pixels(), field.column, x, y);
        return in_a == in_b ? ""
                            : fmt::format("pixel ({}, {}): {} is {} on {}, {} on {}", x, y,
                                          field.name, in_a, name_of(a.kind), in_b, name_of(b.kind));
    };
    std::vector<ShownField> fields = {parse_field("enable"), parse_field("carry")};
    for (std::uint32_t address = 0; address < isa::memory_bits; address += whole_word) {
        fields.push_back(parse_field(
            fmt::format("m{}:{}", address, std::min(whole_word, isa::memory_bits - address))));
    }
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            for (const ShownField& field : fields) {
                if (const std::string text = differ(x, y, field); !text.empty()) {
                    return text;
                }
            }
        }
    }
    return a.readout == b.readout ? "" : "what PIXELSTOFB sent differs";
}

void show(const ExecOptions& options, const Ran& ran, TextOutput& output) {
    const NumberStyle style{options.hex, options.is_signed};
    std::vector<std::string> names = options.prints;
    if (names.empty() && !options.pixel.empty()) {
        names = {"enable", "carry", "surface", "z", "normal_x", "normal_y", "normal_z", "rgb"};
    }
    if (!options.pixel.empty()) {
        const isa::PixelRectangle at = parse_window(options.pixel);
        output.line(fmt::format("pixel ({}, {})", at.x0, at.y0));
        for (const std::string& name : names) {
            const ShownField field = parse_field(name);
            output.line(fmt::format("  {:<10} {}", name,
                                    number_text(value_of(ran.pixels(), field.column, at.x0, at.y0),
                                                field.column, style)));
        }
        return;
    }
    for (const std::string& name : names) {
        output.put("\n" + field_table(ran.pixels(), parse_field(name), parse_window(options.window),
                                      style));
    }
}

void save_picture(const ExecOptions& options, const Ran& ran, TextOutput& output) {
    const FieldPicture picture = field_picture(ran.pixels(), parse_field(options.picture));
    if (!picture.warning.empty()) {
        print_notice("warning", picture.warning);
    }
    write_png(options.output, region_px, region_px, picture.rgba);
    output.line(fmt::format("wrote {} ({}x{}){}{}", options.output, region_px, region_px,
                            picture.legend.empty() ? "" : "; ", picture.legend));
}

/// True if the case holds on every executor.
bool check_case(const isa::ConformanceCase& test, const std::vector<Ran>& all, TextOutput& output) {
    bool holds = true;
    for (const Ran& ran : all) {
        const std::string difference = isa::first_difference(test, *make_executor(ran.kind));
        output.line(fmt::format(
            "{}: '{}' {}", name_of(ran.kind), test.title,
            difference.empty() ? "is as expected" : "is not as expected: " + difference));
        holds = holds && difference.empty();
    }
    return holds;
}

void check_options(const ExecOptions& options) {
    if (options.picture.empty() != options.output.empty()) {
        throw RequestError(ExitCode::usage,
                           "give both --picture FIELD and -o FILE.png, or neither");
    }
    if (!options.picture.empty()) {
        parse_field(options.picture);
        check_png_name(options.output);
    }
    for (const std::string& name : options.prints) {
        parse_field(name);  // Before anything runs.
    }
    parse_window(options.window);
}

}  // namespace

int execute(const ExecOptions& options, TextOutput& output) {
    check_options(options);
    const Work work = read_work(options);
    std::vector<Ran> all;
    bool good = true;
    for (const ExecutorKind kind : parse_executors(options.executor)) {
        all.push_back(run(work, kind));
        output.line(counts_text(all.back()));
        good = good && (all.back().stopped.empty() || work.test);
        if (all.size() > 1) {
            const std::string difference = first_difference(all.front(), all.back());
            output.line(difference.empty() ? fmt::format("{} and {} agree on all pixels",
                                                         name_of(all.front().kind), name_of(kind))
                                           : difference);
            good = good && difference.empty();
        }
    }
    show(options, all.front(), output);
    if (!options.picture.empty()) {
        save_picture(options, all.front(), output);
    }
    good = (!work.test || check_case(*work.test, all, output)) && good;
    output.finish();
    return static_cast<int>(good ? ExitCode::ok : ExitCode::failed);
}

int execute_tool(const ExecOptions& options) {
    TextOutput output("");
    return execute(options, output);
}

}  // namespace pxpl5::host::inspect
