#include "host/io/dicom/thumbnail.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "host/io/dicom/dicom_file.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double least_share = 0.01;

/// The values of the slice; what is not finite counts as the minimum.
std::vector<float> values_of(const DicomSlice& slice) {
    ValueSink sink(static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
    DicomPixels().add(slice, sink);
    Volume volume;
    sink.finish(slice.path.string(), volume);
    std::vector<float> values;
    with_values(volume, [&](const auto& typed) {
        for (const auto value : typed) {
            const auto number = static_cast<float>(value);
            values.push_back(std::isfinite(number) ? number : static_cast<float>(volume.minimum));
        }
    });
    return values;
}

/// Values at which gray begins and ends.
std::pair<double, double> range_of(std::vector<float> values,
                                   std::optional<std::pair<double, double>> window) {
    if (window && window->second > 0) {
        const double low = window->first - window->second / 2;
        const double high = window->first + window->second / 2;
        if (std::isfinite(high - low)) {
            return {low, high};
        }
    }
    const auto last = static_cast<double>(values.size() - 1);
    const auto at = [&](double share) {
        const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * last);
        std::nth_element(values.begin(), nth, values.end());
        return static_cast<double>(*nth);
    };
    const double low = at(least_share);
    return {low, at(1 - least_share)};
}

/// The mean of the values from (x0, y0) to before (x1, y1).
double mean(const std::vector<float>& values, const DicomSlice& slice, int x0, int y0, int x1,
            int y1) {
    double sum = 0;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            sum += static_cast<double>(values[static_cast<std::size_t>(y * slice.columns + x)]);
        }
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

}  // namespace

DicomSlice middle_of(const std::vector<DicomSlice>& series) {
    assert(!series.empty());
    try {
        std::vector<Finding> findings;
        const OrderedSlices ordered = order_slices("", series, {}, findings);
        return ordered.slices[ordered.slices.size() / 2];
    } catch (const ImportError&) {
        return series[series.size() / 2];
    }
}

Thumbnail thumbnail_of(const DicomSlice& slice, std::optional<std::pair<double, double>> window) {
    const std::vector<float> values = values_of(slice);
    const auto [low, high] = range_of(values, window);
    const double wide_mm = slice.columns * glm::length(slice.x_step_mm);
    const double high_mm = slice.rows * glm::length(slice.y_step_mm);
    const double side_mm = std::max(wide_mm, high_mm);
    const auto pixels = [&](double mm, int voxels) {
        const int most = std::min(thumbnail_side, voxels);
        return std::clamp(static_cast<int>(std::lround(thumbnail_side * mm / side_mm)), 1, most);
    };
    Thumbnail picture{pixels(wide_mm, slice.columns), pixels(high_mm, slice.rows), {}};
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const double value = mean(
                values, slice, x * slice.columns / picture.width, y * slice.rows / picture.height,
                (x + 1) * slice.columns / picture.width, (y + 1) * slice.rows / picture.height);
            const double share =
                high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0.0;
            const double gray = slice.is_inverted() ? 1 - share : share;
            picture.pixels.push_back(static_cast<std::uint8_t>(std::lround(255 * gray)));
        }
    }
    return picture;
}

}  // namespace pxpl5::host::io
