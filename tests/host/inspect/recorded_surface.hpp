// A recorded frame of a surface of any volume, drawn as one asks for it.
#pragma once

#include <functional>

#include "generated/vocabulary.hpp"
#include "host/scene/camera.hpp"
#include "host/session/transfer/volume_transfer.hpp"
#include "tests/host/inspect/recorded_machine.hpp"
#include "tests/host/inspect/surface_truth.hpp"

namespace pxpl5::test {

/// A machine, recorded, that is told what to do by messages: what no command of a session does.
class RecordedSurface {
  public:
    RecordedSurface(host::Volume volume, int gps, int renderers)
        : volume_(std::move(volume)), recorded_(machine_of(gps, renderers)) {
        const std::vector<bus::NodeId>& ids = recorded_.machine.gp_ids();
        for (std::size_t g = 0; g < ids.size(); ++g) {
            const auto send = [&, g](bus::Payload p) { recorded_.machine.send(ids[g], p); };
            send(host::volume_header(volume_, 1));
            for (const host::SliceBatch& batch :
                 host::batches_for_gp(volume_, static_cast<int>(g), gps)) {
                send(host::slices_message(volume_, 1, batch.first, batch.count));
            }
            bus::schema::VolumeEndT end;
            end.volume = 1;
            send(bus::pack(end));
        }
    }

    /// Has a surface extracted, and shown in frames from now on.
    void add_surface(double isovalue) {
        surfaces_.push_back(static_cast<std::uint16_t>(surfaces_.size() + 7));
        bus::schema::SetSurfaceT set;
        set.surface = surfaces_.back();
        set.revision = 1;
        set.isovalue = isovalue;
        for (const bus::NodeId gp : recorded_.machine.gp_ids()) {
            recorded_.machine.send(gp, bus::pack(set));
        }
        // As a session does: a frame must not overtake the surface on its way to a GP.
        std::size_t built = 0;
        recorded_.machine.pump(
            [&](const bus::Message& m) { built += m.kind() == bus::Body::SurfaceBuilt ? 1 : 0; },
            [&] { return built == recorded_.machine.gp_ids().size(); });
    }

    /// Hides triangles of the first surface: those that `hide` wishes for (slab, triangle).
    void mask(const std::function<bool(std::uint32_t, std::size_t)>& hide) {
        bus::schema::FetchMeshT fetch;
        fetch.surface = surfaces_.front();
        bus::schema::MaskSurfaceT mask;
        mask.surface = surfaces_.front();
        mask.revision = 1;
        const std::vector<bus::NodeId>& gps = recorded_.machine.gp_ids();
        for (const bus::NodeId gp : gps) {
            recorded_.machine.send(gp, bus::pack(fetch));
        }
        std::size_t came = 0;
        recorded_.machine.pump(
            [&](const bus::Message& m) {
                const auto* part = m.as<bus::schema::MeshPart>();
                came += part == nullptr ? 0 : 1;
                for (std::uint32_t s = 0; part != nullptr && s < part->slabs()->size(); ++s) {
                    const auto* slab = part->slabs()->Get(s);
                    auto wire = std::make_unique<bus::schema::SlabMaskT>();
                    wire->slab = slab->slab();
                    const std::size_t triangles = slab->indices()->size() / 3;
                    wire->hidden.resize((triangles + 7) / 8);
                    for (std::size_t t = 0; t < triangles; ++t) {
                        wire->hidden[t / 8] |=
                            static_cast<std::uint8_t>((hide(slab->slab(), t) ? 1U : 0U) << t % 8);
                    }
                    mask.slabs.push_back(std::move(wire));
                }
            },
            [&] { return came == gps.size(); });
        for (const bus::NodeId gp : gps) {
            recorded_.machine.send(gp, bus::pack(mask));
        }
    }

    /// Draws width x height pixels as seen by `camera`, the frame changed by `change`.
    void draw(const host::Camera& camera, int width, int height,
              const std::function<void(bus::schema::DrawFrameT&)>& change = {}) {
        bus::schema::DrawFrameT draw;
        draw.frame = next_frame_++;
        draw.width = static_cast<std::uint32_t>(width);
        draw.height = static_cast<std::uint32_t>(height);
        const host::CameraMatrices matrices = host::camera_matrices(
            camera, host::subject_of(volume_.nx, volume_.ny, volume_.nz, volume_.voxel_to_patient),
            static_cast<double>(width) / height);
        auto view = std::make_unique<bus::schema::ViewT>();
        view->voxel_to_eye = to_wire(matrices.patient_to_eye * volume_.voxel_to_patient);
        view->projection = to_wire(matrices.projection);
        draw.views.push_back(std::move(view));
        draw.ambient = 1;
        draw.specular_power = 1;
        draw.background = std::make_unique<bus::schema::Rgb>(1, 2, 3);
        for (const std::uint16_t id : surfaces_) {
            draw.surfaces.emplace_back(id, 1U, bus::schema::Rgb(200, 150, 100), false,
                                       SlabChoice::all, full_opacity, std::uint8_t{0},
                                       std::uint8_t{0});
        }
        if (change) {
            change(draw);
        }
        bool done = false;
        recorded_.machine.send(recorded_.machine.gp_ids().front(), bus::pack(draw));
        recorded_.machine.pump(
            [&](const bus::Message& m) { done = done || m.kind() == bus::Body::FrameDone; },
            [&] { return done; });
        view_.width = static_cast<int>(draw.width);
        view_.height = static_cast<int>(draw.height);
        view_.voxel_to_clip =
            matrix_of(*draw.views.back()->projection) * matrix_of(*draw.views.back()->voxel_to_eye);
    }

    host::inspect::RecordedRun run() const { return recorded_.run(); }
    std::vector<host::inspect::NodeTrace> traces() const { return recorded_.traces.traces(); }
    const host::Volume& volume() const { return volume_; }
    const TrueView& view() const { return view_; }  ///< View of the last frame's last eye.

  private:
    static host::Topology machine_of(int gps, int renderers) {
        host::Topology topology;
        topology.gp.count = gps;
        topology.renderer.count = renderers;
        topology.frame_buffer.count = 1;
        return topology;
    }
    static std::unique_ptr<bus::schema::Matrix> to_wire(const glm::dmat4& m) {
        std::array<double, 16> values{};
        std::memcpy(values.data(), &m, sizeof values);
        return std::make_unique<bus::schema::Matrix>(flatbuffers::make_span(values));
    }
    static glm::dmat4 matrix_of(const bus::schema::Matrix& wire) {
        glm::dmat4 m;
        for (int n = 0; n < 16; ++n) {
            m[n / 4][n % 4] = wire.m()->Get(static_cast<flatbuffers::uoffset_t>(n));
        }
        return m;
    }

    host::Volume volume_;
    RecordedMachine recorded_;
    std::vector<std::uint16_t> surfaces_;  ///< Ids, in drawing order.
    TrueView view_;
    std::uint32_t next_frame_ = 0;
};

}  // namespace pxpl5::test
