// The contents of a recorded run: its nodes, volumes and frames, for `trace ls`.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/inspect/record/recorded_run.hpp"

namespace pxpl5::host::inspect {

/// One node's trace.
struct NodeRow {
    std::string name, recording;
    std::uint64_t messages = 0, bytes = 0;          ///< Bodies, uncompressed.
    std::uint64_t first_clock = 0, last_clock = 0;  ///< Logical time at the senders.
    std::uint64_t dropped = 0;
    std::string cut;  ///< Why the trace ends early; empty if it is complete.
};

struct VolumeRow {
    std::uint32_t id = 0;
    std::string name, source, type;
    std::uint32_t nx = 0, ny = 0, nz = 0;
    std::uint64_t digest = 0;
};

struct FrameRow {
    std::uint32_t number = 0, width = 0, height = 0, views = 0;
    std::size_t surfaces = 0;
    std::uint64_t triangles = 0, triangles_drawn = 0;  ///< On all surfaces; after culling.
    std::uint64_t words = 0;                           ///< In all streams.
    std::size_t regions = 0, executable = 0;  ///< Executable: all its messages are recorded.
    std::uint64_t instructions = 0;           ///< Reported by the Renderers; 0 if missing.
    bool done = false;                        ///< FrameDone came, of all views.
};

struct RunTable {
    std::string build, schema_hash;
    std::map<std::string, std::string> more;  ///< E.g. isa_hash; without the topology.
    std::string topology;                     ///< Resolved, as JSON; empty if it was not recorded.
    std::uint32_t gps = 0, renderers = 0, frame_buffers = 0;
    std::vector<NodeRow> nodes;
    std::vector<VolumeRow> volumes;
    std::vector<FrameRow> frames;
};

RunTable table_of(const RecordedRun& run);

Answer answer_of(const RunTable& table);

}  // namespace pxpl5::host::inspect
