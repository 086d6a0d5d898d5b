// DICOM slices become one volume: which of them, in which order, how far apart.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/io/dicom/dicom_input.hpp"
#include "host/io/values/import_request.hpp"
#include "host/io/values/value_sink.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_slices = 65'536;  ///< Files of a folder, and frames of all.

/// The values of a PET file: their unit, and what they are of the dose.
struct DicomUptake {
    std::string unit;          ///< Bq/ml, g/ml or as the file states it; empty if it does not.
    double suv_per_value = 0;  ///< Standardized uptake value (g/ml) of a value of 1; 0: not known.
    std::string reason;        ///< Why it is not known.
};

/// Elements that tell slices of one place apart. Source: DICOM PS3.3, C.7.6.2, C.8.3, C.7.6.16.2.
struct DicomTimes {
    std::optional<double> position;        ///< Number in time (0020,0100) or (0020,9128).
    std::optional<double> trigger_ms;      ///< After the heart's R wave (0018,1060), (0020,9153).
    std::optional<double> acquisition_ms;  ///< Since 1970, or midnight if no date is stated.
    std::optional<double> acquisition;     ///< Number (0020,0012).
    /// Type of image, sequence, echo and inversion time, diffusion: slices that differ in these
    /// differ in more than their time.
    std::string kind;
};

/// One slice: a file, or one frame of it.
struct DicomSlice {
    std::filesystem::path path;
    std::shared_ptr<const std::string> unpacked;  ///< See DicomInput::bytes.
    int frame = 0, frames = 1;  ///< Index in the file, and how many the file holds.
    std::string series;         ///< Series instance UID; may be empty.
    std::string instance;       ///< SOP instance UID; may be empty.
    std::string description, modality;
    int series_number = 0, instance_number = 0;
    int columns = 0, rows = 0;
    int tiles_across = 1, tile = 0;  ///< A mosaic's picture has tiles_across^2 tiles of this size.
    int samples = 1;                 ///< Samples per pixel (1 is gray).
    int bits = 0, bits_stored = 0;   ///< Bits of a sample in the file; the lowest that are in use.
    bool is_signed = false;
    std::string photometric;  ///< (0028,0004), for example "MONOCHROME2"; may be empty.
    glm::dvec3 x_step_mm{1, 0, 0}, y_step_mm{0, 1, 0};  ///< One column and one row further, LPS.
    glm::dvec3 origin_mm{0};                            ///< Center of the first voxel, LPS.
    bool spacing_stated = true;                         ///< False: x and y steps have length 1.
    bool position_stated = true;  ///< False: origin and orientation are unknown.
    std::optional<double> thickness_mm;
    /// Signed distance to the next frame where frames have no positions of their own.
    std::optional<double> frame_step_mm;
    Scale scale;
    std::vector<NamedWindow> windows;      ///< In the order of the file.
    std::optional<DicomUptake> uptake;     ///< The values of a PET file.
    std::uint64_t pixel_offset_bytes = 0;  ///< Position of the values in the file; 0 if unknown.
    /// Position of values that are little endian and neither compressed nor deflated.
    std::optional<std::uint64_t> raw_offset_bytes;
    DicomTimes times;
    FileFacts facts;        ///< Before the header was read.
    bool is_lossy = false;  ///< JPEG and the like.

    bool is_inverted() const { return photometric == "MONOCHROME1"; }
    bool is_gray() const {
        return samples == 1 &&
               (photometric.empty() || photometric == "MONOCHROME2" || is_inverted());
    }

    DicomInput input() const { return {path, unpacked}; }
    int stored_columns() const { return columns * tiles_across; }
    int stored_rows() const { return rows * tiles_across; }
};

/// "IM7", or "frame 3 of IM7" in a file of several frames.
std::string name_of(const DicomSlice& slice);

/// Thrown for a DICOM file that is whole, but holds no slices of a volume.
struct NoSlices : ImportError {
    using ImportError::ImportError;
};

/// Thrown for a file whose header was read, but not its pixels.
struct UnreadablePixels : ImportError {
    UnreadablePixels(std::filesystem::path file, const ImportError& error)
        : ImportError(error), path(std::move(file)) {}
    std::filesystem::path path;
};

/// Adds the values of one slice. Slices of one file are asked for by ascending frame if they are
/// ascending in space.
using DecodeSlice = std::function<void(const DicomSlice&, ValueSink&)>;

/// The slices of each series, in the order of `series=N`: the first series is number 1.
std::vector<std::vector<DicomSlice>> series_of(std::vector<DicomSlice> slices);

struct SeriesVolume {
    Volume volume;
    std::array<bool, 3> spacing_stated{};  ///< By the slices that were taken, along x, y, z.
};

/// One series whose values have not been read.
struct OrderedSeries {
    SeriesVolume result;             ///< The volume without values, their type and range.
    std::vector<DicomSlice> slices;  ///< The slices of the volume, in order.
};

/// Puts the slices of one series in order along their normal. The z step comes from the slices'
/// positions alone: thickness is not distance, and a tilted gantry shears. Where steps differ, the
/// volume's slice_places and gap_slabs say so. What was left out or is odd is in the findings.
///
/// source   File or folder, for error texts.
/// request  Its series is the one to take; must be given if there are several.
/// Throws   ImportError: several series (listed), an unknown one, slices without positions.
OrderedSeries order_series(const std::string& source, std::vector<DicomSlice> slices,
                           const ImportRequest& request);

/// Reads the values of a series. Throws ImportError for more than max_volume_bytes.
SeriesVolume decode_series(const std::string& source, OrderedSeries series,
                           const DecodeSlice& decode);

/// order_series() and decode_series().
SeriesVolume assemble_series(const std::string& source, std::vector<DicomSlice> slices,
                             const ImportRequest& request, const DecodeSlice& decode);

/// Why GPs cannot read the values of these slices from their files: "IM7 is compressed". Empty if
/// they can.
std::string why_not_by_gps(const std::vector<DicomSlice>& slices);

/// Where the values of slices lie that why_not_by_gps() has accepted.
StoredVolume stored_volume_of(const std::vector<DicomSlice>& slices);

/// Slices of one volume in order, and how far along their normal each lies.
struct OrderedSlices {
    std::vector<DicomSlice> slices;
    std::vector<double> along_mm;  ///< Ascending.
    int frame = 1, frames = 1;     ///< Number in its time series, from 1, and how many there are.
    double frame_ms = 0;           ///< See Volume::frame_ms.
    std::vector<double> times_ms;  ///< See Volume::times_ms.
};

/// Slices of volumes with missing slices, which are not shown.
struct LeftOut {
    std::size_t slices = 0;
    std::vector<std::string> volumes;  ///< "volume 3 of 20 (Trigger Time 66.7) has 7 of 8 slices".
    bool has_first = false;            ///< The first volume is one of them.
};

/// How the slices of one place follow each other in time.
struct TimeOrder {
    int frames = 1;                ///< 1: they do not.
    double frame_ms = 0;           ///< From one volume to the next; 0 if unknown or uneven.
    std::vector<double> times_ms;  ///< See Volume::times_ms.
    std::string told_by;           ///< "Trigger Time".
    std::string why_not;           ///< Why slices of one place are no time series; else empty.
    LeftOut left_out;
};

/// Sorts the slices of each place by time if all places have the same number of slices, and one
/// element is different for all slices of each place. Otherwise leaves them as they are. Removes
/// the slices of incomplete volumes if their times show which these are.
///
/// places  Indices into `slices`, for each place in the patient.
TimeOrder sort_by_time(const std::vector<DicomSlice>& slices,
                       std::vector<std::vector<std::size_t>>& places);

/// "a; b; c and 4 more", for a finding.
std::string few_of(const std::vector<std::string>& names);

/// Says which volume of a time series is taken, from 1, and what was left out; else nothing.
void report_times(const TimeOrder& times, int frame, std::vector<Finding>& findings);

/// Returns the largest set of one size and orientation of a series, by position, each position
/// once: of a time series, those of the volume that is asked for.
/// Throws   ImportError for a volume that the series does not have.
OrderedSlices order_slices(const std::string& source, std::vector<DicomSlice> series,
                           const ImportRequest& request, std::vector<Finding>& findings);

/// Sets the affine, slice_places and gap_slabs of `volume`, and reports gaps, tilt and thickness.
void place_slices(const OrderedSlices& ordered, const ImportRequest& request, Volume& volume);

}  // namespace pxpl5::host::io
