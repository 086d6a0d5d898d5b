#include <doctest/doctest.h>

#include <cstring>
#include <set>

#include "host/error.hpp"
#include "host/volume_transfer.hpp"
#include "ringbus/message.hpp"

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
    volume.modality = "CT";
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
    TEST_CASE("each GP gets exactly the slices of its slabs' sets of four") {
        for (const int slice_count : {2, 3, 4, 5, 56}) {
            for (const int gp_count : {1, 2, 3, 36, 64}) {
                for (int gp = 0; gp < gp_count; ++gp) {
                    std::set<int> wanted;
                    for (int slab = 0; slab < slice_count - 1; ++slab) {
                        for (int z = slab - 1; slab % gp_count == gp && z <= slab + 2; ++z) {
                            if (z >= 0 && z < slice_count) {
                                wanted.insert(z);
                            }
                        }
                    }
                    const std::vector<int> got = slices_for_gp(slice_count, gp, gp_count);
                    CHECK(got == std::vector<int>(wanted.begin(), wanted.end()));
                }
            }
        }
    }

    TEST_CASE("a volume sent whole arrives as it was") {
        const Volume volume = numbered_volume(5, 3, 9);
        std::vector<int> all;
        for (int z = 0; z < volume.nz; ++z) {
            all.push_back(z);
        }
        VolumeReceiver receiver;
        const auto header = volume_header(volume, 3);
        receiver.begin(*schema::GetMessage(header.bytes().data())->body_as_VolumeHeader());
        for_each_slice_batch(volume, 3, all, [&](const pxpl5::bus::Payload& batch) {
            receiver.add(*slices_of(batch));
        });
        const Volume arrived = receiver.finish();
        CHECK(arrived.values == volume.values);
        CHECK(arrived.voxel_to_patient == volume.voxel_to_patient);
        CHECK(arrived.findings == volume.findings);
        CHECK(arrived.modality == volume.modality);
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
                for (int gp = 0; gp < gp_count; ++gp) {
                    std::vector<int> sent;
                    const auto take = [&](const pxpl5::bus::Payload& batch) {
                        const int first = static_cast<int>(slices_of(batch)->first_slice());
                        const int count = static_cast<int>(slices_of(batch)->slice_count());
                        const auto slab = [nz](int z) { return z == nz - 1 ? z - 1 : z; };
                        const bool is_own = slab(first) % gp_count == gp;
                        for (int z = first; z < first + count; ++z) {
                            sent.push_back(z);
                            CHECK((slab(z) % gp_count == gp) == is_own);
                        }
                    };
                    for_each_slice_batch_of_gp(numbered_volume(2, 2, nz), 1, gp, gp_count, take);
                    CHECK(sent == slices_for_gp(nz, gp, gp_count));
                }
            }
        }
    }

    TEST_CASE("consecutive slices share a message, others do not") {
        const Volume volume = numbered_volume(4, 4, 12);
        std::vector<std::pair<unsigned, unsigned>> batches;
        for_each_slice_batch(volume, 1, {0, 1, 2, 5, 6, 11}, [&](const pxpl5::bus::Payload& batch) {
            batches.emplace_back(slices_of(batch)->first_slice(), slices_of(batch)->slice_count());
        });
        CHECK(batches == std::vector<std::pair<unsigned, unsigned>>{{0, 3}, {5, 2}, {11, 1}});
    }

    TEST_CASE("missing slices and slices out of order are refused with both numbers") {
        const Volume volume = numbered_volume(4, 4, 4);
        VolumeReceiver receiver;
        const auto header = volume_header(volume, 1);
        receiver.begin(*schema::GetMessage(header.bytes().data())->body_as_VolumeHeader());
        for_each_slice_batch(volume, 1, {2}, [&](const pxpl5::bus::Payload& batch) {
            CHECK_THROWS_AS(receiver.add(*slices_of(batch)), RequestError);
        });
        CHECK_THROWS_WITH_AS(receiver.finish(), "numbered: 0 of 4 slices arrived", RequestError);
    }
}
