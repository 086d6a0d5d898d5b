// The volumes of a time series: which one the GPs hold, and those that the host keeps at hand.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "host/session/volumes.hpp"
#include "host/surface/atlas/gray_window.hpp"

namespace pxpl5::host {

/// Bytes of the volumes that a session keeps beside the shown one. A series of 512 volumes of a
/// million voxels fits.
inline constexpr std::size_t max_kept_bytes = std::size_t{1} << 30;

/// Bytes and number of the volumes that one request reads: the wanted volume, whatever its size,
/// and those that come next.
inline constexpr std::size_t max_ahead_bytes = std::size_t{64} << 20;
inline constexpr int max_ahead_volumes = 64;

/// Shows one volume of a series after the other. Volumes that come next are read with the wanted
/// one. All are kept in memory, so that a second turn reads no file; if not all fit, those that
/// come next.
class TimeSeries {
  public:
    struct Kept {
        std::size_t volumes = 0, bytes = 0;  ///< Without the shown volume.
    };

    explicit TimeSeries(Volumes& volumes) : volumes_(volumes) {}

    /// Gives volume `frame` of the loaded series to the GPs, which drops surfaces and clip planes.
    /// Does nothing if the GPs hold it. Throws RequestError (usage) if the series has no such
    /// volume, and (bad_data) if it cannot be read, or differs in shape or place from the shown
    /// one, which then stays; otherwise as Volumes::exchange().
    void show(int frame);
    Kept kept() const { return {kept_.size(), kept_bytes_}; }
    /// The usual window of the volume that was shown first since the load. It is that of the whole
    /// series: else gray values of one tissue would change with the time.
    GrayWindow window();
    /// Frees the kept volumes if another volume, or none, was loaded since.
    void forget_others();

  private:
    void begin_series();
    int count_to_read(int frame) const;
    std::vector<Volume> take(int frame);
    void keep(Volume volume);

    Volumes& volumes_;
    int loads_ = 0;               ///< Volumes::loads() of the series.
    std::map<int, Volume> kept_;  ///< By number in the series.
    std::size_t kept_bytes_ = 0;
    std::optional<GrayWindow> window_;
    bool reads_ahead_ = true;  ///< False after a volume of the series could not be read.
};

/// Throws RequestError (usage) if the series of the volume has no volume `frame`.
void check_frame(const Volume& volume, int frame);

}  // namespace pxpl5::host
