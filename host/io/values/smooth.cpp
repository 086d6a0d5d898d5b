// A Gaussian along the voxel axes, slice by slice: only the slices within its reach are held twice.
#include <cmath>
#include <deque>
#include <glm/geometric.hpp>

#include "host/io/values/processing.hpp"
#include "host/io/values/scalar_types.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double reach_sigmas = 4;

/// Weights from -radius to radius, not yet normalized.
std::vector<double> kernel(double sigma_voxels, int size) {
    const int radius =
        std::min(static_cast<int>(std::min(std::ceil(reach_sigmas * sigma_voxels), 1e6)), size - 1);
    std::vector<double> weights;
    for (int i = -radius; i <= radius; ++i) {
        const double distance = i / sigma_voxels;
        weights.push_back(std::exp(-0.5 * distance * distance));
    }
    return weights;
}

/// Smooths `count` values that lie `stride` apart.
void smooth_line(float* line, std::size_t count, std::size_t stride,
                 const std::vector<double>& weights, std::vector<float>& copy) {
    const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
    const auto size = static_cast<std::ptrdiff_t>(count);
    copy.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        copy[i] = line[i * stride];
    }
    for (std::ptrdiff_t i = 0; i < size; ++i) {
        if (!std::isfinite(copy[static_cast<std::size_t>(i)])) {
            continue;
        }
        double sum = 0, all = 0;
        const std::ptrdiff_t end = std::min(i + radius, size - 1);
        for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(i - radius, 0); j <= end; ++j) {
            const float value = copy[static_cast<std::size_t>(j)];
            if (std::isfinite(value)) {
                const double weight = weights[static_cast<std::size_t>(j - i + radius)];
                sum += weight * static_cast<double>(value);
                all += weight;
            }
        }
        line[static_cast<std::size_t>(i) * stride] = static_cast<float>(sum / all);
    }
}

/// Smooths across slices.
class SliceSmoother {
  public:
    SliceSmoother(double sigma_mm, Volume& volume) : volume_(volume) {
        const auto sigma_along = [&](int axis) {
            return sigma_mm / glm::length(glm::dvec3(volume.voxel_to_patient[axis]));
        };
        x_weights_ = kernel(sigma_along(0), volume.nx);
        y_weights_ = kernel(sigma_along(1), volume.ny);
        z_sigma_ = sigma_along(2);
    }

    template <typename T>
    void run() {
        for (int z = 0; z < volume_.nz; ++z) {
            while (loaded_ < volume_.nz && place(loaded_) - place(z) <= reach_sigmas * z_sigma_) {
                load<T>(loaded_++);
            }
            while (place(z) - place(first_) > reach_sigmas * z_sigma_) {
                slices_.pop_front();
                ++first_;
            }
            store<T>(z);
        }
    }

  private:
    std::size_t slice_values() const {
        return static_cast<std::size_t>(volume_.nx) * static_cast<std::size_t>(volume_.ny);
    }
    double place(int z) const {
        return volume_.slice_places.empty() ? z : volume_.slice_places[static_cast<std::size_t>(z)];
    }
    template <typename T>
    std::span<T> slice(int z) {
        return typed<T>(std::span<std::byte>(volume_.values))
            .subspan(static_cast<std::size_t>(z) * slice_values(), slice_values());
    }

    /// Slice z, smoothed within itself, joins those that are held.
    template <typename T>
    void load(int z) {
        const std::span<T> from = slice<T>(z);
        std::vector<float> to(from.begin(), from.end());
        const auto nx = static_cast<std::size_t>(volume_.nx),
                   ny = static_cast<std::size_t>(volume_.ny);
        for (std::size_t y = 0; y < ny; ++y) {
            smooth_line(to.data() + y * nx, nx, 1, x_weights_, copy_);
        }
        for (std::size_t x = 0; x < nx; ++x) {
            smooth_line(to.data() + x, ny, nx, y_weights_, copy_);
        }
        slices_.push_back(std::move(to));
    }

    /// Slice z becomes the weighted mean of those that are held, all of which are in reach.
    template <typename T>
    void store(int z) {
        std::vector<double> weights;
        for (std::size_t i = 0; i < slices_.size(); ++i) {
            const double distance = (place(first_ + static_cast<int>(i)) - place(z)) / z_sigma_;
            weights.push_back(std::exp(-0.5 * distance * distance));
        }
        const std::span<T> out = slice<T>(z);
        const std::vector<float>& own = slices_[static_cast<std::size_t>(z - first_)];
        for (std::size_t voxel = 0; voxel < out.size(); ++voxel) {
            if (!std::isfinite(own[voxel])) {
                continue;
            }
            double sum = 0, all = 0;
            for (std::size_t i = 0; i < slices_.size(); ++i) {
                if (std::isfinite(slices_[i][voxel])) {
                    sum += weights[i] * static_cast<double>(slices_[i][voxel]);
                    all += weights[i];
                }
            }
            out[voxel] = nearest<T>(sum / all);
        }
    }

    Volume& volume_;
    std::vector<double> x_weights_, y_weights_;
    double z_sigma_ = 0;                     ///< In units of slice places.
    std::deque<std::vector<float>> slices_;  ///< From first_ up to loaded_.
    int first_ = 0, loaded_ = 0;
    std::vector<float> copy_;
};

}  // namespace

void smooth(double sigma_mm, Volume& volume) {
    SliceSmoother smoother(sigma_mm, volume);
    with_scalar(volume.type, [&]<typename T>(T*) { smoother.run<T>(); });
}

}  // namespace pxpl5::host::io
