#include "gp_firmware/volume/gradient.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>
#include <vector>

#include "gp_firmware/volume/voxel_gradient.hpp"

namespace pxpl5::gp {

namespace {

using Exact = ExactDifference;
using Scaled = ScaledDifference;

/// Rows of voxels: the row of the gradients and its four neighbors.
template <class T>
struct Rows {
    const T *here, *y_before, *y_after, *z_before, *z_after;
    int y_factor, z_factor;  ///< 2 where the difference is one-sided.
};

template <class T, class Store>
void gradients_of_row(const Rows<T>& rows, int nx, Store store, Gradient* out) {
    const auto across = [&](int x) {
        out[x][1] = store(rows.y_after[x], rows.y_before[x], rows.y_factor);
        out[x][2] = store(rows.z_after[x], rows.z_before[x], rows.z_factor);
    };
    const int last = nx - 1;
    out[0][0] = store(rows.here[1], rows.here[0], 2);
    across(0);
    for (int x = 1; x < last; ++x) {
        out[x][0] = store(rows.here[x + 1], rows.here[x - 1], 1);
        across(x);
    }
    out[last][0] = store(rows.here[last], rows.here[last - 1], 2);
    across(last);
}

template <class T, class Store>
void gradients_of_slice(const VolumeShape& shape, const SliceNeighbors& slices, Store store,
                        Gradient* out) {
    const T *below = typed<T>(slices.below), *here = typed<T>(slices.here),
            *above = typed<T>(slices.above);
    for (int y = 0; y < shape.ny; ++y) {
        const std::ptrdiff_t nx = shape.nx, row = y * nx;
        const bool first = y == 0, last = y == shape.ny - 1;
        const Rows<T> rows{here + row,
                           here + (first ? row : row - nx),
                           here + (last ? row : row + nx),
                           below + row,
                           above + row,
                           first || last ? 2 : 1,
                           slices.at_end ? 2 : 1};
        gradients_of_row(rows, shape.nx, store, out + row);
    }
}

/// The columns of a row, in one list for each part.
struct Columns {
    std::vector<double> mean, rise_y, rise_z;

    explicit Columns(std::size_t nx) : mean(nx), rise_y(nx), rise_z(nx) {}
    GradientColumn operator[](std::size_t x) const { return {mean[x], rise_y[x], rise_z[x]}; }
};

template <class T>
void smooth_gradients_of_slice(const VolumeShape& shape, const SliceNeighbors& slices,
                               Gradient* out) {
    const std::array<const T*, 3> voxels{typed<T>(slices.below), typed<T>(slices.here),
                                         typed<T>(slices.above)};
    const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
    const Scaled store{gradient_scale(shape) / smooth_weight};
    Columns columns(nx);
    for (std::size_t y = 0; y < ny; ++y, out += nx) {
        const RowsAround<T> rows(voxels, nx, ny, y, slices.at_end);
        for (std::size_t x = 0; x < nx; ++x) {
            const GradientColumn column = rows.column(x);
            columns.mean[x] = column.mean;
            columns.rise_y[x] = column.rise_y;
            columns.rise_z[x] = column.rise_z;
        }
        out[0] = smooth_gradient(columns[0], columns[0], columns[1], true, store);
        for (std::size_t x = 1; x + 1 < nx; ++x) {
            out[x] = smooth_gradient(columns[x - 1], columns[x], columns[x + 1], false, store);
        }
        out[nx - 1] =
            smooth_gradient(columns[nx - 2], columns[nx - 1], columns[nx - 1], true, store);
    }
}

}  // namespace

double gradient_scale(const VolumeShape& shape) {
    const double reach = 2 * (shape.maximum - shape.minimum);
    const bool is_whole =
        shape.type != Scalar::float32 && shape.gradient == GradientKernel::central;
    if (is_whole && reach <= largest_gradient) {
        return 1;
    }
    return reach > 0 && std::isfinite(reach) ? largest_gradient / reach : 1;
}

std::vector<Gradient> estimate_gradients(const VolumeShape& shape, const SliceNeighbors& slices) {
    assert(shape.nx >= 2);
    assert(shape.ny >= 2);
    std::vector<Gradient> gradients(shape.slice_voxels());
    const double scale = gradient_scale(shape);
    with_scalar(shape.type, [&]<class T>(T) {
        if (shape.gradient == GradientKernel::smooth) {
            return smooth_gradients_of_slice<T>(shape, slices, gradients.data());
        }
        if constexpr (std::is_integral_v<T>) {
            if (scale == 1) {
                return gradients_of_slice<T>(shape, slices, Exact{}, gradients.data());
            }
        }
        gradients_of_slice<T>(shape, slices, Scaled{scale}, gradients.data());
    });
    return gradients;
}

}  // namespace pxpl5::gp
