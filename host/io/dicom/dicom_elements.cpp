#include "host/io/dicom/dicom_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

std::string bytes_of(const gdcm::DataSet& data, gdcm::Tag tag) {
    if (!data.FindDataElement(tag)) {
        return {};
    }
    const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
    if (bytes == nullptr || bytes->GetPointer() == nullptr) {
        return {};
    }
    return {bytes->GetPointer(), bytes->GetLength()};
}

std::string text_of(const gdcm::DataSet& data, gdcm::Tag tag) {
    const std::string text = bytes_of(data, tag);
    const std::size_t first = text.find_first_not_of(" \t");
    const std::size_t last = text.find_last_not_of(std::string(" \t\0", 3));
    return first == std::string::npos || last == std::string::npos || last < first
               ? std::string()
               : text.substr(first, last - first + 1);
}

std::vector<double> numbers_of(const std::string& file, const gdcm::DataSet& data, gdcm::Tag tag) {
    std::string text = text_of(data, tag);
    std::replace(text.begin(), text.end(), '\\', ' ');
    return numbers(file, fmt::format("({:04x},{:04x})", tag.GetGroup(), tag.GetElement()), text);
}

int unsigned_of(const gdcm::DataSet& data, gdcm::Tag tag) {
    const std::string bytes = bytes_of(data, tag);
    std::uint16_t value = 0;
    if (bytes.size() >= sizeof value) {
        std::memcpy(&value, bytes.data(), sizeof value);
    }
    return value;
}

}  // namespace pxpl5::host::io
