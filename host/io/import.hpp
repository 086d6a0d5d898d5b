// Volumes in: decodes a file, a folder or a phantom into a plain Volume.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Reads the volumes of a time series, one after the other. What they share is read once: the
/// headers of a folder's files, and compressed data up to the next volume.
class Importer {
  public:
    explicit Importer(ImportRequest request);
    ~Importer();
    Importer(Importer&&) noexcept;
    Importer& operator=(Importer&&) noexcept;

    /// The volume that import_volume() returns if ImportRequest::frame is `frame`.
    /// later_follow  A later volume will be read. Then the end of compressed data is checked, and
    ///               findings about it are reported, with the last volume only.
    Volume read(std::uint32_t frame, bool later_follow = false);

    struct Shared;

  private:
    std::unique_ptr<Shared> shared_;
};

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
