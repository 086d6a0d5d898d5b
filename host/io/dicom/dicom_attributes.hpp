// The attributes of a DICOM file as texts: for people, and for the list of series.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/io/dicom/dicom_input.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_dicom_attributes = 2000;
inline constexpr std::size_t max_value_chars = 200;
inline constexpr int max_attribute_depth = 4;  ///< Limit of sequences in sequences.

struct DicomAttribute {
    std::uint16_t group = 0, element = 0;
    int depth = 0;        ///< 0: of the file; 1: of an item of a sequence; and so on.
    std::string keyword;  ///< "PatientName"; empty if the dictionary does not know it.
    std::string vr;       ///< "PN"
    std::string value;    ///< UTF-8, printable; values of many bytes are described.
    bool is_cut = false;  ///< The value has more than max_value_chars characters.
};

struct DicomAttributes {
    std::vector<DicomAttribute> all;
    /// False: the file has more attributes or deeper ones, or their values have more than 512 KiB.
    bool is_whole = true;

    /// The value of an attribute of depth 0; empty if it is absent.
    std::string value(std::uint16_t group, std::uint16_t element) const;
};

/// Reads the attributes before the pixels of a file that begins as a DICOM file.
/// Throws ImportError that names the file if it is not built of whole elements.
DicomAttributes read_attributes(const DicomInput& input);

/// Bytes of a DICOM text as printable UTF-8. Latin-1 is converted; bytes of other character sets,
/// and all bytes after a switch to another one, become question marks.
///
/// charset  (0008,0005)
std::string utf8_of(std::string bytes, const std::string& charset);

}  // namespace pxpl5::host::io
