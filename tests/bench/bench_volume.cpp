// Writes a volume of any size for measurements: a built-in volume, resampled, with seeded noise.
//
// usage: bench_volume phantom:NAME NX NY NZ NOISE SEED FILE.mhd
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/phantom/noise.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;

namespace {

constexpr int max_side = 1024;  ///< 2 GiB of voxels.
constexpr int max_noise = 1000;

struct Wish {
    std::string phantom;
    glm::ivec3 dims{0};
    int noise = 0;  ///< Deviation, in the volume's unit.
    std::uint32_t seed = 0;
    std::string path;
};

int whole(const char* name, const std::string& text, int least, int most) {
    std::size_t used = 0;
    const int value = std::stoi(text, &used);
    if (used != text.size() || value < least || value > most) {
        throw std::invalid_argument(
            fmt::format("{}: {} is not a whole number in {} .. {}", name, text, least, most));
    }
    return value;
}

/// How far voxel `at` of `count` lies in the original's `original_count`, so that ends meet.
double place(int at, int count, int original_count) {
    return at * static_cast<double>(original_count - 1) / (count - 1);
}

/// Values between voxels: weighted by distance along each axis.
class Sampler {
  public:
    explicit Sampler(const test::Probe& probe) : probe_(probe) {}

    double at(double x, double y, double z) const {
        const int k = std::min(static_cast<int>(z), probe_.volume.nz - 2);
        return glm::mix(at_slice(x, y, k), at_slice(x, y, k + 1), z - k);
    }

  private:
    double at_slice(double x, double y, int z) const {
        const int i = std::min(static_cast<int>(x), probe_.volume.nx - 2);
        const int j = std::min(static_cast<int>(y), probe_.volume.ny - 2);
        const double u = x - i, v = y - j;
        return glm::mix(glm::mix(voxel(i, j, z), voxel(i + 1, j, z), u),
                        glm::mix(voxel(i, j + 1, z), voxel(i + 1, j + 1, z), u), v);
    }
    double voxel(int x, int y, int z) const {
        const auto row = static_cast<std::size_t>(z) * static_cast<std::size_t>(probe_.volume.ny) +
                         static_cast<std::size_t>(y);
        return probe_
            .voxels[row * static_cast<std::size_t>(probe_.volume.nx) + static_cast<std::size_t>(x)];
    }

    const test::Probe& probe_;
};

std::vector<std::int16_t> sampled(const test::Probe& probe, const Wish& wish) {
    const Sampler sampler(probe);
    const host::Volume& from = probe.volume;
    std::vector<std::int16_t> values;
    values.reserve(static_cast<std::size_t>(wish.dims.x) * static_cast<std::size_t>(wish.dims.y) *
                   static_cast<std::size_t>(wish.dims.z));
    for (int z = 0; z < wish.dims.z; ++z) {
        for (int y = 0; y < wish.dims.y; ++y) {
            for (int x = 0; x < wish.dims.x; ++x) {
                const double value =
                    sampler.at(place(x, wish.dims.x, from.nx), place(y, wish.dims.y, from.ny),
                               place(z, wish.dims.z, from.nz));
                const auto key =
                    static_cast<std::uint32_t>(values.size()) + wish.seed * 0x9e3779b9U;
                const double noisy = value + wish.noise * double{host::phantom::grain(key)};
                values.push_back(
                    static_cast<std::int16_t>(std::lround(std::clamp(noisy, -32768.0, 32767.0))));
            }
        }
    }
    return values;
}

/// MetaImage: a text beside the voxels. The patient's size stays that of the original.
void write(const test::Probe& probe, const Wish& wish) {
    const std::vector<std::int16_t> values = sampled(probe, wish);
    const std::string raw = wish.path.substr(0, wish.path.rfind('.')) + ".raw";
    std::ofstream voxels(raw, std::ios::binary);
    voxels.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(values.size() * sizeof(std::int16_t)));
    const host::Volume& from = probe.volume;
    const auto spacing = [&](int axis, int count, int original_count) {
        return glm::length(glm::dvec3(from.voxel_to_patient[axis])) * (original_count - 1) /
               (count - 1);
    };
    std::ofstream text(wish.path);
    text << fmt::format(
        "ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementSpacing = {} {} {}\n"
        "ElementType = MET_SHORT\nElementByteOrderMSB = False\nElementDataFile = {}\n",
        wish.dims.x, wish.dims.y, wish.dims.z, spacing(0, wish.dims.x, from.nx),
        spacing(1, wish.dims.y, from.ny), spacing(2, wish.dims.z, from.nz),
        raw.substr(raw.rfind('/') + 1));
    voxels.close();
    text.close();
    if (!voxels || !text) {
        throw std::runtime_error(fmt::format("{} and {} cannot be written", wish.path, raw));
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 8) {
        fmt::print(stderr, "usage: bench_volume phantom:NAME NX NY NZ NOISE SEED FILE.mhd\n");
        return 64;
    }
    try {
        Wish wish{argv[1], {}, whole("NOISE", argv[5], 0, max_noise), 0, argv[7]};
        wish.seed = static_cast<std::uint32_t>(whole("SEED", argv[6], 0, 1 << 30));
        for (int axis = 0; axis < 3; ++axis) {
            wish.dims[axis] = whole("NX NY NZ", argv[2 + axis], 2, max_side);
        }
        write(test::Probe(wish.phantom), wish);
    } catch (const std::exception& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return 65;
    }
    return 0;
}
