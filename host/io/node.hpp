// The io process as a node: volumes in, pictures and meshes out.
//
//   ImportVolume  --->+--------+---> VolumeHeader, Slices..., VolumeEnd   (to who asked)
//   ExportPicture --->|   io   |---> IoDone
//   ExportMesh    --->|        |---> MeshContent (what was decimated or read), then IoDone
//   ReadMesh      --->|        |
//   ReadArchive   --->+--------+---> ArchiveContent, then IoDone
//
// A request that fails is answered by IoDone{ok: false}. Requests are served in the order of their
// arrival.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/io/import.hpp"
#include "host/io/limits.hpp"
#include "host/volume/volume.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_requests = 64;  ///< Waiting to be served.

class IoNode final : public bus::Node {
  public:
    /// allowed   Folders in which headers may name data files, beside their own.
    /// confines  Confines this process to its first request, and serves no other one.
    explicit IoNode(const Limits& limits, std::vector<std::string> allowed = {},
                    bool confines = false)
        : limits_(limits), allowed_(std::move(allowed)), confines_(confines) {}

    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::Doing doing() override;

  private:
    /// A volume on its way out.
    struct Sending {
        std::uint32_t id = 0;
        Volume volume;
        int next_slice = 0;
    };
    /// A request for volumes.
    struct Import {
        bus::NodeId to = 0;
        Importer importer;
        std::uint32_t frame = 0, last_frame = 0;  ///< The next volume, and the last one.
        std::optional<Sending> sending;
    };

    void begin_import(const bus::Message& request);
    void work_on_import(bus::Outbox& out);
    void begin_volume(bus::Outbox& out);
    void send_slices(bus::Outbox& out);

    Limits limits_;
    std::vector<std::string> allowed_;
    bool confines_;
    bool has_request_ = false;
    std::deque<bus::Message> requests_;
    std::optional<Import> import_;
    std::uint32_t volumes_ = 0;
};

}  // namespace pxpl5::host::io
