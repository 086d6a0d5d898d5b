#include "host/timing/replay/build_model.hpp"

#include <cmath>

namespace pxpl5::host::timing {

namespace {
constexpr std::uint64_t set_surface_words = 8, built_words = 8, built_slab_words = 8;
}

std::uint64_t edges_of(const VolumeWork& volume, std::uint32_t slab) {
    const std::uint64_t nx = volume.nx, ny = volume.ny;
    const auto of_slice = [&](std::uint32_t z) {
        return volume.runs[z] - ny + nx * (ny - 1);  // Between runs along x; all along y.
    };
    return of_slice(slab) + nx * ny + of_slice(slab + 1);
}

void BuildModel::start(const BuildWork& build, const VolumeWork& volume, Callback<> done) {
    const std::size_t gps = hardware_.gps.size();
    const Machine& machine = hardware_.machine;
    done_ = done;
    gps_due_ = gps;
    duties_.assign(gps, {});
    std::vector<std::uint64_t> edges(gps);
    for (std::uint32_t slab = 0; slab + 1 < volume.nz; ++slab) {
        edges[slab % gps] += edges_of(volume, slab);
        ++duties_[slab % gps].slabs;
    }
    for (const SlabWork& slab : build.slabs) {
        duties_[slab.slab % gps].triangles += slab.triangles;
    }
    for (std::size_t gp = 0; gp < gps; ++gp) {
        Duty& duty = duties_[gp];
        duty.time = hardware_.costs.gp(static_cast<double>(edges[gp]) * machine.gp_edge_cycles +
                                       static_cast<double>(duty.triangles) *
                                           machine.gp_build_triangle_cycles);
        for (std::size_t from = 0; from < gps; ++from) {
            duty.messages_due += from != gp && given(from, gp) > 0 ? 1 : 0;
        }
    }
    for (std::size_t gp = 0; gp < gps; ++gp) {
        hardware_.mail.send(
            hardware_.places.host(), hardware_.places.gp(gp), set_surface_words, [this, gp] {
                hardware_.gps[gp].work(duties_[gp].time, [this, gp] { extracted(gp); });
            });
    }
}

std::uint64_t BuildModel::given(std::size_t from, std::size_t to) const {
    const std::size_t gps = duties_.size();
    if (hardware_.machine.share == Sharing::own) {
        return from == to ? duties_[from].triangles : 0;
    }
    const std::size_t turn = (to + gps - from) % gps;  // What is left over goes round from `from`.
    const std::uint64_t triangles = duties_[from].triangles;
    return triangles / gps + (turn < triangles % gps ? 1 : 0);
}

void BuildModel::extracted(std::size_t gp) {
    const std::size_t gps = duties_.size();
    for (std::size_t turn = 1; turn < gps; ++turn) {
        const std::size_t to = (gp + turn) % gps;
        const std::uint64_t triangles = given(gp, to);
        if (triangles > 0) {
            const double words = std::ceil(static_cast<double>(triangles) *
                                           hardware_.machine.gp_list_triangle_words);
            hardware_.mail.send(hardware_.places.gp(gp), hardware_.places.gp(to),
                                words < 1 ? 1 : static_cast<std::uint64_t>(words),
                                [this, to] { received(to); });
        }
    }
    duties_[gp].extracted = true;
    answer_if_done(gp);
}

void BuildModel::received(std::size_t gp) {
    --duties_[gp].messages_due;
    answer_if_done(gp);
}

void BuildModel::answer_if_done(std::size_t gp) {
    if (duties_[gp].extracted && duties_[gp].messages_due == 0) {
        hardware_.mail.send(hardware_.places.gp(gp), hardware_.places.host(),
                            built_words + built_slab_words * duties_[gp].slabs,
                            [this] { built(); });
    }
}

void BuildModel::built() {
    if (--gps_due_ == 0) {
        Callback<> done = done_;
        done();
    }
}

}  // namespace pxpl5::host::timing
