// DICOM files, element by element, in explicit little endian: for tests, which must be able to
// write what no library writes.
#pragma once

#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/host/io/volume_files.hpp"

namespace pxpl5::test {

/// A data set; elements may be put in any order.
class DicomSet {
  public:
    DicomSet& text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
        if (value.size() % 2 == 1) {
            value.push_back(std::strcmp(vr, "UI") == 0 ? '\0' : ' ');
        }
        return put(group, element, vr, value);
    }
    DicomSet& number(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
        return put(group, element, "US", bytes_of(value));
    }
    DicomSet& sequence(std::uint16_t group, std::uint16_t element,
                       const std::vector<DicomSet>& items) {
        std::string bytes;
        for (const DicomSet& item : items) {
            const std::string content = item.bytes();
            bytes += tag(0xfffe, 0xe000) + bytes_of(static_cast<std::uint32_t>(content.size())) +
                     content;
        }
        return put(group, element, "SQ", bytes);
    }
    DicomSet& put(std::uint16_t group, std::uint16_t element, const std::string& vr,
                  const std::string& value) {
        const bool is_long = vr == "OW" || vr == "OB" || vr == "OF" || vr == "SQ" || vr == "UN";
        elements_[{group, element}] =
            tag(group, element) + vr +
            (is_long ? std::string(2, '\0') + bytes_of(static_cast<std::uint32_t>(value.size()))
                     : bytes_of(static_cast<std::uint16_t>(value.size()))) +
            value;
        return *this;
    }
    DicomSet& remove(std::uint16_t group, std::uint16_t element) {
        elements_.erase({group, element});
        return *this;
    }
    std::string bytes() const {
        std::string all;
        for (const auto& [key, element] : elements_) {
            all += element;
        }
        return all;
    }
    /// Compressed pixels in one fragment.
    DicomSet& compressed_pixels(const std::string& bytes) {
        const std::string undefined(4, '\xff');
        elements_[{0x7fe0, 0x10}] = tag(0x7fe0, 0x10) + "OB" + std::string(2, '\0') + undefined +
                                    tag(0xfffe, 0xe000) + bytes_of(std::uint32_t{0}) +
                                    tag(0xfffe, 0xe000) +
                                    bytes_of(static_cast<std::uint32_t>(bytes.size())) + bytes +
                                    tag(0xfffe, 0xe0dd) + bytes_of(std::uint32_t{0});
        return *this;
    }
    /// With preamble and meta information.
    /// syntax  UID of the transfer syntax; explicit little endian unless given.
    std::string file(const std::string& syntax = "1.2.840.10008.1.2.1") const {
        DicomSet meta;
        meta.put(2, 1, "OB", std::string("\0\1", 2));
        meta.text(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2").text(2, 3, "UI", "1.2.3.4");
        meta.text(2, 0x10, "UI", syntax).text(2, 0x12, "UI", "1.2.3.9");
        const std::string rest = meta.bytes();
        DicomSet length;
        length.put(2, 0, "UL", bytes_of(static_cast<std::uint32_t>(rest.size())));
        std::string all(128, '\0');
        return all.append("DICM").append(length.bytes()).append(rest).append(bytes());
    }

  private:
    static std::string tag(std::uint16_t group, std::uint16_t element) {
        return bytes_of(group) + bytes_of(element);
    }
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::string> elements_;
};

/// "1.5\-2\0.25"
inline std::string dicom_numbers(std::initializer_list<double> values) {
    std::string text;
    for (const double value : values) {
        std::array<char, 32> word{};
        std::snprintf(word.data(), word.size(), "%.10g", value);
        text += (text.empty() ? "" : "\\") + std::string(word.data());
    }
    return text;
}

/// Attributes of an image of int16 values, except position and values.
inline DicomSet dicom_image(int columns, int rows, const std::string& values) {
    DicomSet set;
    set.text(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2").text(8, 0x18, "UI", "1.2.3.4");
    set.text(8, 0x60, "CS", "CT").text(0x20, 0xe, "UI", "1.2.3");
    set.number(0x28, 2, 1).text(0x28, 4, "CS", "MONOCHROME2");
    set.number(0x28, 0x10, static_cast<std::uint16_t>(rows));
    set.number(0x28, 0x11, static_cast<std::uint16_t>(columns));
    set.number(0x28, 0x100, 16).number(0x28, 0x101, 16).number(0x28, 0x102, 15);
    set.number(0x28, 0x103, 1);
    set.put(0x7fe0, 0x10, "OW", values);
    return set;
}

/// Position, orientation and spacing of a slice: first voxel, one column and one row further.
inline DicomSet& dicom_place(DicomSet& set, glm::dvec3 origin, glm::dvec3 x, glm::dvec3 y,
                             double x_mm, double y_mm) {
    set.text(0x20, 0x32, "DS", dicom_numbers({origin.x, origin.y, origin.z}));
    set.text(0x20, 0x37, "DS", dicom_numbers({x.x, x.y, x.z, y.x, y.y, y.z}));
    return set.text(0x28, 0x30, "DS", dicom_numbers({y_mm, x_mm}));
}

inline std::string padded(std::string text, std::size_t size) {
    text.resize(size, '\0');
    return text;
}

/// A field of a Siemens CSA header ("SV10"), whose items are texts.
inline std::string csa_field(const std::string& name, const std::vector<std::string>& items) {
    std::string bytes =
        padded(name, 64) + bytes_of<std::int32_t>(1) + padded("FD", 4) + bytes_of<std::int32_t>(4) +
        bytes_of(static_cast<std::int32_t>(items.size())) + bytes_of<std::int32_t>(77);
    for (const std::string& item : items) {
        const auto length = static_cast<std::int32_t>(item.size() + 1);
        bytes += bytes_of(std::vector<std::int32_t>{length, length, 77, length}) +
                 padded(item, (item.size() + 4) / 4 * 4);
    }
    return bytes;
}

inline std::string csa_header(const std::vector<std::string>& fields) {
    std::string bytes = std::string("SV10\4\3\2\1") +
                        bytes_of(static_cast<std::uint32_t>(fields.size())) +
                        bytes_of<std::uint32_t>(77);
    for (const std::string& field : fields) {
        bytes += field;
    }
    return bytes.size() % 2 == 0 ? bytes : bytes + '\0';
}

/// Four tiles of 3x2 voxels, of which the first three are slices. Tile t holds 10 t + 0 to 5.
inline DicomSet mosaic() {
    constexpr int tile_columns = 3, tile_rows = 2, across = 2;
    std::vector<std::int16_t> values;
    for (int row = 0; row < across * tile_rows; ++row) {
        for (int column = 0; column < across * tile_columns; ++column) {
            const int tile = row / tile_rows * across + column / tile_columns;
            values.push_back(static_cast<std::int16_t>(10 * tile + row % tile_rows * tile_columns +
                                                       column % tile_columns));
        }
    }
    DicomSet set = dicom_image(across * tile_columns, across * tile_rows, bytes_of(values));
    set.text(8, 8, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC").text(8, 0x60, "CS", "MR");
    dicom_place(set, {1, 2, 3}, {1, 0, 0}, {0, 1, 0}, 2, 4);
    set.text(0x18, 0x88, "DS", "5").text(0x29, 0x10, "LO", "SIEMENS CSA HEADER");
    return set.put(0x29, 0x1010, "OB",
                   csa_header({csa_field("EchoLinePosition", {"64"}),
                               csa_field("NumberOfImagesInMosaic", {"3"}),
                               csa_field("SliceNormalVector", {"0.0", "0.0", "1.0"})}));
}

}  // namespace pxpl5::test
