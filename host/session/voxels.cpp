#include "host/session/voxels.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "host/base/error.hpp"
#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

std::size_t slice_bytes(const schema::VoxelBox& box, const Volume& volume) {
    return std::size_t{box.nx()} * box.ny() * size_bytes(volume.type);
}

/// Collects the slices of a box. Each must come once, and from the GP that answers for it.
class BoxGather {
  public:
    BoxGather(const schema::VoxelBox& box, const Volume& volume,
              const std::vector<bus::NodeId>& gps)
        : box_(box),
          slice_bytes_(slice_bytes(box, volume)),
          sets_{volume.nz, volume.slabs_per_set, static_cast<int>(gps.size())},
          gps_(gps),
          is_there_(box.nz()),
          values_(slice_bytes_ * box.nz()) {}

    void add(bus::NodeId from, const schema::VoxelValues& part) {
        const std::size_t count = part.slices()->size();
        if (part.values()->size() != count * slice_bytes_) {
            refuse(fmt::format("node {} sent {} bytes for {} slices of {} bytes", from,
                               part.values()->size(), count, slice_bytes_));
        }
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t z = part.slices()->Get(static_cast<flatbuffers::uoffset_t>(i));
            if (z < box_.z() || z - box_.z() >= box_.nz()) {
                refuse(fmt::format("node {} sent slice {}, but {} slices from {} on were requested",
                                   from, z, box_.nz(), box_.z()));
            }
            const bus::NodeId owner =
                gps_[static_cast<std::size_t>(sets_.recorder(static_cast<int>(z)))];
            if (owner != from) {
                refuse(fmt::format("slice {} came from node {}, but node {} answers for it", z,
                                   from, owner));
            }
            is_there_[z - box_.z()] = 1;
            std::memcpy(values_.data() + slice_bytes_ * (z - box_.z()),
                        part.values()->data() + slice_bytes_ * i, slice_bytes_);
        }
    }

    std::vector<std::byte> finish() {
        const auto missing = std::ranges::find(is_there_, 0);
        if (missing != is_there_.end()) {
            refuse(fmt::format("slice {} is missing", box_.z() + (missing - is_there_.begin())));
        }
        return std::move(values_);
    }

  private:
    [[noreturn]] static void refuse(const std::string& reason) {
        throw RequestError(ExitCode::failed, "values of voxels from the GPs: " + reason);
    }

    schema::VoxelBox box_;
    std::size_t slice_bytes_;
    SlabSets sets_;
    const std::vector<bus::NodeId>& gps_;
    std::vector<char> is_there_;
    std::vector<std::byte> values_;
};

std::uint32_t unsigned_of(int number) {
    return static_cast<std::uint32_t>(number);
}

}  // namespace

std::vector<std::byte> Voxels::fetch(const schema::VoxelBox& box) {
    const Volume& volume = volumes_.volume();
    schema::FetchVoxelsT request;
    request.volume = volumes_.id();
    request.box = std::make_unique<schema::VoxelBox>(box);
    BoxGather gather(box, volume, conversation_.gps());
    conversation_.ask_cancelable(
        "values of voxels", bus::pack(request),
        [id = volumes_.id()](const bus::Message& message) {
            const auto* part = message.as<schema::VoxelValues>();
            return part != nullptr && part->volume() == id;
        },
        [&gather](const bus::Message& message) {
            gather.add(message.source(), *message.as<schema::VoxelValues>());
        });
    return gather.finish();
}

Slice Voxels::slice(int axis, int index) {
    const Volume& volume = volumes_.volume();
    if (!volume.reduced) {
        return slice_of(volume, axis, index);
    }
    std::array<std::uint32_t, 3> first{},
        size = {unsigned_of(volume.nx), unsigned_of(volume.ny), unsigned_of(volume.nz)};
    first.at(static_cast<std::size_t>(axis)) = unsigned_of(index);
    size.at(static_cast<std::size_t>(axis)) = 1;
    return slice_of_plane(volume, axis,
                          fetch({first[0], first[1], first[2], size[0], size[1], size[2]}));
}

Slab Voxels::slab(int axis, int index, const SlabWish& wish) {
    Slab slab{{}, {}, slab_range(volumes_.volume(), axis, index, wish.thickness_mm)};
    SlabGather gather(wish.kind);
    for (int i = slab.range.first; i <= slab.range.last; ++i) {
        Slice each = slice(axis, i);
        gather.add(each);
        if (i == index) {
            slab.middle = std::move(each);
        }
    }
    slab.values = gather.finish();
    return slab;
}

void Voxels::add_values(Pick& pick) {
    if (!volumes_.has_volume() || !volumes_.volume().reduced) {
        return;
    }
    const Volume& volume = volumes_.volume();
    const glm::ivec3 first = cell_around(pick, volume);
    Volume cell;
    cell.nx = cell.ny = cell.nz = 2;
    cell.type = volume.type;
    cell.values =
        fetch({unsigned_of(first.x), unsigned_of(first.y), unsigned_of(first.z), 2, 2, 2});
    set_values(pick, volume, cell);
}

}  // namespace pxpl5::host
