// pxpl5 asm and pxpl5 dis.
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/tools/program_files.hpp"
#include "host/inspect/tools/tools.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

/// Words that are no whole instruction.
std::size_t count_undecoded(const std::vector<std::uint32_t>& words) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t length = isa::instruction_words(words[at]);
        const bool whole = isa::decode(words[at]).has_value() && length <= words.size() - at;
        count += whole ? 0 : 1;
        at += whole ? length : 1;
    }
    return count;
}

}  // namespace

int assemble_tool(const AsmOptions& options) {
    const std::vector<std::uint32_t> words =
        assemble_file(options.file, read_file(options.file), parse_parameters(options.parameters));
    TextOutput output(options.output);
    output.raw(options.output.empty() || options.hex ? hex_of(words) : binary_of(words));
    output.finish();
    return 0;
}

int disassemble_tool(const DisOptions& options) {
    if (options.hex && options.binary) {
        throw RequestError(ExitCode::usage, "--hex and --binary: only one of them");
    }
    const WordFormat format = options.hex      ? WordFormat::hex
                              : options.binary ? WordFormat::binary
                                               : WordFormat::detect;
    const std::vector<std::uint32_t> words =
        parse_words(options.file, read_file(options.file), format);
    TextOutput output(options.output);
    if (options.numbered) {
        output.line(
            fmt::format("{:>6}  {:<8}  {:>6}  {}", "; word", "raw", "cycles", "instruction"));
    }
    output.put(isa::disassemble(words, {.numbered = options.numbered}));
    output.finish();
    const std::size_t undecoded = count_undecoded(words);
    if (undecoded != 0) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: {} of {} words are no instruction; they are comments "
                                       "in the text",
                                       options.file, undecoded, words.size()));
    }
    return 0;
}

}  // namespace pxpl5::host::inspect
