// The header of a volume file, and its checks before any allocation.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "host/io/formats/byte_source.hpp"
#include "host/io/formats/data_file.hpp"
#include "host/io/values/import_request.hpp"
#include "host/io/values/value_sink.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

enum class Format : std::uint8_t {
    nrrd,
    meta_image,
    nifti,
    mgh,
    vtk,
    vti,
    dicom,
    pictures,
    packed
};

/// The format of `path` by its suffix, or by its first bytes if the suffix says nothing. Of a
/// folder: dicom, though it may hold pictures only.
/// Throws ImportError for a missing file or an unknown format.
Format format_of(const std::filesystem::path& path);

/// Whether format_of() is `packed`. False for a file that cannot be read.
bool is_packed(const std::filesystem::path& path);

/// A header's own words, without the defaults that decoders put in.
struct StoredHeader {
    /// Voxels along each axis, x first, as stated; without the volumes of a time series.
    std::vector<std::uint64_t> sizes;
    std::uint64_t frames = 1;  ///< Volumes of a time series, one after the other in a file.
    std::uint64_t frame = 1;   ///< The volume that is read, from 1.
    /// The volume's number in its time series, and how many there are, also in several files.
    int series_frame = 1, series_frames = 1;
    double frame_ms = 0;  ///< From one volume of the series to the next; 0 if not stated.
    std::string type;     ///< The header's spelling.
    Component component = Component::uint8;
    bool big_endian = false;
    Encoding encoding = Encoding::raw;
    /// Where the values are, in order; each file holds the same number. May be the header's own.
    std::vector<std::filesystem::path> data_files;
    AllowedFolders allowed;          ///< Where data files may be beside the header's folder.
    std::uint64_t offset_bytes = 0;  ///< In each file, before decompression.
    std::uint64_t line_skip = 0;     ///< Lines after that, before decompression.
    std::uint64_t byte_skip = 0;     ///< Bytes after that, decompressed.
    /// Bytes of the file that the compressed values are, if the header states it.
    std::uint64_t compressed_bytes = std::numeric_limits<std::uint64_t>::max();
    bool at_end = false;        ///< The values are the last bytes; byte_skip means nothing.
    bool ends_file = false;     ///< Nothing should follow the values.
    bool fits_exactly = false;  ///< Nothing may follow the values.
    bool ends_at_tag = false;   ///< Values as text end where a tag of XML begins.
    Scale scale;
    glm::dmat4 voxel_to_patient{1.0};  ///< LPS millimeters. Axes without spacing have length 1.
    std::array<bool, 3> spacing_stated{true, true, true};
    /// How the axes are taken if the file does not state their directions; else empty.
    std::string assumed_directions;
    std::vector<Finding> findings;

    /// Bytes of other volumes in the file before and behind the one that is read, decompressed.
    std::uint64_t bytes_before() const;
    std::uint64_t bytes_behind() const;

    void find(FindingKind kind, std::string text) { findings.push_back({kind, std::move(text)}); }
};

/// Read the header of `path`. Its data files lie as DataFile wants them. Throw ImportError naming
/// the field and its value.
/// frame  Volume of a time series, from 1; 0: as take_frames().
StoredHeader read_nrrd_header(const std::filesystem::path& path, const AllowedFolders& allowed,
                              std::uint32_t frame);
StoredHeader read_meta_header(const std::filesystem::path& path, const AllowedFolders& allowed,
                              std::uint32_t frame);
StoredHeader read_nifti_header(const std::filesystem::path& path, const AllowedFolders& allowed,
                               std::uint32_t frame);
StoredHeader read_mgh_header(const std::filesystem::path& path, std::uint32_t frame);
StoredHeader read_vtk_header(const std::filesystem::path& path);
/// orientation  What the user says of the axes: none if the file turns them.
StoredHeader read_vti_header(const std::filesystem::path& path, const std::string& orientation);

/// Whether a fourth axis can only be time.
enum class FourthAxis : std::uint8_t { time, unknown };

/// Takes the volumes of a time series, the fourth axis, from the sizes. Three sizes stay.
/// frame   The volume to read, from 1; 0: the first if the axis is time, else there must be one.
/// Throws  ImportError naming `frame` and how many volumes there are, or as volume_dims().
void take_frames(const std::string& file, std::uint32_t frame, FourthAxis axis,
                 StoredHeader& header);

/// The file of a time series ends before its last volume does.
/// bytes_there  Bytes of later volumes than that of the header.
Finding cut_series(const StoredHeader& header, const std::filesystem::path& data_file,
                   std::uint64_t bytes_there);

/// Drops the fourth size if it is 1, for formats that always state it.
void drop_single_frame(StoredHeader& header);

/// If the values of a time series are in several data files: keeps those of the volume.
/// Throws ImportError if a file has values of several volumes.
void keep_files_of_frame(const std::string& file, StoredHeader& header);

/// The header that `layout` describes. The file may be compressed by gzip.
/// Throws ImportError if the file's size is another.
StoredHeader read_raw_layout(const std::filesystem::path& path, const RawLayout& layout);

/// Holds `header` of `path` against the limits and the sizes of the data files, and notes bytes
/// that are left over. Throws ImportError naming both values.
void check_stored_header(const std::filesystem::path& path, StoredHeader& header);

/// A volume with the size, affine and findings of a header that has been checked; without values.
Volume empty_volume(const std::filesystem::path& path, const StoredHeader& header);

/// Reads the values of headers.
class StoredReader {
  public:
    StoredReader();
    ~StoredReader();
    StoredReader(const StoredReader&) = delete;
    StoredReader& operator=(const StoredReader&) = delete;

    /// Decodes the values of a header of `path` that has been checked. Sets dims, affine, values
    /// and findings. Throws ImportError naming how many bytes or values there are and how many are
    /// needed.
    ///
    /// later_follow  A later volume of the same file will be read. Its compressed data are then
    ///               decompressed from here on, and their checksum, which follows the last volume,
    ///               is not checked yet.
    Volume read(const std::filesystem::path& path, const StoredHeader& header,
                bool later_follow = false);

  private:
    struct Open;
    std::unique_ptr<Open> open(const std::filesystem::path& path, const StoredHeader& header,
                               const std::filesystem::path& data);
    static void skip_to_values(const std::string& file, const StoredHeader& header,
                               const std::filesystem::path& data, std::uint64_t needed,
                               Open& opened);

    std::unique_ptr<Open> open_;  ///< The compressed file of the volume before.
};

/// Why GPs cannot read the values from their file: "its values are compressed". Empty if they can.
std::string why_not_by_gps(const StoredHeader& header);

/// Reads the values of a header that why_not_by_gps() has accepted, and keeps a reduced copy. Sets
/// what StoredReader::read() sets, the digest, the file, the reduction and the copy.
/// reduced_bytes  Most bytes of the copy. If all values fit, `values` has them.
/// Throws         ImportError as StoredReader::read(), and if the file changes meanwhile.
Volume scan_stored_values(const std::filesystem::path& path, const StoredHeader& header,
                          std::uint64_t reduced_bytes);

/// Where values begin in a data file whose lines are skipped.
std::uint64_t offset_after_lines(const std::string& file, const std::filesystem::path& path,
                                 std::uint64_t offset, std::uint64_t lines);

/// The error for a data file that is too short.
ImportError too_short(const std::string& file, const StoredHeader& header,
                      const std::filesystem::path& data, std::uint64_t got,
                      const std::string& damage = {});

/// The three sizes of a volume: those after the third must be 1; those that are not stated are.
/// Throws ImportError naming all sizes.
std::array<int, 3> volume_dims(const std::string& file, const std::vector<std::uint64_t>& sizes);

/// Bytes of all values. Sizes must have passed check_stored_header, or be small.
std::uint64_t needed_bytes(const StoredHeader& header);

/// "128x128x56".
std::string join_sizes(const std::vector<std::uint64_t>& sizes);

/// Files of a pattern with one %d ("slice%03d.raw 1 20 1"), or of the lines that follow in a
/// header ("LIST").
/// Throws ImportError if there are more than max_data_files, or the pattern is none.
std::vector<std::filesystem::path> numbered_files(const std::filesystem::path& header_file,
                                                  const std::string& field,
                                                  const std::string& text);
inline constexpr std::size_t max_data_files = 65'536;

}  // namespace pxpl5::host::io
