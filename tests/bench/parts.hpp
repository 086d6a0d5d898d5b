// One GP, one Renderer and one frame buffer without a ring, to measure each alone.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "gp_firmware/node/node.hpp"
#include "host/frame_buffer/node.hpp"
#include "host/phantom/phantom.hpp"
#include "host/scene/scene.hpp"
#include "renderer_firmware/node.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::bench {

inline constexpr bus::NodeId gp_id = 1, renderer_id = 2, frame_buffer_id = 3;

/// Keeps what a node sends.
class Wire final : public bus::Outbox {
  public:
    using bus::Outbox::send;
    void send(bus::NodeId, bus::Payload payload) override { sent.push_back(std::move(payload)); }
    /// The first sent message of this kind. Throws std::logic_error if none exists.
    const bus::Payload& first(bus::Body kind) const;

    std::vector<bus::Payload> sent;
};

/// A message's bytes in a receiver's memory. The frame number can be changed.
class Held {
  public:
    explicit Held(const bus::Payload& payload);
    /// Supports BeginFrame, RegionPrograms and RegionPixels.
    void set_frame(std::uint32_t frame);
    /// The message at node `to`. Verifies the bytes, as a link does with every message.
    bus::Message message(bus::NodeId to) const;
    std::size_t size_bytes() const { return size_bytes_; }

  private:
    bus::Body kind_;
    std::size_t size_bytes_;
    std::shared_ptr<std::vector<std::uint64_t>> words_;
};

/// A built-in volume's surface on its way to a picture.
class Parts {
  public:
    Parts(std::string_view phantom, host::Size size);

    /// Extracts the surface again. Returns its number of triangles.
    std::uint32_t extract();
    /// The GP draws view `frame`, counted from 1; BeginFrame and RegionPrograms are then in
    /// gp_wire.
    void draw(std::uint32_t frame);
    /// Works until the node is idle.
    template <class Node>
    static void work(Node& node, Wire& wire) {
        while (node.work(wire)) {
        }
    }

    Wire gp_wire, renderer_wire, frame_buffer_wire;
    gp::GpNode gp;
    renderer::RendererNode renderer;
    host::FrameBufferNode frame_buffer;

  private:
    void introduce();
    void load();

    host::Volume volume_;
    host::Scene scene_;
};

}  // namespace pxpl5::bench
