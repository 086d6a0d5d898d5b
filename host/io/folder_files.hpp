// The files of a folder, or of an archive, that hold a volume.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/formats/data_file.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Files of a folder or an archive by their contents.
struct FolderFiles {
    std::vector<DicomSlice> slices;
    std::vector<std::filesystem::path> pictures;
    std::vector<Finding> left_out;   ///< DICOM files that cannot be read, and why.
    std::size_t others = 0;          ///< Files that are no DICOM images.
    std::size_t other_pictures = 0;  ///< Pictures of a kind that is left out.
    std::size_t links = 0;           ///< Links in an archive, which are not followed.
    std::size_t repeated = 0;        ///< Files of an archive whose name a later one has, too.
};

/// Looks through a folder and the folders inside it. Nothing is decoded.
///
/// allowed  Folders to which links may lead, beside the folder itself.
/// Throws   ImportError if there are too many files or slices.
FolderFiles look_through(const std::filesystem::path& folder, const AllowedFolders& allowed);

/// Looks through a ZIP or tar archive, whose files are unpacked. Pictures count as others.
/// Throws ImportError.
FolderFiles look_through_archive(const std::filesystem::path& archive);

/// Adds a finding about the files that are left out.
void report_left_out(const FolderFiles& files, Volume& volume);

}  // namespace pxpl5::host::io
