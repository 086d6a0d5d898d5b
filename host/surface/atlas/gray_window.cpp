#include "host/surface/atlas/gray_window.hpp"

#include <numeric>

namespace pxpl5::host {

namespace {

constexpr GrayWindow soft_tissue_hu{400, 40};
constexpr double most_uptake = 10;  // Standardized uptake value, g/ml.
constexpr double least_air = -4096, most_air = -500, least_bone = 300, most_bone = 32767;  // HU.
constexpr double dark_share = 0.02, bright_share = 0.98;

bool is_hounsfield(const Volume& volume) {
    return volume.modality == "CT" ||
           (volume.modality.empty() && volume.minimum >= least_air && volume.minimum <= most_air &&
            volume.maximum >= least_bone && volume.maximum <= most_bone);
}

double sum_of(const std::vector<double>& counts) {
    return std::accumulate(counts.begin(), counts.end(), 0.0);
}

/// Where the share of the counts is below, in bins, interpolated linearly within a bin.
double bins_below(const std::vector<double>& counts, double share) {
    double left = share * sum_of(counts);
    for (std::size_t bin = 0; bin < counts.size(); ++bin) {
        if (left <= counts[bin] && counts[bin] > 0) {
            return static_cast<double>(bin) + left / counts[bin];
        }
        left -= counts[bin];
    }
    return static_cast<double>(counts.size());
}

}  // namespace

std::optional<GrayWindow> stated_window(const Volume& volume) {
    if (volume.suv_per_value > 0) {
        return GrayWindow{most_uptake / volume.suv_per_value,
                          most_uptake / 2 / volume.suv_per_value};
    }
    if (!volume.windows.empty()) {
        return GrayWindow{volume.windows.front().width, volume.windows.front().level};
    }
    return is_hounsfield(volume) ? std::optional(soft_tissue_hu) : std::nullopt;
}

GrayWindow usual_window(const Volume& volume, const Histogram& counted) {
    if (const std::optional<GrayWindow> stated = stated_window(volume)) {
        return *stated;
    }
    std::vector<double> counts(counted.counts.begin(), counted.counts.end());
    const double all = sum_of(counts);
    if (!counts.empty() && counts.front() > all / 2 && counts.front() < all) {
        counts.front() = 0;
    }
    const double low = bins_below(counts, dark_share), high = bins_below(counts, bright_share);
    const double width = (high - low) * counted.width;
    return {width > 0 ? width : counted.width, counted.first + (low + high) / 2 * counted.width};
}

}  // namespace pxpl5::host
