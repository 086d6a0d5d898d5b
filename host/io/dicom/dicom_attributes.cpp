#include "host/io/dicom/dicom_attributes.hpp"

#include <fmt/format.h>
#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "host/io/dicom/dicom_elements.hpp"
#include "host/io/dicom/dicom_structure.hpp"
#include "host/io/values/file_at_work.hpp"

namespace pxpl5::host::io {

namespace {

const gdcm::Tag pixel_data(0x7fe0, 0x0010), charset_tag(0x0008, 0x0005), pixel_sign(0x0028, 0x0103);

constexpr std::size_t max_text_bytes = std::size_t{1} << 19;  ///< All values of a file.
constexpr char escape = '\x1b';  ///< Begins a switch to another character set (ISO 2022).

/// Length of the UTF-8 sequence at the beginning, 0 if there is none.
std::size_t sequence_length(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xc2 && lead < 0xe0 ? 2
                               : lead >= 0xe0 && lead < 0xf0 ? 3
                               : lead >= 0xf0 && lead < 0xf5 ? 4
                                                             : 0;
    if (length == 0 || length > text.size()) {
        return 0;
    }
    const auto second = static_cast<unsigned char>(length > 1 ? text[1] : 0x80);
    // Longer forms than needed, surrogates, and values beyond Unicode.
    if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) ||
        (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f)) {
        return 0;
    }
    const bool follows = std::ranges::all_of(text.substr(1, length - 1), [](char c) {
        return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
    });
    return follows ? length : 0;
}

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = sequence_length(text);
        if (length == 0) {
            return false;
        }
        text.remove_prefix(length);
    }
    return true;
}

/// At most max_value_chars characters.
std::string cut(const std::string& text, bool& is_cut) {
    std::size_t chars = 0, at = 0;
    for (; at < text.size() && chars < max_value_chars; ++chars) {
        at += std::max<std::size_t>(1, sequence_length(std::string_view(text).substr(at)));
    }
    is_cut |= at < text.size();
    return text.substr(0, at);
}

/// Two numbers of 16 bits: the tag of another attribute.
struct TagValue {
    std::uint16_t group, element;
};

std::string number_text(TagValue value) {
    return fmt::format("({:04x},{:04x})", value.group, value.element);
}
template <typename T>
std::string number_text(T value) {
    return fmt::format("{}", value);
}

/// The values of a binary element, "1\2\3" as DICOM separates texts.
template <typename T>
std::string numbers_text(const std::string& bytes) {
    std::string text;
    for (std::size_t at = 0; at + sizeof(T) <= bytes.size() && text.size() <= max_value_chars;
         at += sizeof(T)) {
        T value{};
        std::memcpy(&value, bytes.data() + at, sizeof value);
        text += (at == 0 ? "" : "\\") + number_text(value);
    }
    return text;
}

/// The representation that the dictionary gives. Where it is one of two, the sign of the pixels
/// decides: files without representations (implicit little endian) do not say.
gdcm::VR known_vr(gdcm::VR vr, const gdcm::DataSet& data) {
    if (vr == gdcm::VR::US_SS) {
        return unsigned_of(data, pixel_sign) == 1 ? gdcm::VR::SS : gdcm::VR::US;
    }
    return vr.IsDual() ? gdcm::VR(gdcm::VR::OW) : vr;
}

/// The text of a value whose representation is binary; nothing for text.
std::optional<std::string> binary_text(gdcm::VR vr, const std::string& bytes) {
    switch (static_cast<gdcm::VR::VRType>(vr)) {
        case gdcm::VR::AT:
            return numbers_text<TagValue>(bytes);
        case gdcm::VR::US:
            return numbers_text<std::uint16_t>(bytes);
        case gdcm::VR::SS:
            return numbers_text<std::int16_t>(bytes);
        case gdcm::VR::UL:
            return numbers_text<std::uint32_t>(bytes);
        case gdcm::VR::SL:
            return numbers_text<std::int32_t>(bytes);
        case gdcm::VR::FL:
            return numbers_text<float>(bytes);
        case gdcm::VR::FD:
            return numbers_text<double>(bytes);
        default:
            break;
    }
    return gdcm::VR::IsASCII(vr) ? std::nullopt
                                 : std::optional(fmt::format("{} bytes", bytes.size()));
}

std::string items_text(std::size_t count) {
    return fmt::format("{} item{}", count, count == 1 ? "" : "s");
}

class Attributes {
  public:
    explicit Attributes(std::string charset) : charset_(std::move(charset)) {}

    void add_all(const gdcm::DataSet& data, int depth) {
        for (const gdcm::DataElement& element : data.GetDES()) {
            if (found.all.size() == max_dicom_attributes || text_bytes_ > max_text_bytes) {
                found.is_whole = false;
                return;
            }
            add(data, element, depth);
        }
    }

    DicomAttributes found;

  private:
    void add(const gdcm::DataSet& data, const gdcm::DataElement& element, int depth) {
        const gdcm::Tag& tag = element.GetTag();
        DicomAttribute attribute;
        attribute.group = tag.GetGroup();
        attribute.element = tag.GetElement();
        attribute.depth = depth;
        gdcm::VR vr = element.GetVR();
        if (!tag.IsPrivate() && !tag.IsGroupLength()) {
            const gdcm::DictEntry& entry =
                gdcm::Global::GetInstance().GetDicts().GetPublicDict().GetDictEntry(tag);
            const char* keyword = entry.GetKeyword();
            attribute.keyword = keyword == nullptr ? "" : keyword;
            if (vr == gdcm::VR::INVALID || vr == gdcm::VR::UN) {
                vr = known_vr(entry.GetVR(), data);
            }
        }
        const gdcm::SmartPointer<gdcm::SequenceOfItems> items =
            element.GetVR() == gdcm::VR::SQ ? element.GetValueAsSQ() : nullptr;
        attribute.vr = items != nullptr          ? "SQ"
                       : vr == gdcm::VR::INVALID ? "UN"
                                                 : gdcm::VR::GetVRString(vr);
        attribute.value = items != nullptr ? items_text(items->GetNumberOfItems())
                                           : value_of(data, tag, vr, attribute.is_cut);
        text_bytes_ += attribute.value.size();
        found.all.push_back(std::move(attribute));
        if (items == nullptr) {
            return;
        }
        if (depth == max_attribute_depth) {
            found.is_whole &= items->GetNumberOfItems() == 0;
            return;
        }
        for (std::size_t i = 1; i <= items->GetNumberOfItems(); ++i) {
            add_all(items->GetItem(i).GetNestedDataSet(), depth + 1);
        }
    }

    std::string value_of(const gdcm::DataSet& data, gdcm::Tag tag, gdcm::VR vr,
                         bool& is_cut) const {
        if (const std::optional<std::string> text = binary_text(vr, bytes_of(data, tag))) {
            return cut(*text, is_cut);
        }
        return cut(utf8_of(text_of(data, tag), charset_), is_cut);
    }

    std::string charset_;
    std::size_t text_bytes_ = 0;
};

}  // namespace

std::string DicomAttributes::value(std::uint16_t group, std::uint16_t element) const {
    const auto found = std::ranges::find_if(all, [&](const DicomAttribute& each) {
        return each.depth == 0 && each.group == group && each.element == element;
    });
    return found == all.end() ? "" : found->value;
}

std::string utf8_of(std::string bytes, const std::string& charset) {
    if (const std::size_t other = bytes.find(escape); other != std::string::npos) {
        std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(other), bytes.end(), '?');
    }
    if (!is_utf8(bytes)) {
        std::string text;
        for (const char c : bytes) {
            const auto code = static_cast<unsigned char>(c);
            if (code < 0x80) {
                text += c;
            } else if (charset == "ISO_IR 100") {
                text += static_cast<char>(0xc0 | (code >> 6));
                text += static_cast<char>(0x80 | (code & 0x3f));
            } else {
                text += '?';
            }
        }
        bytes = std::move(text);
    }
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        const auto code = static_cast<unsigned char>(bytes[at]);
        if (code < 0x20 || code == 0x7f) {
            bytes[at] = ' ';
        } else if (code == 0xc2 && static_cast<unsigned char>(bytes[at + 1]) < 0xa0) {
            bytes.replace(at, 2, " ");  // U+0080 to U+009F are control characters, too.
        }
    }
    return bytes;
}

DicomAttributes read_attributes(const DicomInput& input) {
    const std::string file = input.path.string();
    (void)check_dicom_structure(input);
    const FileAtWork at_work(file);
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    const std::unique_ptr<std::istream> stream = input.open();
    gdcm::Reader reader;
    reader.SetStream(*stream);
    if (!reader.ReadUpToTag(pixel_data, {pixel_data})) {
        throw ImportError(file + ": its attributes cannot be read: cut or broken");
    }
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    Attributes attributes(text_of(data, charset_tag));
    attributes.add_all(reader.GetFile().GetHeader(), 0);
    attributes.add_all(data, 0);
    return std::move(attributes.found);
}

}  // namespace pxpl5::host::io
