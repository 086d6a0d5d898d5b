// What a volume file says of itself: read before any decoder allocates or guesses something.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pxpl5::host::io {

enum class Format : std::uint8_t { nrrd, meta_image, nifti, vtk, dicom };

/// The format of `path` by its suffix, or by its first bytes if the suffix says nothing.
/// Throws ImportError for a missing file or an unknown format.
Format format_of(const std::filesystem::path& path);

/// How values lie in the data file. `unchecked`: in several files or at an unknown place.
enum class Storage : std::uint8_t { raw, ascii, compressed, unchecked };

/// A header's own words, without the defaults that decoders put in.
struct StoredHeader {
    std::vector<std::uint64_t> sizes;     ///< Voxels along each axis, x first, as stated.
    std::string type;                     ///< As the header spells it.
    std::uint64_t value_bytes = 0;        ///< Of one value; channels not counted.
    std::filesystem::path data_file;      ///< Holds the values; may be the header's own file.
    std::uint64_t data_offset_bytes = 0;  ///< Where they begin, at the earliest.
    Storage storage = Storage::unchecked;
    bool ends_file = false;        ///< Nothing but the values follows data_offset_bytes.
    bool spacing_stated = true;    ///< False if a decoder would make one up.
    bool scaled_integers = false;  ///< Integers with a slope or an intercept.
    std::vector<std::string> notes;
};

/// Read the header of `path` and hold it against the limits and the data file.
/// Throw ImportError naming the field and its value.
StoredHeader read_nrrd_header(const std::filesystem::path& path);
StoredHeader read_meta_header(const std::filesystem::path& path);
StoredHeader read_nifti_header(const std::filesystem::path& path);
StoredHeader read_vtk_header(const std::filesystem::path& path);

/// Holds `header` of `path` against the limits and the size of the data file, and notes bytes that
/// are left over. Throws ImportError naming both values.
void check_stored_header(const std::filesystem::path& path, StoredHeader& header);

/// Decompresses the data file from `offset_bytes` on.
/// Throws ImportError naming both sizes if fewer than `needed` bytes come out.
void check_inflated(const std::string& file, const StoredHeader& header, std::uint64_t offset_bytes,
                    std::uint64_t needed);

/// Bytes of all values. Sizes must have passed check_stored_header, or be small.
std::uint64_t needed_bytes(const StoredHeader& header);

/// "128x128x56".
std::string join_sizes(const std::vector<std::uint64_t>& sizes);

}  // namespace pxpl5::host::io
