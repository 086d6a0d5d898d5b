// A Graphics Processor: which message starts which stage.
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
//   DrawFrame (GP 0)  --->|            |---> BeginFrame      (from GP 0 to all that draw)
//   BeginFrame        --->|            |---> RegionPrograms  (one to each Renderer)
//                         |            |---> FrameCounts     (to the host, if it asked for them)
//                         +------------+---> Fault           (thrown; the driver sends it)
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/programs_messages.hpp"
#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// What a GP tells apart of its work, besides the stages of every node.
namespace stage {
using namespace bus::stage;
inline constexpr std::string_view load = "load";  ///< Slices and gradients, or parts of a scene.
inline constexpr std::string_view extract = "extract";
inline constexpr std::string_view measure = "measure";
inline constexpr std::string_view assign = "assign";        ///< Of regions, by the Master GP.
inline constexpr std::string_view transform = "transform";  ///< Of vertices to the screen.
inline constexpr std::string_view select = "select";        ///< Culling, clipping, binning.
inline constexpr std::string_view set_up = "set_up";        ///< Planes, and the words of programs.
}  // namespace stage

inline constexpr std::size_t max_jobs = 16384;  ///< Waiting at one GP; what comes then is refused.

/// Work is done in the order in which it was asked for, but a newer revision of a surface takes the
/// place of older work on it, and a new volume that of all work. Isovalues are measured when there
/// is nothing else to do.
class GpNode final : public bus::Node {
  public:
    void receive(const bus::Message& message, bus::Outbox& out) override;
    bool work(bus::Outbox& out) override;
    bus::NodeStatus status() const override;

  private:
    using Clock = std::chrono::steady_clock;

    /// The machine, as far as this GP talks to it.
    struct Machine {
        Share share;
        std::vector<bus::NodeId> gps, renderers, frame_buffers;  ///< Each by index.
        std::size_t memory_bytes = 0;
        bool origins = false;  ///< Recording: keep where triangles come from.
    };

    // What work() has to do.
    struct TakeSlices {
        bus::Message message;
        std::uint32_t done = 0;  ///< Slices of the message that the store has.
    };
    struct EndVolume {};
    struct TakePart {
        bus::Message message;
    };
    struct EndScene {};
    struct Extract {
        std::uint16_t surface = 0;
        std::uint32_t revision = 0;
        double isovalue = 0;
        CaseRule rule = CaseRule::watertight;
        Clock::time_point since;
        std::size_t next_slab = 0;  ///< Index into the store's slabs.
        bool slab_begun = false;    ///< extraction_ is of that one.
    };
    struct Remove {
        std::uint16_t surface = 0;
    };
    struct Fetch {
        std::uint16_t surface = 0;
        bus::NodeId to = 0;
        bool origins = false;
        std::unique_ptr<MeshPartBuilder> part;  ///< Null until it has begun.
        std::size_t next_slab = 0;
    };
    struct Mask {
        bus::Message message;
    };
    struct Draw {
        enum class Stage : std::uint8_t { waiting, drawing, sending };
        FrameRequest request;
        Stage stage = Stage::waiting;
    };
    using Job =
        std::variant<TakeSlices, EndVolume, TakePart, EndScene, Extract, Remove, Fetch, Mask, Draw>;

    /// Isovalues to be measured, slab by slab.
    struct Measure {
        std::vector<double> isovalues;
        CaseRule rule = CaseRule::watertight;
        bus::NodeId to = 0;
        std::vector<SlabCounts> counts;  ///< As far as it has come: slab by slab.
    };

    void set_machine(const bus::Message& message);
    void begin_volume(const bus::schema::VolumeHeader& header, bus::Outbox& out);
    void note_slices(const bus::Message& message);
    void begin_scene(const bus::schema::SceneBegin& begin, bus::Outbox& out);
    void note_part(const bus::Message& message);
    void drop_all(bus::Outbox& out);
    void note_surface(const bus::schema::SetSurface& set);
    void note_removal(std::uint16_t surface);
    bool awaits_surface() const;
    void take_mask(const bus::schema::MaskSurface& mask);
    void note_measure(const bus::Message& message);
    void drop_volume(const bus::schema::DropVolume& drop, bus::Outbox& out);
    void begin_frame(const bus::Message& message, bus::Outbox& out);
    void note_frame(const bus::schema::BeginFrame& begin);
    FrameRequest request_of(const bus::schema::DrawFrame& draw) const;
    std::size_t max_regions_each(const bus::schema::DrawFrame& draw, std::size_t regions) const;

    // Each does a piece of a job and returns true when the job is done.
    bool step(TakeSlices& job, bus::Outbox& out);
    bool step(EndVolume& job, bus::Outbox& out);
    bool step(TakePart& job, bus::Outbox& out);
    bool step(EndScene& job, bus::Outbox& out);
    bool step(Extract& job, bus::Outbox& out);
    bool step(Remove& job, bus::Outbox& out);
    bool step(Fetch& job, bus::Outbox& out);
    bool step(Mask& job, bus::Outbox& out);
    bool step(Draw& job, bus::Outbox& out);
    bool step(Measure& job, bus::Outbox& out);
    bool draw_piece(Draw& job, bus::Outbox& out);
    bool draw_slabs(bus::StageClock* clock);

    void extract_next(Extract& job, HeldSurface& surface);
    void drop_surface(std::uint16_t surface);
    const HeldSurface& surface_to_fetch(std::uint16_t surface) const;
    std::span<const Origin> origins_of(const HeldSurface& surface, const SlabMesh& mesh);
    std::string memory_advice(const Extract& job, std::size_t slabs_done) const;
    void send_nothing(const Draw& job, bus::Outbox& out);
    std::uint16_t gp_index() const;

    std::optional<Machine> machine_;
    std::optional<LocalMemory> memory_;
    std::unique_ptr<SliceStore> store_;  ///< Null without a volume, or if it does not fit.
    std::optional<std::uint32_t> volume_;
    bool scene_ = false;  ///< What volume_ counts is a scene.
    Clock::time_point volume_since_;
    Surfaces surfaces_;
    std::map<std::uint16_t, std::uint32_t> announced_;  ///< Newest revision asked for, by surface.
    SlabExtraction extraction_;  ///< Of the job in front, if that extracts; it fills scratch_.
    SlabMesh scratch_;  ///< Grows as slabs are extracted, so that those that are held need not.
    std::deque<Job> jobs_;
    std::optional<Measure> measuring_;  ///< Behind all jobs.
    FrameDrawing drawing_;              ///< Of the job in front, if that draws.
    ProgramsMessages programs_;         ///< Of drawing_.
    std::uint64_t frames_ = 0;          ///< Sent.
};

}  // namespace pxpl5::gp
