// What a session does with frames: asks for them, two in flight, and takes them.
#include <algorithm>
#include <array>
#include <cassert>
#include <span>
#include <utility>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/scene_transfer.hpp"
#include "host/session/session.hpp"
#include "isa/contract/sample_sums.hpp"
#include "ringbus/rules/regions.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Adds to what is told of a picture what one of its passes took, but for the time. All passes
/// share the regions out alike.
void add_pass(const schema::FrameDone& done, FrameReport& report) {
    const auto regions_across = [](std::uint32_t px) {
        return static_cast<int>(region_count(px, 1, 1));
    };
    report.frame = done.frame();
    report.instructions += static_cast<std::int64_t>(done.instructions());
    report.region_columns = regions_across(done.width());
    report.region_rows = regions_across(done.height()) * done.views();
    report.region_renderers.assign(done.region_renderers()->begin(),
                                   done.region_renderers()->end());
    report.region_cycles.resize(done.region_cycles()->size());
    for (flatbuffers::uoffset_t region = 0; region < done.region_cycles()->size(); ++region) {
        const std::uint64_t cycles = done.region_cycles()->Get(region);
        report.region_cycles[region] += cycles;
        report.renderer_cycles += static_cast<std::int64_t>(cycles);
    }
}

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

void Session::submit_frame(ReadBack read_back, Pass pass, bool counts) {
    if (pass.sample == 0) {
        picture_costs_ = region_costs_;
        picture_started_ns_ = now_ns();
    }
    const bus::Payload request =
        frame_request(scene, stage(), next_frame_, picture_costs_, read_back, pass, counts);
    pending_.push_back({next_frame_++, picture_started_ns_, pass});
    machine_.send(machine_.gp_ids().front(), request);
}

void Session::on_frame_done(const schema::FrameDone& done) {
    if (pending_.empty() || done.frame() != pending_.front().frame) {
        return;  // A frame that was given up after a fault.
    }
    activity_.count_frame();
    const PendingFrame& pending = pending_.front();
    if (pending.pass.sample == 0) {
        last_frame_ = {};
    }
    add_pass(done, last_frame_);
    if (const auto counted = std::ranges::find(counted_, done.frame(), &CountedFrame::frame);
        counted != counted_.end()) {
        counted->views = done.views();
        counted->region_renderers.assign(done.region_renderers()->begin(),
                                         done.region_renderers()->end());
    }
    last_frame_.elapsed_ms = ms_since(pending.started_ns);
    region_costs_.assign(done.region_cycles()->begin(), done.region_cycles()->end());
    if (done.pixels() != nullptr) {
        finished_.push_back({static_cast<int>(done.width()),
                             static_cast<int>(done.height() * done.views()),
                             {done.pixels()->begin(), done.pixels()->end()}});
    }
    if (done.depths() != nullptr) {
        depths_.assign(done.depths()->begin(), done.depths()->end());
    }
    pending_.pop_front();
}

void Session::give_up_frames() {
    pending_.clear();
    finished_.clear();
}

void Session::wait_for_frames(std::size_t count) {
    try {
        wait("frame", [&] { return pending_.size() <= count || fault_.has_value(); });
    } catch (...) {
        give_up_frames();  // What still comes of them is not what is asked for next.
        throw;
    }
}

Picture Session::take_frame() {
    if (finished_.empty()) {
        wait_for_frames(pending_.size() - 1);
    }
    Picture picture = std::move(finished_.front());
    finished_.pop_front();
    return picture;
}

Picture Session::draw() {
    return *draw_samples(scene.samples);
}

std::optional<Picture> Session::draw_samples(int samples, const std::function<bool()>& go_on) {
    for (Pass pass{0, samples}; pass.sample < samples; ++pass.sample) {
        wait_for_frames(max_frames_in_flight - 1);
        if (go_on && !go_on()) {
            wait_for_frames(0);  // The machine holds two frames, not more.
            return std::nullopt;
        }
        submit_frame(ReadBack::pixels, pass);
    }
    wait_for_frames(0);
    return take_frame();
}

int Session::max_samples() const {
    const auto px = [](int length) { return static_cast<std::uint32_t>(length); };
    const std::size_t regions = region_count(px(scene.size.width), px(scene.size.height), 1);
    int most = 1;
    for (const int samples : sample_counts) {
        const std::size_t each = isa::max_summed_regions(px(samples));
        if ((regions + renderer_count() - 1) / renderer_count() <= each) {
            most = samples;
        }
    }
    return most;
}

std::uint64_t Session::frame_key() const {
    Digest digest;
    const bus::Payload request = frame_request(scene, stage(), 0, {});
    digest.add(std::as_bytes(request.bytes()));
    const std::array<std::uint64_t, 2> told = {volume_id_, told_};
    digest.add(std::as_bytes(std::span(told)));
    return digest.value();
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
        // Of several samples a picture's own passes are two at a time.
        const bool is_single = scene.samples == 1;
        for (; is_single && submitted < frames && submitted - taken < in_flight; ++submitted) {
            scene.camera = camera_of(submitted);
            submit_frame();
        }
        if (!is_single) {
            scene.camera = camera_of(taken);
        }
        const Picture picture = is_single ? take_frame() : draw();
        latencies_ms.push_back(last_frame_.elapsed_ms);
        take(taken, picture, camera_of(taken));
    }
    return {frames, ms_since(start_ns), spread_of(std::move(latencies_ms))};
}

}  // namespace pxpl5::host
