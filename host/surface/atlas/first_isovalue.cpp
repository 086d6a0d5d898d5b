#include "host/surface/atlas/first_isovalue.hpp"

#include "host/surface/atlas/histogram.hpp"

namespace pxpl5::host {

namespace {

constexpr int isovalue_bins = 1024;

}  // namespace

double first_isovalue(const Volume& volume) {
    const Histogram counted = histogram(volume, isovalue_bins);
    double all = 0, moment = 0;
    for (std::size_t bin = 0; bin < counted.counts.size(); ++bin) {
        all += static_cast<double>(counted.counts[bin]);
        moment += static_cast<double>(counted.counts[bin]) * static_cast<double>(bin);
    }
    double below = 0, moment_below = 0, best = -1;
    std::size_t first_above = 0;
    for (std::size_t bin = 0; bin + 1 < counted.counts.size(); ++bin) {
        below += static_cast<double>(counted.counts[bin]);
        moment_below += static_cast<double>(counted.counts[bin]) * static_cast<double>(bin);
        const double above = all - below;
        if (below == 0 || above == 0) {
            continue;
        }
        const double apart = moment_below / below - (moment - moment_below) / above;
        if (below * above * apart * apart > best) {
            best = below * above * apart * apart;
            first_above = bin + 1;
        }
    }
    if (first_above == 0) {
        return volume.minimum;
    }
    const double edge = counted.first + counted.width * static_cast<double>(first_above);
    return volume.type == Scalar::float32 ? edge : edge - 0.5;
}

}  // namespace pxpl5::host
