#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "gp_firmware/volume/share.hpp"
#include "host/base/error.hpp"
#include "host/session/transfer/volume_transfer.hpp"
#include "ringbus/message.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = pxpl5::bus::schema;

namespace {

Volume numbered_volume(int nx, int ny, int nz) {
    Volume volume;
    volume.name = "numbered";
    volume.nx = nx;
    volume.ny = ny;
    volume.nz = nz;
    volume.type = Scalar::uint8;
    volume.voxel_to_patient[3] = {4, 5, 6, 1};
    volume.findings = {{FindingKind::missing_slices, "a slice is missing"}};
    volume.modality = "PT";
    volume.unit = "Bq/ml";
    volume.windows = {{"whole body", 10'000, 5'000}, {"brain", 40'000, 20'000}};
    volume.suv_per_value = 0.000'25;
    volume.slabs_per_set = 3;
    for (int i = 0; i < nx * ny * nz; ++i) {
        volume.values.push_back(static_cast<std::byte>(i * 7));
    }
    return volume;
}

const schema::Slices* slices_of(const pxpl5::bus::Payload& payload) {
    return schema::GetMessage(payload.bytes().data())->body_as_Slices();
}

}  // namespace

TEST_SUITE("host/volume_transfer") {
    TEST_CASE("each GP gets exactly the slices of its slabs and their neighbors") {
        Volume volume;
        for (const int slice_count : {2, 3, 4, 5, 56}) {
            for (const int gp_count : {1, 2, 3, 36, 64}) {
                for (const int slabs_per_set : {1, 2, 3, 100}) {
                    for (int gp = 0; gp < gp_count; ++gp) {
                        std::set<int> wanted;
                        for (int slab = 0; slab < slice_count - 1; ++slab) {
                            const bool owns = slab / slabs_per_set % gp_count == gp;
                            for (int z = slab - 1; owns && z <= slab + 2; ++z) {
                                if (z >= 0 && z < slice_count) {
                                    wanted.insert(z);
                                }
                            }
                        }
                        volume.nz = slice_count;
                        volume.slabs_per_set = slabs_per_set;
                        CHECK(slices_for_gp(volume, gp, gp_count) ==
                              std::vector<int>(wanted.begin(), wanted.end()));
                    }
                }
            }
        }
    }

    TEST_CASE("host and GPs go by the same rule, for shares and for the size of sets") {
        for (const int nz : {2, 7, 60, 300, 4096}) {
            Volume volume;
            volume.nx = volume.ny = 512;
            volume.nz = nz;
            for (const int gp_count : {1, 2, 5, 36, 64}) {
                volume.slabs_per_set = slabs_per_set_for(volume, gp_count);
                pxpl5::gp::VolumeShape shape;
                shape.nx = shape.ny = 512;
                shape.nz = nz;
                shape.slabs_per_set = volume.slabs_per_set;
                for (int gp = 0; gp < gp_count; ++gp) {
                    CHECK(slices_for_gp(volume, gp, gp_count) ==
                          pxpl5::gp::slices_needed(shape, {gp, gp_count}));
                }
                for (const int other : {1, 2, 3, 17, 64}) {
                    CHECK(pxpl5::gp::slabs_per_set_with(shape, other) ==
                          slabs_per_set_for(volume, other));
                }
            }
        }
    }

    TEST_CASE("a volume that fits easily has sets of one slab, a large one has larger sets") {
        Volume volume;
        volume.nx = volume.ny = 512;
        volume.nz = 64;  // 32 MiB.
        CHECK(slabs_per_set_for(volume, 2) == 1);
        volume.nz = 65;
        CHECK(slabs_per_set_for(volume, 2) == 16);  // 64 slabs in 4 sets.
        CHECK(slabs_per_set_for(volume, 64) == 2);
        volume.nz = 300;
        CHECK(slabs_per_set_for(volume, 2) == 32);
        CHECK(slabs_per_set_for(volume, 16) == 10);  // 299 slabs in 30 sets.
    }

    TEST_CASE("a volume sent whole arrives as it was") {
        const Volume volume = numbered_volume(5, 3, 9);
        VolumeReceiver receiver;
        const auto header = volume_header(volume, 3);
        receiver.begin(*schema::GetMessage(header.bytes().data())->body_as_VolumeHeader());
        for (const SliceBatch& batch : batches_for_gp(volume, 0, 1)) {
            receiver.add(*slices_of(slices_message(volume, 3, batch.first, batch.count)));
            CHECK(receiver.slices_there() == batch.end());
        }
        const Volume arrived = receiver.finish();
        CHECK(arrived.values == volume.values);
        CHECK(arrived.voxel_to_patient == volume.voxel_to_patient);
        CHECK(arrived.findings == volume.findings);
        CHECK(arrived.modality == volume.modality);
        CHECK(arrived.unit == volume.unit);
        CHECK(arrived.windows == volume.windows);
        CHECK(arrived.suv_per_value == volume.suv_per_value);
        CHECK(arrived.slabs_per_set == volume.slabs_per_set);
        CHECK(arrived.slice_places == volume.slice_places);
        CHECK(arrived.gap_slabs == volume.gap_slabs);
        CHECK(arrived.nx == 5);
        CHECK(arrived.nz == 9);
    }

    TEST_CASE("an arrived volume has its digest, and a header says digest and source") {
        Volume volume = numbered_volume(2, 1, 3);
        const std::string text = "foobar";  // One slice a message, six bytes in all.
        std::memcpy(volume.values.data(), text.data(), text.size());
        VolumeReceiver receiver;
        const auto header = volume_header(volume, 3);
        receiver.begin(*schema::GetMessage(header.bytes().data())->body_as_VolumeHeader());
        for (int z = 0; z < 3; ++z) {
            receiver.add(*slices_of(slices_message(volume, 3, z, 1)));
        }
        Volume arrived = receiver.finish();
        CHECK(arrived.digest == 0x85944171f73967e8);  // As published with FNV-1a.
        arrived.source = "/data/foobar.nrrd";
        const auto told = volume_header(arrived, 4);
        const auto& said = *schema::GetMessage(told.bytes().data())->body_as_VolumeHeader();
        CHECK(said.digest() == 0x85944171f73967e8);
        CHECK(said.source()->str() == "/data/foobar.nrrd");
    }

    TEST_CASE("a GP is sent its slices in order, its own apart from those that others own too") {
        for (const int nz : {2, 3, 5, 20}) {
            for (const int gp_count : {1, 2, 3, 5, 36}) {
                for (const int slabs_per_set : {1, 3}) {
                    Volume volume = numbered_volume(2, 2, nz);
                    volume.slabs_per_set = slabs_per_set;
                    for (int gp = 0; gp < gp_count; ++gp) {
                        const auto is_own = [&](int z) {
                            return std::min(z, nz - 2) / slabs_per_set % gp_count == gp;
                        };
                        std::vector<int> sent;
                        for (const SliceBatch& batch : batches_for_gp(volume, gp, gp_count)) {
                            for (int z = batch.first; z < batch.end(); ++z) {
                                sent.push_back(z);
                                CHECK(is_own(z) == is_own(batch.first));
                            }
                        }
                        CHECK(sent == slices_for_gp(volume, gp, gp_count));
                    }
                }
            }
        }
    }

    TEST_CASE("slices that follow each other share a message, up to a few megabytes") {
        Volume volume;
        volume.nx = volume.ny = 512;  // Half a MiB each.
        volume.nz = 20;
        volume.slabs_per_set = 100;
        CHECK(batches_for_gp(volume, 0, 2) == std::vector<SliceBatch>{{0, 8}, {8, 8}, {16, 4}});
        volume.slabs_per_set = 9;  // GP 1 owns slices 9 .. 17, and needs 8, 18, 19 too.
        CHECK(batches_for_gp(volume, 1, 2) ==
              std::vector<SliceBatch>{{8, 1}, {9, 2}, {11, 6}, {17, 1}, {18, 2}});
    }

    TEST_CASE("a batch is packed once, and all GPs that need it get the same bytes") {
        Volume volume = numbered_volume(2, 2, 30);
        for (const int slabs_per_set : {1, 3, 4, 9}) {
            volume.slabs_per_set = slabs_per_set;
            for (const int gp_count : {1, 2, 3, 5}) {
                VolumeDistribution distribution(volume, 5, gp_count);
                std::map<std::uint32_t, const std::uint8_t*> bytes;
                std::vector<pxpl5::bus::Payload> alive;
                const VolumeDistribution::Outlet outlet{
                    [](std::size_t) { return true; },
                    [&](std::size_t, const pxpl5::bus::Payload& payload) {
                        if (const auto* slices = slices_of(payload)) {
                            const auto* first = payload.bytes().data();
                            CHECK(bytes.emplace(slices->first_slice(), first).first->second ==
                                  first);
                            alive.push_back(payload);
                        }
                    },
                    nullptr};
                for (int slices_there = 0; slices_there <= volume.nz; slices_there += 6) {
                    distribution.send_more(volume, slices_there, outlet);
                }
                CHECK(bytes.size() == slice_batches(volume, gp_count).size());
                CHECK(distribution.sent() == distribution.total());
            }
        }
    }

    TEST_CASE("slices go on as they come, and only where they are taken") {
        const Volume volume = [] {
            Volume v = numbered_volume(2, 2, 9);
            v.slabs_per_set = 3;  // GP 0: slabs 0-2 and 6-7; GP 1: slabs 3-5.
            return v;
        }();
        VolumeDistribution distribution(volume, 5, 2);
        std::vector<std::string> sent;
        std::set<std::size_t> full;
        const VolumeDistribution::Outlet outlet{
            [&](std::size_t gp) { return !full.contains(gp); },
            [&](std::size_t gp, const pxpl5::bus::Payload& payload) {
                const auto* s = slices_of(payload);
                sent.push_back(
                    s == nullptr ? fmt::format("{} end", gp)
                                 : fmt::format("{} {}+{}", gp, s->first_slice(), s->slice_count()));
            },
            nullptr};
        const auto sends = [&](int slices_there) {
            sent.clear();
            distribution.send_more(volume, slices_there, outlet);
            return sent;
        };
        using Texts = std::vector<std::string>;
        CHECK(sends(1) == Texts{});
        CHECK(sends(4) == Texts{"0 0+2", "0 2+1", "1 2+1"});
        full = {1};
        CHECK(sends(8) == Texts{"0 3+3", "0 6+2"});
        CHECK(distribution.sent() == 5);
        full = {};
        CHECK(sends(8) == Texts{"1 3+3", "1 6+2", "1 end"});
        CHECK(sends(8) == Texts{});
        CHECK(sends(9) == Texts{"0 8+1", "0 end"});
        CHECK(sends(9) == Texts{});
        CHECK(distribution.sent() == distribution.total());
    }

    TEST_CASE("missing slices and slices out of order are refused with both numbers") {
        const Volume volume = numbered_volume(4, 4, 4);
        VolumeReceiver receiver;
        const auto header = volume_header(volume, 1);
        receiver.begin(*schema::GetMessage(header.bytes().data())->body_as_VolumeHeader());
        const auto batch = slices_message(volume, 1, 2, 1);
        CHECK_THROWS_AS(receiver.add(*slices_of(batch)), RequestError);
        CHECK_THROWS_WITH_AS(receiver.finish(), "numbered: 0 of 4 slices arrived", RequestError);
    }
}
