// One person's work with the machine: a volume, surfaces, and the pictures of them.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/spread.hpp"
#include "host/machine/port.hpp"
#include "host/phigs/content.hpp"
#include "host/scene/marks.hpp"
#include "host/scene/pick.hpp"
#include "host/scene/scene.hpp"
#include "host/session/activity.hpp"
#include "host/session/frame_request.hpp"
#include "host/session/history.hpp"
#include "host/session/volume_transfer.hpp"
#include "host/surface/atlas/atlas_chart.hpp"
#include "host/surface/compare.hpp"
#include "host/surface/components.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

namespace inspect {
class LiveFrame;
}

/// A finished picture, top row first.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint32_t> rgba;  ///< width * height; red in the low byte.
};

/// What the GPs report of one extraction, summed over slabs in slab order.
struct SurfaceReport {
    std::int64_t triangles = 0, vertices = 0;
    std::int64_t cells_active = 0, cells_ambiguous = 0, rows_skipped = 0;
    double area_mm2 = 0;
    double volume_mm3 = 0;                         ///< Of the inside, closed by the volume's faces.
    double elapsed_ms = 0;                         ///< Command to the last GP's acknowledgement.
    std::int64_t memory_bytes = 0;                 ///< In use over all GPs afterwards.
    std::vector<bus::schema::SlabCounts> slabs{};  ///< Ascending.
};

/// Of a picture of several samples: all its passes together.
struct FrameReport {
    std::uint32_t frame = 0;                      ///< The last one's number.
    std::int64_t instructions = 0;                ///< Executed by all Renderers.
    std::int64_t renderer_cycles = 0;             ///< Modelled, summed over regions.
    double elapsed_ms = 0;                        ///< Request to picture.
    int region_columns = 0, region_rows = 0;      ///< Rows over all views.
    std::vector<std::uint64_t> region_cycles;     ///< Modelled, by region.
    std::vector<std::uint16_t> region_renderers;  ///< Index of who drew it, by region.
};

/// A frame, and what each GP and Renderer tells of it.
struct CountedFrame {
    std::uint32_t frame = 0;
    std::uint32_t width = 0, height = 0, views = 1;  ///< Pixels of a view.
    Pass pass;
    std::vector<std::uint16_t> region_renderers;  ///< Index of who drew it, by region.
    std::map<bus::NodeId, bus::schema::FrameCountsT> counts;
};

struct LoadReport {
    std::string source;
    double read_ms = 0;        ///< Decode or build the volume.
    double distribute_ms = 0;  ///< From then on until the last GP has its slice sets.
    std::int64_t memory_bytes = 0;
};

/// How far loading has come.
struct LoadProgress {
    enum class Phase : std::uint8_t { reading, distributing };
    Phase phase = Phase::distributing;
    int done = 0, total = 0;  ///< Slices read, messages sent; total 0 while nobody knows.
    friend bool operator==(const LoadProgress&, const LoadProgress&) = default;
};

/// What to do with a file's voxels; the path is left empty.
using ImportOptions = bus::schema::ImportVolumeT;

/// What goes into a picture's file besides its pixels.
struct PictureExtras {
    std::string description;
    std::vector<std::pair<std::string, std::string>> attributes;  ///< Word and value.
    std::vector<PictureMark> marks;                               ///< Drawn over it.
    int delay_ms = 40;  ///< Between the pictures of an animation.
};

/// How a mesh is written.
struct MeshExport {
    std::vector<std::string> surfaces;  ///< By name; empty for all visible ones.
    bool ras = false;                   ///< Axes to the right, anterior, superior instead of LPS.
    double keep = 1;                    ///< Share of the triangles that decimation leaves.
    std::string description;
};

struct MeshExportReport {
    std::int64_t triangles = 0;  ///< In the file.
    std::string text;            ///< What the writer says.
};

struct OrbitReport {
    int frames = 0;
    double elapsed_ms = 0;
    Spread latency_ms;  ///< Of a frame's request to its picture.
};

struct SweepReport {
    int changes = 0;
    Spread extraction_ms;  ///< As SurfaceReport::elapsed_ms.
    Spread picture_ms;     ///< Isovalue changed to the picture that shows it.
};

/// Whether nodes that are at work are waited for.
enum class AwaitAnswers : std::uint8_t { none, all };

/// GPs prepare one frame while Renderers draw the other.
inline constexpr int max_frames_in_flight = 2;

/// Drives a machine. Every operation waits for its result; errors are RequestError (a request that
/// cannot be obeyed, or a node's Fault) and MachineError (a process died).
class Session {
  public:
    explicit Session(MachinePort& machine);

    Scene scene;
    History history;     ///< Of the commands that were run.
    int play_depth = 0;  ///< Scripts that are being played, one by the other.

    std::size_t gp_count() const { return machine_.gp_ids().size(); }
    std::size_t renderer_count() const { return machine_.renderer_ids().size(); }

    /// Reads a file or folder, or builds "phantom:NAME", and distributes it while it is read.
    /// Surfaces are dropped. What was loaded stays if the new volume cannot be read; if it cannot
    /// be held, or on Ctrl-C (which throws Cancelled), nothing is loaded.
    /// A PPHIGS archive is no volume, but a scene: it is drawn as it is.
    LoadReport load(const std::string& source, const ImportOptions& options = {});
    /// Called while a volume is loaded; may be empty.
    std::function<void(const LoadProgress&)> progress;
    /// Of volumes loaded from now on; 0: as slabs_per_set_for() says. Changes no surface and no
    /// picture.
    int slabs_per_set = 0;
    /// Whether pictures or meshes will be written soon after a volume is loaded: what writes them
    /// is then made ready meanwhile.
    bool will_write = false;
    /// Reads a volume without distributing it.
    Volume read(const std::string& source, const ImportOptions& options = {});
    bool has_volume() const { return volume_.has_value(); }
    /// The archive that is loaded, without its parts; null if none is.
    const phigs::Content* archive() const { return archive_ ? &archive_->content : nullptr; }
    /// Throws RequestError if no volume is loaded.
    const Volume& volume() const;

    /// Adds the surface, or gives it a new isovalue, and extracts it on all GPs.
    SurfaceReport set_surface(const std::string& name, double isovalue, CaseRule table,
                              Colour colour);
    void remove_surface(const std::string& name);
    /// The surface of that name, if there is one.
    std::optional<Surface> surface(const std::string& name) const;
    /// Changes how a surface is drawn: colour, visible, opacity, cull_back. The rest is not looked
    /// at.
    void set_style(const Surface& like);
    const SurfaceReport& report_of(const std::string& name) const;

    /// Draws the scene, with as many samples a pixel as it says.
    Picture draw();
    /// Draws the scene with 1, 4 or 16 samples a pixel (sample_offset()), two passes at a time.
    /// go_on is asked before each pass, if there is one; when it says no, nothing is returned, as
    /// soon as the passes under way have come. Throws RequestError (failed) as drawing does, and if
    /// the Renderers have no room for the sums: see max_samples().
    std::optional<Picture> draw_samples(int samples, const std::function<bool()>& go_on = {});
    /// Draws the scene, and drops the picture: one frame for each sample a pixel, in their order.
    std::vector<CountedFrame> draw_counted();
    /// The most samples that the machine can draw a picture of the scene's size with.
    int max_samples() const;
    /// Draws `frames` frames, the azimuth growing by 360/frames each, `in_flight` (1 or 2) at a
    /// time; hands each to `take` in order, with the camera that it was seen by. The camera ends
    /// where it was.
    using TakeFrame = std::function<void(int, const Picture&, const Camera&)>;
    OrbitReport orbit(int frames, const TakeFrame& take, int in_flight = max_frames_in_flight);
    /// Gives the surface, which is there, one isovalue after the other and draws each, one in
    /// flight; hands each to `take` in order. The surface ends as it was, also if `take` throws
    /// RequestError.
    using TakeChange = std::function<void(int, const Picture&, const SurfaceReport&)>;
    SweepReport sweep(const std::string& name, std::span<const double> isovalues,
                      const TakeChange& take);
    const FrameReport& last_frame() const { return last_frame_; }

    /// What pixel (x, y) from the top left shows; nothing for the background. Draws the scene
    /// once. Surfaces of archives are not picked: throws RequestError.
    struct Picked {
        Pick pick;
        std::string surface;
    };
    std::optional<Picked> pick(int x, int y);

    /// Equal for two moments only if a frame drawn then and one drawn now are the same: a digest of
    /// what is asked for, and of how often the GPs were told something else.
    std::uint64_t frame_key() const;
    /// What is known of the frame that was asked about last (host/inspect/why/live_frame.hpp).
    std::shared_ptr<inspect::LiveFrame> asked_frame;

    /// Writes pictures of one size through the io process, several as one animation. Throws
    /// RequestError if that fails.
    void export_pictures(std::span<const Picture> pictures, const std::string& path,
                         const PictureExtras& extras);

    /// The surface as one mesh. cells: with the cell of each triangle.
    WeldedMesh mesh(const std::string& name, bool cells = false);
    VolumeGrid grid() const { return grid_of(volume()); }
    /// The sphere that the camera looks at.
    Subject subject() const { return stage().subject; }
    /// Draws only the shown triangles of `mesh`, until the surface changes.
    void show_triangles(const std::string& name, const WeldedMesh& mesh, const Shown& shown);
    /// Draws only these components, also after the isovalue changes. Returns how many there are,
    /// and how many are drawn.
    std::pair<std::size_t, std::size_t> set_components(const std::string& name,
                                                       const ComponentFilter& filter);
    /// Writes surfaces, as far as their components are drawn, through the io process.
    MeshExportReport export_mesh(const std::string& path, const MeshExport& wish);

    /// Shows the cells where `watertight` and `lorensen1987` differ, as two surfaces of their own,
    /// in place of `name`. Ends with end_comparison(), or when either of the three changes.
    MeshComparison compare(const std::string& name);
    /// Whether there was one.
    bool end_comparison(const std::string& name);

    /// What extraction would give at each isovalue (ascending); without components.
    std::vector<AtlasRow> measure_isovalues(std::span<const double> isovalues, CaseRule table);

    /// Has every node write what it has recorded. Throws RequestError if not all of them can.
    SavedTraces save_traces();

    /// What the nodes have done since the last report. Those that are asked now are reported the
    /// next time, unless they are waited for: nodes look up from their work every 10 ms or so.
    ActivityReport activity(AwaitAnswers await);
    /// Kills a node of the machine by its name; the machine's death is thrown by what comes next.
    /// Throws RequestError for the host, an io process, and names that there are not.
    void kill_node(const std::string& name);

    /// FNV-1a over the surface's triangles in slab order: equal for every size of machine.
    std::uint64_t mesh_digest(const std::string& name);

  private:
    struct PendingFrame {
        std::uint32_t frame = 0;
        std::int64_t started_ns = 0;  ///< Of a pass: its picture's first.
        Pass pass;
    };

    /// A PPHIGS archive on the GPs.
    struct HeldArchive {
        phigs::Content content;         ///< Its parts are the GPs'.
        std::vector<Surface> surfaces;  ///< One for each material.
    };

    /// Takes a GP's message and says whether it answers the request under way.
    using Answer = std::function<bool(const bus::Message&)>;

    struct Loading;
    LoadReport load_archive(const std::string& source);
    LoadReport load_volume(Loading& loading, const ImportOptions& options);
    void receive_volume(const std::string& source, const ImportOptions& options,
                        const std::function<void()>& on_slices);
    void distribute(Volume& volume, int slices_there, Loading& loading);
    void tell(const LoadProgress& progress_now, Loading& loading);
    void give_up_volume();
    Stage stage() const;
    void on_message(const bus::Message& message);
    bool is_stale(const bus::schema::Fault& fault) const;
    void on_fault(const bus::schema::Fault& fault);
    void on_answer(const bus::Message& message);
    void on_frame_done(const bus::schema::FrameDone& done);
    void on_frame_counts(const bus::Message& message);
    bool is_counted(const CountedFrame& frame) const;
    /// Pumps until `done`; then throws the first fault that came meanwhile, if any.
    void wait(const std::string& what, const std::function<bool()>& done);
    /// Sends `request` to every GP and waits until each has answered.
    void ask_gps(const std::string& what, const bus::Payload& request, Answer answer);
    void begin_request(Answer answer);
    void send_to_gps(const bus::Payload& request);
    /// Of VolumeReady for the current volume or scene.
    void begin_volume_request();
    /// Waits until every GP has answered what begin_request() announced.
    void wait_for_gps(const std::string& what);
    void give_up_frames();
    void take_what_is_here();
    /// What to add to a fault's text: where its traces are, if there are any.
    std::string traces_of_fault();
    Surface& find_surface(const std::string& name);
    Surface& put_surface(const std::string& name);
    struct Building;
    void begin_surface(Building& building, const std::string& name, double isovalue, CaseRule table,
                       Colour colour);
    SurfaceReport finish_surface(Building& building);
    /// Hands each GP's part of the surface's mesh to `take`, in any order.
    void fetch_mesh(const std::string& name, bool origins,
                    const std::function<void(const bus::Message&)>& take);
    /// The surface's mesh, without the components that are not drawn.
    WeldedMesh drawn_mesh(const Surface& surface);
    /// Masks what the filter leaves out. Returns as set_components().
    std::pair<std::size_t, std::size_t> apply_filter(const Surface& surface);
    void submit_frame(ReadBack read_back = ReadBack::pixels, Pass pass = {}, bool counts = false);
    /// Waits until at most `count` frames are under way.
    void wait_for_frames(std::size_t count);
    Picture take_frame();  ///< The oldest frame under way.
    /// Starts the io process, sends `request` to it and waits until `done`, then lets it go.
    void with_io(const std::string& what, ExitCode on_death, bus::Payload request,
                 const std::function<bool()>& done);

    MachinePort& machine_;
    std::optional<Volume> volume_;
    std::optional<HeldArchive> archive_;  ///< Never together with a volume.
    std::uint32_t volume_id_ = 0;
    std::uint16_t next_surface_id_ = 0;
    std::uint32_t next_frame_ = 0;
    std::uint64_t told_ = 0;          ///< Requests to all GPs.
    std::set<bus::NodeId> answered_;  ///< GPs that have answered the request under way.
    Answer answer_;
    std::int64_t memory_bytes_ = 0;
    std::map<std::string, SurfaceReport, std::less<>> reports_;
    std::deque<PendingFrame> pending_;
    std::deque<Picture> finished_;
    std::vector<CountedFrame> counted_;         ///< Being drawn.
    std::vector<std::uint32_t> depths_;         ///< Of the newest frame that was asked for them.
    std::vector<std::uint64_t> region_costs_;   ///< Of the newest frame.
    std::vector<std::uint64_t> picture_costs_;  ///< By which the newest picture is shared out.
    std::int64_t picture_started_ns_ = 0;
    FrameReport last_frame_;
    ActivityMonitor activity_;
    std::optional<VolumeReceiver> receiver_;
    std::optional<Volume> received_;
    bool io_done_ = false;
    MeshExportReport io_report_;  ///< Of the request that is done.
    std::optional<std::string> fault_;
    bool fault_is_of_frame_ = false;
    bool fault_is_ours_ = false;  ///< And not the user's: its traces are of interest.
};

}  // namespace pxpl5::host
