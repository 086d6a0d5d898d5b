#include "gp_firmware/node/copied_slices.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <memory>
#include <vector>

using namespace pxpl5;
namespace schema = bus::schema;

namespace {

/// `payload` as node `to` receives it.
bus::Message received(const bus::Payload& payload, bus::NodeId to) {
    const auto bytes = payload.bytes();
    const auto words = std::make_shared<std::vector<std::uint64_t>>(bytes.size() / 8 + 1);
    std::memcpy(words->data(), bytes.data(), bytes.size());
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(payload.kind()), 0, to, 0, 0, 0,
                                bytes.size(), 0, 0, 1);
    return {header, {reinterpret_cast<const std::uint8_t*>(words->data()), bytes.size()}, words};
}

/// A host, `gps` GPs from node 1 on, and a Renderer.
bus::Payload topology(int gps) {
    schema::TopologyT body;
    for (int id = 0; id <= gps + 1; ++id) {
        auto node = std::make_unique<schema::NodeInfoT>();
        node->id = static_cast<std::uint16_t>(id);
        node->role = id == 0     ? schema::Role::host
                     : id <= gps ? schema::Role::gp
                                 : schema::Role::renderer;
        node->index = static_cast<std::uint16_t>(id == 0 || id > gps ? 0 : id - 1);
        node->endpoint = "ipc:///somewhere";
        body.nodes.push_back(std::move(node));
    }
    return bus::pack(body);
}

bus::Payload header(int nz, int slabs_per_set = 1) {
    schema::VolumeHeaderT body;
    body.name = "a volume";
    body.nx = body.ny = 2;
    body.nz = static_cast<std::uint32_t>(nz);
    body.slabs_per_set = static_cast<std::uint16_t>(slabs_per_set);
    body.voxel_to_patient = std::make_unique<schema::Matrix>();
    return bus::pack(body);
}

bus::Payload slices(int first, int count) {
    schema::SlicesT body;
    body.first_slice = static_cast<std::uint32_t>(first);
    body.slice_count = static_cast<std::uint32_t>(count);
    body.values.resize(static_cast<std::size_t>(8 * count));
    return bus::pack(body);
}

gp::CopiedSlices told(int gps, int index, int nz, int slabs_per_set = 1) {
    gp::CopiedSlices copied;
    const auto self = static_cast<bus::NodeId>(index + 1);
    CHECK(!copied(received(topology(gps), self)));
    CHECK(!copied(received(header(nz, slabs_per_set), self)));
    return copied;
}

/// How many traces hold each slice.
std::vector<int> holders_of(int nz, int gps, int slabs_per_set) {
    std::vector<int> holders(static_cast<std::size_t>(nz));
    for (int index = 0; index < gps; ++index) {
        gp::VolumeShape shape;
        shape.nx = shape.ny = 2;
        shape.nz = nz;
        shape.slabs_per_set = slabs_per_set;
        gp::CopiedSlices copied = told(gps, index, nz, slabs_per_set);
        for (const int z : gp::slices_needed(shape, {index, gps})) {
            const bool left_out =
                copied(received(slices(z, 1), static_cast<bus::NodeId>(index + 1)));
            holders[static_cast<std::size_t>(z)] += left_out ? 0 : 1;
        }
    }
    return holders;
}

}  // namespace

TEST_SUITE("gp_firmware/node/copied_slices") {
    TEST_CASE("of the GPs that are sent a slice, the trace of one holds it") {
        for (const int nz : {2, 3, 4, 5, 56}) {
            for (const int gps : {1, 2, 3, 4, 36, 64}) {
                for (const int slabs_per_set : {1, 3, 7, 4096}) {
                    CAPTURE(nz);
                    CAPTURE(gps);
                    CAPTURE(slabs_per_set);
                    CHECK(holders_of(nz, gps, slabs_per_set) ==
                          std::vector<int>(static_cast<std::size_t>(nz), 1));
                }
            }
        }
    }

    TEST_CASE("a message with a slice that no other trace holds is held whole") {
        gp::CopiedSlices copied = told(4, 1, 56);  // Owns slices 1, 5, 9 ...
        CHECK(copied(received(slices(2, 3), 2)));
        CHECK(!copied(received(slices(2, 4), 2)));
        CHECK(!copied(received(slices(0, 2), 2)));
        CHECK(!copied(received(header(8), 2)));
        CHECK(copied(received(slices(6, 1), 2)));
        CHECK(copied(received(slices(7, 1), 2)));  // The last one, with slice 6: GP 2.
    }

    TEST_CASE("a flight recorder does without slices that it could not keep all of") {
        for (const auto recording : {Recording::flight, Recording::full}) {
            for (const unsigned nx : {1024U, 4096U}) {  // 14 of 56 slices: 14 or 224 MiB.
                gp::CopiedSlices copied;
                schema::TopologyT machine;
                schema::GetMessage(topology(4).bytes().data())
                    ->body_as_Topology()
                    ->UnPackTo(&machine);
                machine.recording = recording;
                schema::VolumeHeaderT volume;
                schema::GetMessage(header(56).bytes().data())
                    ->body_as_VolumeHeader()
                    ->UnPackTo(&volume);
                volume.nx = volume.ny = nx;
                CHECK(!copied(received(bus::pack(machine), 2)));
                CHECK(!copied(received(bus::pack(volume), 2)));
                const bool does_without = recording == Recording::flight && nx == 4096;
                CHECK(copied(received(slices(5, 1), 2)) == does_without);  // Its own.
                CHECK(copied(received(slices(6, 1), 2)));                  // Another's.
            }
        }
    }

    TEST_CASE("slices that are not of the volume are recorded") {
        gp::CopiedSlices copied = told(4, 1, 8);
        CHECK(!copied(received(slices(8, 1), 2)));
        CHECK(!copied(received(slices(4000, 5), 2)));
        gp::CopiedSlices ignorant;
        CHECK(!ignorant(received(slices(0, 1), 2)));
    }
}
