// One DICOM file. All of GDCM is behind this.
#pragma once

#include <memory>
#include <vector>

#include "host/io/dicom/dicom_input.hpp"
#include "host/io/dicom/dicom_series.hpp"

namespace pxpl5::host::io {

/// Whether `input` begins as a DICOM file and holds at least one element: on less, GDCM aborts.
bool begins_as_dicom(const DicomInput& input);

/// The slices that one file says it holds, without decoding them: one for each frame. Empty if the
/// file is no DICOM image.
/// Throws   ImportError for an image whose spacing or orientation makes no sense, or color.
std::vector<DicomSlice> read_dicom_slices(const DicomInput& input);

/// Decodes slices. Holds the last file's values, since frames are asked for one by one.
class DicomPixels {
  public:
    DicomPixels();
    ~DicomPixels();
    DicomPixels(const DicomPixels&) = delete;
    DicomPixels& operator=(const DicomPixels&) = delete;

    /// Throws ImportError naming the file and what is missing.
    void add(const DicomSlice& slice, ValueSink& sink);

  private:
    struct File;
    std::unique_ptr<File> file_;
};

}  // namespace pxpl5::host::io
