#include "host/io/dicom/dicom_structure.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t first_element = 132;  // After the preamble and "DICM".
constexpr std::uint32_t undefined = 0xffffffff;
constexpr int max_depth = 32;
constexpr std::uint64_t max_elements =
    20'000'000;  // Enough for an enhanced file with elements per frame.

constexpr std::uint32_t tag(std::uint32_t group, std::uint32_t element) {
    return group << 16U | element;
}
constexpr std::uint32_t item = tag(0xfffe, 0xe000), item_end = tag(0xfffe, 0xe00d),
                        sequence_end = tag(0xfffe, 0xe0dd), pixel_data = tag(0x7fe0, 0x0010),
                        transfer_syntax = tag(0x0002, 0x0010);

constexpr std::array short_vrs = {"AE", "AS", "AT", "CS", "DA", "DS", "DT", "FL", "FD", "IS", "LO",
                                  "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"};
constexpr std::array long_vrs = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                 "SV", "UC", "UN", "UR", "UT", "UV"};

/// Elements that GDCM reads by their type alone: it asserts where a file states another one.
struct Typed {
    std::uint32_t tag = 0;
    std::string_view vr;
};
constexpr std::array typed_elements = {
    Typed{tag(0x0018, 0x0050), "DS"}, Typed{tag(0x0018, 0x0088), "DS"},
    Typed{tag(0x0018, 0x1164), "DS"}, Typed{tag(0x0020, 0x0032), "DS"},
    Typed{tag(0x0020, 0x0037), "DS"}, Typed{tag(0x0028, 0x0002), "US"},
    Typed{tag(0x0028, 0x0004), "CS"}, Typed{tag(0x0028, 0x0006), "US"},
    Typed{tag(0x0028, 0x0008), "IS"}, Typed{tag(0x0028, 0x0010), "US"},
    Typed{tag(0x0028, 0x0011), "US"}, Typed{tag(0x0028, 0x0030), "DS"},
    Typed{tag(0x0028, 0x0100), "US"}, Typed{tag(0x0028, 0x0101), "US"},
    Typed{tag(0x0028, 0x0102), "US"}, Typed{tag(0x0028, 0x0103), "US"},
    Typed{tag(0x0028, 0x1052), "DS"}, Typed{tag(0x0028, 0x1053), "DS"},
    Typed{tag(0x3004, 0x000c), "DS"},
};

template <std::size_t count>
bool is_one_of(std::string_view vr, const std::array<const char*, count>& vrs) {
    return std::find(vrs.begin(), vrs.end(), vr) != vrs.end();
}

/// A file's bytes, mapped: only the pages that are looked at are read.
class MappedFile {
  public:
    explicit MappedFile(const fs::path& path) {
        const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
        struct stat status {};
        if (file >= 0 && fstat(file, &status) == 0 && status.st_size > 0) {
            size_ = static_cast<std::size_t>(status.st_size);
            data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
        }
        if (file >= 0) {
            close(file);
        }
        if (data_ == MAP_FAILED) {
            throw ImportError(path.string() + ": cannot be opened");
        }
    }
    ~MappedFile() { munmap(data_, size_); }
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    std::string_view bytes() const { return {static_cast<const char*>(data_), size_}; }

  private:
    void* data_ = MAP_FAILED;
    std::size_t size_ = 0;
};

struct Element {
    std::uint32_t tag = 0;
    std::string_view vr;  ///< Empty where it is implicit.
    std::uint32_t length = 0;
    std::uint64_t begin = 0, value = 0;  ///< Where it and its value begin.
};

class Walker {
  public:
    Walker(std::string file, std::string_view bytes) : file_(std::move(file)), bytes_(bytes) {}

    PixelBytes walk() {
        is_explicit_ = true;
        std::uint64_t at = first_element;
        std::string syntax;
        while (at + 8 <= bytes_.size() && bytes_.substr(at, 2) == std::string_view("\2\0", 2)) {
            const Element element = read(at, bytes_.size());
            require_value(element, bytes_.size());
            require_meta_type(element, at == first_element);
            if (element.tag == transfer_syntax) {
                syntax = bytes_.substr(element.value, element.length);
                syntax = syntax.substr(0, syntax.find('\0'));
            }
            at = element.value + element.length;
        }
        if (syntax.empty()) {
            throw ImportError(file_ +
                              ": its meta information states no transfer syntax "
                              "(0002,0010)");
        }
        if (at + 8 > bytes_.size()) {
            throw ImportError(file_ + ": ends with its meta information, without a data set");
        }
        is_big_endian_ = trimmed(syntax) == "1.2.840.10008.1.2.2";
        is_explicit_ = trimmed(syntax) != "1.2.840.10008.1.2";
        if (trimmed(syntax) != "1.2.840.10008.1.2.1.99") {
            walk_elements(at, bytes_.size(), 0);
        }
        return pixels_;
    }

  private:
    template <typename T>
    T number(std::uint64_t at) const {
        T value = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i) {
            const auto byte =
                static_cast<unsigned char>(bytes_[at + (is_big_endian_ ? i : sizeof(T) - 1 - i)]);
            value = static_cast<T>(static_cast<std::uint64_t>(value) << 8U | byte);
        }
        return value;
    }

    [[noreturn]] void fail(const Element& element, const std::string& what) const {
        throw ImportError(fmt::format("{}: element ({:04x},{:04x}) at byte {} {}", file_,
                                      element.tag >> 16U, element.tag & 0xffffU, element.begin,
                                      what));
    }

    /// The head of the element at `at`; it must end at `end` or before.
    Element read(std::uint64_t at, std::uint64_t end) {
        if (++elements_ > max_elements) {
            throw ImportError(fmt::format("{}: has more than {} elements", file_, max_elements));
        }
        Element element;
        element.begin = at;
        if (at + 8 > end) {
            throw ImportError(fmt::format("{}: an element at byte {} needs 8 bytes, {} are left",
                                          file_, at, end - at));
        }
        element.tag = tag(number<std::uint16_t>(at), number<std::uint16_t>(at + 2));
        if (element.tag == item || element.tag == item_end || element.tag == sequence_end ||
            !is_explicit_) {
            element.length = number<std::uint32_t>(at + 4);
            element.value = at + 8;
            return element;
        }
        element.vr = bytes_.substr(at + 4, 2);
        require_type(element);
        if (is_one_of(element.vr, short_vrs)) {
            element.length = number<std::uint16_t>(at + 6);
            element.value = at + 8;
            return element;
        }
        if (!is_one_of(element.vr, long_vrs)) {
            return read_implicit(element, end);
        }
        if (at + 12 > end) {
            fail(element, fmt::format("needs 12 bytes, {} are left", end - at));
        }
        element.length = number<std::uint32_t>(at + 8);
        element.value = at + 12;
        return element;
    }

    void require_type(const Element& element) const {
        const auto* typed = std::ranges::lower_bound(typed_elements, element.tag, {}, &Typed::tag);
        const bool is_known = is_one_of(element.vr, short_vrs) ||
                              (is_one_of(element.vr, long_vrs) && element.vr != "UN");
        if (is_known && typed != typed_elements.end() && typed->tag == element.tag &&
            typed->vr != element.vr) {
            fail(element, fmt::format("is of type {} instead of {}", element.vr, typed->vr));
        }
    }

    /// GDCM reads all meta information as its first element, and asserts where that leads nowhere.
    void require_meta_type(const Element& element, bool is_first) {
        is_meta_implicit_ = is_first ? element.vr.empty() : is_meta_implicit_;
        if (is_meta_implicit_ && !element.vr.empty()) {
            fail(element,
                 fmt::format("states the type {}, but the first element states none", element.vr));
        }
        if (element.vr == "SQ") {
            fail(element, "is a sequence, which meta information cannot have");
        }
    }

    /// Some writers put implicit elements among explicit ones; what does not even fit is broken.
    Element read_implicit(Element element, std::uint64_t end) const {
        element.length = number<std::uint32_t>(element.begin + 4);
        element.value = element.begin + 8;
        if (element.length > end - element.value) {
            fail(element,
                 fmt::format("is of type '{}', which DICOM does not know", shown(element.vr)));
        }
        element.vr = {};
        return element;
    }

    void require_value(const Element& element, std::uint64_t end) const {
        if (element.length > end - element.value) {
            fail(element, fmt::format("has a length of {} bytes, {} are left", element.length,
                                      end - element.value));
        }
    }

    /// The elements of a data set. Without an end of its own it ends with an item's end.
    /// Returns where it ends.
    std::uint64_t walk_elements(std::uint64_t at, std::uint64_t end, int depth) {
        while (at < end) {
            const Element element = read(at, end);
            if (element.tag == item_end) {
                if (depth == 0) {
                    fail(element, "ends an item, but stands in none");
                }
                return element.value;
            }
            const bool is_pixels = depth == 0 && element.tag == pixel_data;
            if (is_pixels && element.length != undefined) {
                if (pixels_.offset_bytes != 0) {
                    fail(element, "stands in the file twice");
                }
                // Fewer pixels than stated: who knows the picture's size says so.
                pixels_ = {element.length, end - element.value, element.value};
                at = element.value + std::min<std::uint64_t>(element.length, end - element.value);
            } else if (element.length == undefined) {
                at = walk_items(element, end, is_pixels, depth + 1);
            } else {
                require_value(element, end);
                if (element.vr == "SQ") {
                    walk_items_of(element, depth + 1);
                }
                at = element.value + element.length;
            }
        }
        return at;
    }

    /// The items of a sequence, or the fragments of pixels, up to the end mark.
    std::uint64_t walk_items(const Element& sequence, std::uint64_t end, bool fragments,
                             int depth) {
        check_depth(sequence, depth);
        // What an unknown sequence holds is implicit by the standard (CP-246).
        const bool was_explicit = is_explicit_;
        is_explicit_ = is_explicit_ && sequence.vr != "UN";
        std::uint64_t at = sequence.value;
        while (true) {
            if (at + 8 > end) {
                fail(sequence, "has no end: the file is cut");
            }
            const Element next = read(at, end);
            if (next.tag == sequence_end) {
                is_explicit_ = was_explicit;
                return next.value;
            }
            at = walk_item(next, end, fragments, depth);
        }
    }

    /// The items of a sequence of stated length.
    void walk_items_of(const Element& sequence, int depth) {
        check_depth(sequence, depth);
        const std::uint64_t end = sequence.value + sequence.length;
        for (std::uint64_t at = sequence.value; at < end;) {
            const Element next = read(at, end);
            if (next.tag == sequence_end) {
                return;
            }
            at = walk_item(next, end, false, depth);
        }
    }

    std::uint64_t walk_item(const Element& next, std::uint64_t end, bool fragment, int depth) {
        if (next.tag != item) {
            fail(next, "stands where an item of a sequence must be");
        }
        if (next.length == undefined && !fragment) {
            return walk_elements(next.value, end, depth);
        }
        require_value(next, end);
        if (!fragment) {
            walk_elements(next.value, next.value + next.length, depth);
        }
        return next.value + next.length;
    }

    void check_depth(const Element& sequence, int depth) const {
        if (depth > max_depth) {
            fail(sequence, fmt::format("is nested more than {} deep", max_depth));
        }
    }

    std::string file_;
    std::string_view bytes_;
    bool is_explicit_ = true, is_big_endian_ = false, is_meta_implicit_ = false;
    std::uint64_t elements_ = 0;
    PixelBytes pixels_;
};

}  // namespace

PixelBytes check_dicom_structure(const DicomInput& input) {
    if (input.bytes) {
        return Walker(input.path.string(), *input.bytes).walk();
    }
    const MappedFile file(input.path);
    return Walker(input.path.string(), file.bytes()).walk();
}

}  // namespace pxpl5::host::io
