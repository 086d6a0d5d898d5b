// Opens recorded runs from files.
#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/inspect/record/recorded_run.hpp"
#include "isa/table_hash.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;

NodeTrace open_trace(const fs::path& path) {
    try {
        auto file = std::make_shared<bus::trace::TraceFile>(path);
        const auto hash = file->info().more.find("isa_hash");
        if (hash != file->info().more.end() && hash->second != isa::table_hash()) {
            throw RequestError(
                ExitCode::bad_data,
                fmt::format("{}: recorded with instruction table {}, this program's is {}",
                            path.string(), hash->second, isa::table_hash()));
        }
        NodeTrace node{file->info(), file->entries(), {}, file->cut()};
        node.load = [file](const bus::trace::Entry& entry) { return file->load(entry); };
        return node;
    } catch (const bus::trace::TraceError& error) {
        throw RequestError(ExitCode::bad_data, error.what());
    }
}

std::vector<fs::path> trace_files(const fs::path& path) {
    if (fs::is_regular_file(path)) {
        return {path};
    }
    const fs::path folder = fs::is_directory(path / "traces") ? path / "traces" : path;
    std::vector<fs::path> files;
    if (fs::is_directory(folder)) {
        for (const auto& entry : fs::directory_iterator(folder)) {
            if (entry.path().extension() == ".mcap") {
                files.push_back(entry.path());
            }
        }
    }
    std::ranges::sort(files);
    return files;
}

}  // namespace

RecordedRun RecordedRun::open(const fs::path& path) {
    std::vector<fs::path> files;
    try {
        files = trace_files(path);
    } catch (const fs::filesystem_error& error) {
        throw RequestError(ExitCode::bad_data, fmt::format("{}: cannot be read: {}", path.string(),
                                                           error.code().message()));
    }
    if (files.empty()) {
        const std::string reason = !fs::exists(path) ? "there is no such run"
                                   : fs::is_directory(path)
                                       ? "holds no trace (*.mcap); record with --record full"
                                       : "is no run: give the folder of a run, or a trace (*.mcap)";
        throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", path.string(), reason));
    }
    std::vector<NodeTrace> nodes;
    for (const fs::path& file : files) {
        nodes.push_back(open_trace(file));
    }
    return RecordedRun(std::move(nodes));
}

}  // namespace pxpl5::host::inspect
