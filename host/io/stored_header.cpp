#include "host/io/stored_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "host/io/header_text.hpp"
#include "host/io/import.hpp"
#include "host/io/inflated_size.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t max_compression_ratio = 1032;  // Deflate's best.
constexpr std::uint64_t min_ascii_bytes = 2;           // A digit and a separator.

bool ends_with_any(const std::string& name, std::initializer_list<const char*> suffixes) {
    return std::any_of(suffixes.begin(), suffixes.end(),
                       [&](const char* suffix) { return name.ends_with(suffix); });
}

Format format_by_content(const fs::path& path) {
    std::array<char, 132> head{};
    std::ifstream(path, std::ios::binary).read(head.data(), head.size());
    const std::string_view bytes(head.data(), head.size());
    if (bytes.starts_with("NRRD000")) {
        return Format::nrrd;
    }
    if (bytes.starts_with("# vtk DataFile")) {
        return Format::vtk;
    }
    if (bytes.substr(128, 4) == "DICM") {
        return Format::dicom;
    }
    throw ImportError(fmt::format(
        "{}: neither its suffix nor its first bytes are of a known format (.nrrd .nhdr .mha .mhd "
        ".nii .nii.gz .hdr .img .vtk .dcm, or the folder of a DICOM series)",
        path.string()));
}

/// The stated sizes without the ones at the end, e.g. the one time step of a NIfTI volume.
std::vector<std::uint64_t> significant(std::vector<std::uint64_t> sizes) {
    while (sizes.size() > 3 && sizes.back() == 1) {
        sizes.pop_back();
    }
    return sizes;
}

void check_sizes(const std::string& file, const StoredHeader& header) {
    const std::vector<std::uint64_t> sizes = significant(header.sizes);
    if (sizes.size() != 3) {
        throw ImportError(fmt::format("{}: has {} axes ({}), a volume has 3{}", file, sizes.size(),
                                      join_sizes(sizes),
                                      sizes.size() < 3 ? ""
                                                       : ": time series and colour are not "
                                                         "read"));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (sizes[axis] < min_dim || sizes[axis] > max_dim) {
            throw ImportError(fmt::format("{}: {} voxels along {}, must be {} to {}", file,
                                          sizes[axis], "xyz"[axis], min_dim, max_dim));
        }
    }
}

/// More bytes than stated often mean another type or size than stated.
void note_rest(std::uint64_t available, std::uint64_t needed, StoredHeader& header) {
    if (header.ends_file && header.storage == Storage::raw && available > needed) {
        header.notes.push_back(fmt::format("{} holds {} bytes more than the header states",
                                           header.data_file.filename().string(),
                                           available - needed));
    }
}

void check_data_file(const std::string& file, StoredHeader& header) {
    std::error_code failure;
    const std::uint64_t file_bytes = fs::file_size(header.data_file, failure);
    if (failure) {
        throw ImportError(fmt::format("{}: its data file {} cannot be read: {}", file,
                                      header.data_file.string(), failure.message()));
    }
    const std::uint64_t available = file_bytes - std::min(file_bytes, header.data_offset_bytes);
    const std::uint64_t needed = needed_bytes(header);
    const std::uint64_t values = needed / header.value_bytes;
    const bool enough = header.storage == Storage::raw ? available >= needed
                        : header.storage == Storage::ascii
                            ? available + 1 >= values * min_ascii_bytes
                            : needed / max_compression_ratio <= available;
    if (!enough) {
        throw ImportError(fmt::format(
            "{}: {} of {} need {} bytes{}, {} has {}", file, join_sizes(header.sizes), header.type,
            header.storage == Storage::ascii ? values * min_ascii_bytes - 1 : needed,
            header.storage == Storage::compressed ? " when decompressed" : "",
            header.data_file.filename().string(), available));
    }
    note_rest(available, needed, header);
}

}  // namespace

std::uint64_t needed_bytes(const StoredHeader& header) {
    std::uint64_t bytes = header.value_bytes;
    for (const std::uint64_t size : header.sizes) {
        bytes *= size;  // Cannot overflow: sizes have been checked against max_dim.
    }
    return bytes;
}

void check_inflated(const std::string& file, const StoredHeader& header, std::uint64_t offset_bytes,
                    std::uint64_t needed) {
    const std::uint64_t got = inflated_bytes(header.data_file, offset_bytes, needed);
    if (got < needed) {
        throw ImportError(fmt::format("{}: {} of {} need {} bytes when decompressed, {} has {}",
                                      file, join_sizes(header.sizes), header.type, needed,
                                      header.data_file.filename().string(), got));
    }
}

std::string join_sizes(const std::vector<std::uint64_t>& sizes) {
    return fmt::format("{}", fmt::join(sizes, "x"));
}

Format format_of(const fs::path& path) {
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!fs::exists(status)) {
        throw ImportError(fmt::format("{}: {}", path.string(), failure.message()));
    }
    if (fs::is_directory(status)) {
        return Format::dicom;
    }
    if (!fs::is_regular_file(status) || !std::ifstream(path)) {
        throw ImportError(path.string() + ": is not a readable file");
    }
    const std::string name = lower_case(path.filename().string());
    if (ends_with_any(name, {".nrrd", ".nhdr"})) {
        return Format::nrrd;
    }
    if (ends_with_any(name, {".mha", ".mhd"})) {
        return Format::meta_image;
    }
    if (ends_with_any(name, {".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"})) {
        return Format::nifti;
    }
    if (ends_with_any(name, {".vtk"})) {
        return Format::vtk;
    }
    return ends_with_any(name, {".dcm", ".ima"}) ? Format::dicom : format_by_content(path);
}

void check_stored_header(const fs::path& path, StoredHeader& header) {
    const std::string file = path.string();
    check_sizes(file, header);
    if (needed_bytes(header) > max_volume_bytes) {
        throw ImportError(fmt::format("{}: {} of {} need {} bytes, at most {} are read", file,
                                      join_sizes(header.sizes), header.type, needed_bytes(header),
                                      max_volume_bytes));
    }
    if (header.storage != Storage::unchecked) {
        check_data_file(file, header);
    }
}

}  // namespace pxpl5::host::io
