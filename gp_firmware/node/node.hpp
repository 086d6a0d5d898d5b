// The node of a Graphics Processor: hands each message and each job to its service.
//
//   Topology          --->+------------+
//   VolumeHeader      --->|            |
//   Slices, VolumeEnd --->|            |---> VolumeReady     (to the host)
//   DropVolume        --->|            |
//   SceneBegin,       --->|            |
//   ScenePart, SceneEnd-->|            |---> VolumeReady     (to the host)
//   SetSurface        --->|            |---> SurfaceBuilt    (to the host)
//   RemoveSurface,    --->|     GP     |
//   MaskSurface       --->|            |
//   FetchMesh         --->|            |---> MeshPart        (to the host)
//   MeasureIsovalues  --->|            |---> IsovaluesMeasured  (to the host)
//   FetchVoxels       --->|            |---> VoxelValues     (to the host)
//   DrawFrame (GP 0)  --->|            |---> BeginFrame      (from GP 0 to all that draw)
//   BeginFrame        --->|            |---> RegionPrograms  (one to each Renderer)
//                         |            |---> FrameCounts     (to the host, if it asked for them)
//                         +------------+---> Fault           (thrown; the node loop sends it)
#pragma once

#include <optional>

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

class GpNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::NodeStatus status() const override;
    bus::Doing doing() override;

  private:
    void set_machine(const bus::Message& topology);
    void dispatch(const bus::Message& message, bus::Outbox& out);
    void drop_all(bus::Outbox& out, Freed freed = Freed::returned);

    std::optional<Board> board_;  ///< Empty until Topology has arrived.
    JobQueue queue_;
};

}  // namespace pxpl5::gp
