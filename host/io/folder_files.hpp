// The files of a folder that hold a volume.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/formats/data_file.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Files of a folder by their contents.
struct FolderFiles {
    std::vector<DicomSlice> slices;
    std::vector<std::filesystem::path> pictures;
    std::vector<Finding> left_out;   ///< DICOM files that cannot be read, and why.
    std::size_t others = 0;          ///< Files that are no DICOM images.
    std::size_t other_pictures = 0;  ///< Pictures of a kind that is left out.
};

/// Looks through a folder and the folders inside it. Nothing is decoded.
///
/// allowed  Folders to which links may lead, beside the folder itself.
/// Throws   ImportError if there are too many files or slices.
FolderFiles look_through(const std::filesystem::path& folder, const AllowedFolders& allowed);

/// Adds a finding about the files that are left out.
void report_left_out(const FolderFiles& files, Volume& volume);

}  // namespace pxpl5::host::io
