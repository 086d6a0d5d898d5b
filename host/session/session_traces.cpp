// What a session does with traces: has them written.
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

SavedTraces Session::save_traces() {
    SavedTraces saved = machine_.save_traces();
    if (!saved.missing.empty()) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{} of {} nodes have written no trace: {}", saved.missing.size(),
                        saved.missing.size() + static_cast<std::size_t>(saved.nodes),
                        fmt::join(saved.missing, "; ")));
    }
    return saved;
}

std::string Session::traces_of_fault() {
    if (!fault_is_ours_ || !machine_.is_recording()) {
        return {};
    }
    try {
        const SavedTraces saved = machine_.save_traces();
        return saved.nodes == 0
                   ? ""
                   : fmt::format("; traces of {} nodes: {}", saved.nodes, saved.folder);
    } catch (const RequestError& error) {
        return fmt::format("; no traces: {}", error.what());  // The fault is the one to tell.
    }
}

}  // namespace pxpl5::host
