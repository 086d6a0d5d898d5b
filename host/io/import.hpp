// Volumes in: decodes a file, a folder or a phantom into a plain Volume.
#pragma once

#include <string>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Decodes NRRD, MetaImage, NIfTI-1 and -2, Analyze 7.5, VTK legacy, DICOM, stacks of pictures or
/// a raw file, or makes a phantom; then crops, smooths and resamples, in this order.
///
/// Returns  the volume: uint8, int16, uint16 and float32 as stored, other types converted
///          without loss where possible. minimum and maximum are over the finite values. What is
///          odd, assumed or was done is in `findings`. name is the file's name without suffix.
/// Throws   ImportError.
Volume import_volume(const ImportRequest& request);
Volume import_volume(const std::string& path);

/// The slices of a DICOM file, or of all files of a folder that can be read, as import_volume()
/// finds them. Nothing is decoded.
///
/// allowed  Folders to which links may lead, beside the folder itself.
/// Throws   ImportError.
std::vector<DicomSlice> find_slices(const std::string& source,
                                    const std::vector<std::string>& allowed);

}  // namespace pxpl5::host::io
