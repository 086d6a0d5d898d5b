// NIfTI-1 and Analyze 7.5 headers: 348 bytes of either byte order, perhaps compressed.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>

#include "host/io/header_text.hpp"
#include "host/io/import.hpp"
#include "host/io/inflated_size.hpp"
#include "host/io/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t nifti1_bytes = 348;
constexpr std::int32_t nifti2_bytes = 540;

struct GzClose {
    void operator()(gzFile_s* file) const { gzclose(file); }
};

/// The header's bytes with typed, byte-swapped access. Offsets are those of nifti1.h.
class RawHeader {
  public:
    explicit RawHeader(const fs::path& path) {
        // gzopen reads plain files too.
        const std::unique_ptr<gzFile_s, GzClose> file(gzopen(path.c_str(), "rb"));
        const int got = file ? gzread(file.get(), bytes_.data(), nifti1_bytes) : -1;
        if (got != static_cast<int>(nifti1_bytes)) {
            throw ImportError(fmt::format("{}: its header needs {} bytes, {} could be read",
                                          path.string(), nifti1_bytes, std::max(got, 0)));
        }
        swapped_ = at<std::int32_t>(0) != static_cast<std::int32_t>(nifti1_bytes);
        const std::int32_t size = at<std::int32_t>(0);
        if (size == nifti2_bytes || at<std::int32_t>(0, !swapped_) == nifti2_bytes) {
            throw ImportError(path.string() +
                              ": is NIfTI-2 (header of 540 bytes), only NIfTI-1 "
                              "(348) is read");
        }
        if (size != static_cast<std::int32_t>(nifti1_bytes)) {
            throw ImportError(
                fmt::format("{}: sizeof_hdr is {}, must be {} in one of the byte orders",
                            path.string(), at<std::int32_t>(0, false), nifti1_bytes));
        }
    }

    template <typename T>
    T at(std::size_t offset) const {
        return at<T>(offset, swapped_);
    }
    std::string magic() const { return {bytes_.data() + 344, strnlen(bytes_.data() + 344, 4)}; }

  private:
    template <typename T>
    T at(std::size_t offset, bool swapped) const {
        std::array<char, sizeof(T)> raw{};
        std::memcpy(raw.data(), bytes_.data() + offset, sizeof(T));
        if (swapped) {
            std::reverse(raw.begin(), raw.end());
        }
        return std::bit_cast<T>(raw);
    }
    std::array<char, nifti1_bytes> bytes_{};
    bool swapped_ = false;
};

struct NiftiType {
    std::int16_t code;
    const char* name;
    std::uint64_t bytes;
};
constexpr std::array nifti_types = {NiftiType{2, "uint8", 1},    NiftiType{4, "int16", 2},
                                    NiftiType{8, "int32", 4},    NiftiType{16, "float32", 4},
                                    NiftiType{64, "float64", 8}, NiftiType{256, "int8", 1},
                                    NiftiType{512, "uint16", 2}, NiftiType{768, "uint32", 4},
                                    NiftiType{1024, "int64", 8}, NiftiType{1280, "uint64", 8}};

void read_type(const std::string& file, const RawHeader& raw, StoredHeader& header) {
    const auto code = raw.at<std::int16_t>(70);
    for (const NiftiType& type : nifti_types) {
        if (type.code == code) {
            header.type = type.name;
            header.value_bytes = type.bytes;
            return;
        }
    }
    throw ImportError(
        fmt::format("{}: datatype is {}, must be one of the scalar types 2, 4, 8, 16, "
                    "64, 256, 512, 768, 1024, 1280",
                    file, code));
}

void read_sizes(const std::string& file, const RawHeader& raw, StoredHeader& header) {
    const auto axes = raw.at<std::int16_t>(40);
    if (axes < 1 || axes > 7) {
        throw ImportError(fmt::format("{}: dim[0] is {}, must be 1 to 7", file, axes));
    }
    for (std::int16_t axis = 1; axis <= axes; ++axis) {
        const auto size = raw.at<std::int16_t>(40 + 2 * static_cast<std::size_t>(axis));
        if (size < 1) {
            throw ImportError(
                fmt::format("{}: dim[{}] is {}, must be 1 or more", file, axis, size));
        }
        header.sizes.push_back(static_cast<std::uint64_t>(size));
    }
}

void read_spacing(const std::string& file, const RawHeader& raw, StoredHeader& header) {
    for (std::size_t axis = 1; axis <= 3; ++axis) {
        const auto spacing = raw.at<float>(76 + 4 * axis);
        if (!std::isfinite(spacing)) {
            throw ImportError(
                fmt::format("{}: pixdim[{}] is {}, must be finite", file, axis, spacing));
        }
        header.spacing_stated = header.spacing_stated && spacing != 0;
    }
}

/// Values beside the header file: x.hdr belongs to x.img.
fs::path image_file(const fs::path& path) {
    std::string name = path.string();
    const std::size_t at = lower_case(name).rfind(".hdr");
    if (at == std::string::npos) {
        return path;
    }
    name.replace(at, 4, lower_case(name).substr(at) == name.substr(at) ? ".img" : ".IMG");
    const bool has_gz = name.ends_with(".gz");
    const std::string other = has_gz ? name.substr(0, name.size() - 3) : name + ".gz";
    return !fs::exists(name) && fs::exists(other) ? other : name;
}

/// The header beside the values: x.img belongs to x.hdr.
fs::path header_file(const fs::path& path) {
    std::string name = path.string();
    const std::size_t at = lower_case(name).rfind(".img");
    if (at == std::string::npos) {
        return path;
    }
    name.replace(at, 4, lower_case(name).substr(at) == name.substr(at) ? ".hdr" : ".HDR");
    const bool has_gz = name.ends_with(".gz");
    const std::string other = has_gz ? name.substr(0, name.size() - 3) : name + ".gz";
    return !fs::exists(name) && fs::exists(other) ? other : name;
}

void locate_data(const fs::path& path, const RawHeader& raw, bool single, StoredHeader& header) {
    const auto offset = raw.at<float>(108);
    if (!std::isfinite(offset) || offset < 0 || (single && offset < nifti1_bytes)) {
        throw ImportError(fmt::format("{}: vox_offset is {}, must be {} or more", path.string(),
                                      offset, single ? nifti1_bytes : 0));
    }
    header.data_file = single ? path : image_file(header_file(path));
    header.storage = header.data_file.extension() == ".gz" ? Storage::compressed : Storage::raw;
    header.data_offset_bytes =
        header.storage == Storage::raw ? static_cast<std::uint64_t>(offset) : 0;
}

/// The decoder reads zeros past the end of a cut file, so the size is checked here.
void check_gzip(const std::string& file, const StoredHeader& header, std::uint64_t offset) {
    const std::uint64_t needed = offset + needed_bytes(header);
    // The size at the end is right in every whole file of one stream, and quick to read.
    if (stated_gzip_bytes(header.data_file) != static_cast<std::uint32_t>(needed)) {
        check_inflated(file, header, 0, needed);
    }
}

void note_place(const RawHeader& raw, bool analyze, StoredHeader& header) {
    if (analyze) {
        header.notes.emplace_back(
            "Analyze 7.5 states no patient space: the orientation is a guess, "
            "left and right may be swapped");
        return;
    }
    if (raw.at<std::int16_t>(252) <= 0 && raw.at<std::int16_t>(254) <= 0) {
        header.notes.emplace_back(
            "qform_code and sform_code are 0: the orientation is a guess, "
            "left and right may be swapped");
    }
    if (((static_cast<unsigned>(raw.at<char>(123)) & 7U)) == 0) {
        header.notes.emplace_back("xyzt_units states no unit of length: read as millimetres");
    }
}

}  // namespace

StoredHeader read_nifti_header(const fs::path& path) {
    const std::string file = path.string();
    const RawHeader raw(header_file(path));
    const bool single = raw.magic() == "n+1";
    const bool pair = raw.magic() == "ni1";
    const std::string name = lower_case(path.filename().string());
    const bool named_single = name.ends_with(".nii") || name.ends_with(".nii.gz");
    if (named_single && !single) {
        throw ImportError(fmt::format("{}: magic is '{}', must be 'n+1'", file, raw.magic()));
    }
    StoredHeader header;
    read_sizes(file, raw, header);
    read_type(file, raw, header);
    read_spacing(file, raw, header);
    locate_data(path, raw, single, header);
    check_stored_header(path, header);
    if (header.storage == Storage::compressed) {
        check_gzip(file, header, static_cast<std::uint64_t>(raw.at<float>(108)));
    }
    note_place(raw, !single && !pair, header);
    const auto slope = raw.at<float>(112), intercept = raw.at<float>(116);
    const bool is_scaled = slope != 0 && (slope != 1 || intercept != 0) && (single || pair);
    header.scaled_integers = is_scaled && header.type.find("int") != std::string::npos;
    if (is_scaled) {
        header.notes.push_back(fmt::format("stored {} values are scaled by {} and shifted by {}",
                                           header.type, slope, intercept));
    }
    return header;
}

}  // namespace pxpl5::host::io
