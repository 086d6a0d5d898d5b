// Helpers for tests of recorders: messages, contents of traces, and a full disk.
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

#include "ringbus/trace/trace_file.hpp"
#include "tests/ringbus/wire_bytes.hpp"

namespace pxpl5::test {

inline bus::trace::Info info_for(Recording mode) {
    bus::trace::Info info;
    info.build = "pxpl5 test";
    info.schema_hash = bus::schema_hash();
    info.recording = mode;
    return info;
}

inline bus::Message from(bus::NodeId source, const bus::Payload& payload) {
    WireBytes wire(payload);
    wire.header.mutate_source(source);
    return wire.read();
}

inline bus::Payload surface(std::uint16_t number, std::uint32_t revision) {
    bus::schema::SetSurfaceT body;
    body.surface = number;
    body.revision = revision;
    return bus::pack(body);
}

inline bus::Payload topology_with(std::uint16_t nodes) {
    bus::schema::TopologyT body;
    for (std::uint16_t id = 0; id < nodes; ++id) {
        body.nodes.push_back(std::make_unique<bus::schema::NodeInfoT>());
        body.nodes.back()->id = id;
        body.nodes.back()->role = id == 0 ? bus::schema::Role::host : bus::schema::Role::gp;
        body.nodes.back()->endpoint = "ipc:///somewhere";
    }
    return bus::pack(body);
}

/// The kinds in a trace, for example "Topology SetSurface".
inline std::string kinds_in(const std::filesystem::path& path) {
    std::string kinds;
    const bus::trace::TraceFile file(path);
    for (const bus::trace::Entry& entry : file.entries()) {
        kinds += (kinds.empty() ? "" : " ") + bus::kind_name(entry.kind());
    }
    return kinds;
}

/// The next file operations of this process fail at `bytes`.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(std::uint64_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);
        getrlimit(RLIMIT_FSIZE, &before_);
        rlimit tight = before_;
        tight.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &tight);
    }
    ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

  private:
    rlimit before_{};
};

}  // namespace pxpl5::test
