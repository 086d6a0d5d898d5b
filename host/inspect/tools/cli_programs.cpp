// The command line of asm, dis and exec.
#include "host/inspect/tools/cli_declare.hpp"
#include "host/inspect/tools/exec.hpp"
#include "host/inspect/tools/program_tools.hpp"

namespace pxpl5::host::inspect {

namespace {

void declare_parameters(CLI::App& app, std::vector<std::string>& parameters) {
    app.add_option("--param", parameters, "Value of a $name in the text: name=number")
        ->allow_extra_args(false);
}

void declare_asm(CLI::App& app, AsmOptions& options) {
    app.add_option("file", options.file, "Assembly; - is standard input")->required();
    declare_parameters(app, options.parameters);
    app.add_option("-o,--output", options.output,
                   "Write binary little-endian words here; without it hexadecimal text is printed");
    app.add_flag("--hex", options.hex, "Hexadecimal text with -o, too");
}

void declare_dis(CLI::App& app, DisOptions& options) {
    app.add_option("file", options.file,
                   "Little-endian words, or hexadecimal text; - is standard input")
        ->required();
    app.add_flag("--numbered", options.numbered,
                 "Place, raw word and cycles before each line; not for asm");
    app.add_flag("--hex", options.hex, "The file is hexadecimal text");
    app.add_flag("--binary", options.binary, "The file is binary");
    declare_output(app, options.output);
}

void declare_exec(CLI::App& app, ExecOptions& options) {
    app.add_option("program", options.programs,
                   "Assembly files, run one after the other, or one conformance case")
        ->required();
    app.add_option("--init", options.init,
                   "State before: FIELD=VALUE or FIELD@PIXELS=VALUE, e.g. m0:8=x+2*y or "
                   "enable@0..63,*=1; all else is 0")
        ->allow_extra_args(false);
    declare_parameters(app, options.parameters);
    app.add_option("--executor", options.executor,
                   "reference, fast, sse4, avx2, avx512, or both: several are compared")
        ->capture_default_str();
    app.add_option("--print", options.prints,
                   "Print a field: z, rgb, m88:16, enable, carry, bs3, readout")
        ->allow_extra_args(false);
    app.add_option("--window", options.window, "Pixels to print")->capture_default_str();
    app.add_option("--pixel", options.pixel, "Print the fields of this pixel, x,y, and no table");
    app.add_flag("--hex", options.hex, "Print hexadecimal numbers");
    app.add_flag("--signed", options.is_signed, "Print fields as signed numbers");
    app.add_option("--picture", options.picture, "Draw this field as a picture; needs -o");
    app.add_option("-o,--output", options.output, "The picture's PNG file");
}

}  // namespace

void declare_programs(Tools& tools, CLI::App& parent) {
    add_tool<AsmOptions>(tools, parent, "asm", "Assemble a program into instruction words",
                         assemble_tool, declare_asm);
    add_tool<DisOptions>(tools, parent, "dis", "Turn instruction words into assembly",
                         disassemble_tool, declare_dis);
    add_tool<ExecOptions>(tools, parent, "exec", "Run assembly on a pixel array and show pixels",
                          execute_tool, declare_exec);
}

}  // namespace pxpl5::host::inspect
