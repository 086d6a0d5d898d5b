#include "host/inspect/listing/ls.hpp"

#include "host/base/text_output.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/record/run_table.hpp"

namespace pxpl5::host::inspect {

int trace_ls(const LsOptions& options) {
    const RunTable table = table_of(open_run(options.run));
    TextOutput output(options.output);
    output.put(options.json ? json_text(to_fields(table)) + "\n" : to_text(table));
    output.finish();
    return 0;
}

}  // namespace pxpl5::host::inspect
