// What a session does with frames: asks for them, two in flight, and takes them.
#include <cassert>
#include <utility>

#include "host/error.hpp"
#include "host/scene_transfer.hpp"
#include "host/session.hpp"
#include "host/stopwatch.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

}  // namespace

Stage Session::stage() const {
    if (archive_) {
        return {archive_->surfaces, phigs::scene_subject(), glm::dmat4(1.0), false};
    }
    const Volume& held = volume();
    const glm::dvec3 last(held.nx - 1, held.ny - 1, last_place(held));
    return {scene.surfaces, subject_of(last, held.voxel_to_patient), held.voxel_to_patient,
            !held.gap_slabs.empty()};
}

void Session::submit_frame(ReadBack read_back) {
    const bus::Payload request =
        frame_request(scene, stage(), next_frame_, region_costs_, read_back);
    pending_.push_back({next_frame_++, now_ns()});
    machine_.send(machine_.gp_ids().front(), request);
}

void Session::on_frame_done(const schema::FrameDone& done) {
    if (pending_.empty() || done.frame() != pending_.front().frame || done.pixels() == nullptr) {
        return;  // A frame that was given up after a fault.
    }
    last_frame_ = {done.frame(), static_cast<std::int64_t>(done.instructions()), 0,
                   ms_since(pending_.front().started_ns)};
    region_costs_.assign(done.region_cycles()->begin(), done.region_cycles()->end());
    for (const std::uint64_t cycles : region_costs_) {
        last_frame_.renderer_cycles += static_cast<std::int64_t>(cycles);
    }
    Picture picture{static_cast<int>(done.width()),
                    static_cast<int>(done.height() * done.views()),
                    {done.pixels()->begin(), done.pixels()->end()}};
    if (done.depths() != nullptr) {
        depths_.assign(done.depths()->begin(), done.depths()->end());
    }
    finished_.push_back(std::move(picture));
    pending_.pop_front();
}

void Session::give_up_frames() {
    pending_.clear();
    finished_.clear();
}

Picture Session::take_frame() {
    try {
        wait("frame", [this] { return !finished_.empty() || fault_.has_value(); });
    } catch (...) {
        give_up_frames();  // What still comes of them is not what is asked for next.
        throw;
    }
    Picture picture = std::move(finished_.front());
    finished_.pop_front();
    return picture;
}

Picture Session::draw() {
    submit_frame();
    return take_frame();
}

std::optional<Session::Picked> Session::pick(int x, int y) {
    const Volume& held = volume();  // Throws for archives.
    depths_.clear();
    submit_frame(ReadBack::pixels_and_depths);
    const Picture picture = take_frame();
    const Stage shown = stage();
    const std::optional<Pick> found =
        host::pick({matrices_of(scene, shown), picture.width, picture.height, depths_}, x, y, held);
    if (!found) {
        return std::nullopt;
    }
    const std::vector<DrawnSurface> drawn = drawn_surfaces(scene, shown);
    return Picked{*found, drawn.at(static_cast<std::size_t>(found->surface)).surface->name};
}

OrbitReport Session::orbit(int frames, const TakeFrame& take, int in_flight) {
    assert(in_flight >= 1 && in_flight <= max_frames_in_flight);
    // Whatever `take` throws, the camera is where it was and no frame of the orbit is left over.
    struct Restore {
        Session& session;
        const Camera before = session.scene.camera;
        ~Restore() {
            session.scene.camera = before;
            session.give_up_frames();
        }
    };
    const Restore restore{*this};
    const auto camera_of = [&](int index) {
        Camera camera = restore.before;
        camera.angles.azimuth_deg += 360.0 * index / frames;
        return camera;
    };
    std::vector<double> latencies_ms;
    const std::int64_t start_ns = now_ns();
    for (int submitted = 0, taken = 0; taken < frames; ++taken) {
        for (; submitted < frames && submitted - taken < in_flight; ++submitted) {
            scene.camera = camera_of(submitted);
            submit_frame();
        }
        const Picture picture = take_frame();
        latencies_ms.push_back(last_frame_.elapsed_ms);
        take(taken, picture, camera_of(taken));
    }
    return {frames, ms_since(start_ns), spread_of(std::move(latencies_ms))};
}

}  // namespace pxpl5::host
