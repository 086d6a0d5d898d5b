// Elements of a DICOM data set, and the kinds of image that need more than the common ones. Only
// files that include this one and dicom_pixels.cpp include GDCM.
#pragma once

#include <gdcmDataSet.h>

#include <string>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"

namespace pxpl5::host::io {

/// The bytes of an element; empty if it is absent.
std::string bytes_of(const gdcm::DataSet& data, gdcm::Tag tag);

/// The bytes of an element as text, without padding; empty if it is absent.
std::string text_of(const gdcm::DataSet& data, gdcm::Tag tag);

/// Numbers of an element, which stand between backslashes. Empty if it is absent or empty.
std::vector<double> numbers_of(const std::string& file, const gdcm::DataSet& data, gdcm::Tag tag);

/// A US element; GDCM has put it into this machine's byte order. 0 if it is absent or too short.
int unsigned_of(const gdcm::DataSet& data, gdcm::Tag tag);

/// Fills the slice's samples, bits, bits_stored, is_signed and photometric.
/// Throws   ImportError for a layout of the pixels on which GDCM asserts, or that it misreads.
void read_pixel_layout(const std::string& file, const gdcm::DataSet& data, DicomSlice& slice);

/// The unit of a PET file's values, and the factor to standardized uptake values by body weight.
///
/// The factor is weight / dose, where the dose is that of the time to which the values are
/// corrected for decay. If something for it is missing or implausible, there is a reason instead.
/// Source: DICOM PS3.3, C.8.9; QIBA's vendor-neutral SUV pseudo-code.
DicomUptake read_uptake(const gdcm::DataSet& data);

/// Throws   NoSlices if the file holds what is no volume of gray values: a directory of files, a
///          segmentation, float pixels.
void refuse_other_kinds(const std::string& file, const gdcm::DataSet& data);

/// Throws   NoSlices if `slices` are frames without positions that follow each other in time.
void refuse_time_series(const std::string& file, const gdcm::DataSet& data,
                        const std::vector<DicomSlice>& slices);

/// Replaces the one slice of a Siemens mosaic by its tiles, each in its place. Other slices stay.
/// Throws   ImportError for a mosaic that does not state where its tiles lie.
void unfold_mosaic(const std::string& file, const gdcm::DataSet& data,
                   std::vector<DicomSlice>& slices);

}  // namespace pxpl5::host::io
