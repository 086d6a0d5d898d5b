#include "host/io/formats/stored_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "generated/vocabulary.hpp"
#include "host/base/part_file.hpp"
#include "host/io/formats/first_bytes.hpp"
#include "host/io/formats/picture_stack.hpp"
#include "host/io/values/frames.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"
#include "isa/nearest.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t max_gzip_ratio = 1032;     // Deflate's best.
constexpr std::uint64_t max_bzip2_ratio = 32'768;  // 900 kB of one byte take 39 bytes.
constexpr std::uint64_t min_ascii_bytes = 2;       // A digit and a separator.
constexpr std::size_t max_axes = 16;

bool ends_with_any(const std::string& name, std::initializer_list<const char*> suffixes) {
    return std::any_of(suffixes.begin(), suffixes.end(),
                       [&](const char* suffix) { return name.ends_with(suffix); });
}

/// Whether the suffix is one of an archive. `name` is in small letters.
bool is_archive_name(const std::string& name) {
    return ends_with_any(name, {".zip", ".tar", ".tgz", ".tar.gz", ".tbz2", ".tar.bz2", ".txz",
                                ".tar.xz", ".tzst", ".tar.zst"});
}

Format format_by_content(const fs::path& path) {
    const std::string bytes = first_bytes(path);
    if (bytes.starts_with("NRRD000")) {
        return Format::nrrd;
    }
    if (bytes.starts_with("# vtk DataFile")) {
        return Format::vtk;
    }
    if (bytes.find("<VTKFile") != std::string_view::npos) {
        return Format::vti;
    }
    if (bytes.substr(128, 4) == "DICM") {
        return Format::dicom;
    }
    if (begins_as_zip(bytes) || begins_as_tar(bytes)) {
        return Format::packed;
    }
    throw ImportError(fmt::format(
        "{}: neither its suffix nor its first bytes are of a known format (.nrrd .nhdr .mha .mhd "
        ".nii .nii.gz .hdr .img .mgh .mgz .vtk .vti .dcm .tif .png .jpg .bmp .zip .tar .tgz, or "
        "the folder of a DICOM series or of pictures); of a file without a header, give "
        "raw=XxYxZ,TYPE and spacing=x,y,z",
        path.string()));
}

/// "; did you mean scan.nii.gz?": the file or folder beside `path` with the nearest name.
std::string nearest_file(const fs::path& path) {
    std::error_code failure;
    std::vector<std::string> names;
    for (fs::directory_iterator at(path.has_parent_path() ? path.parent_path() : ".", failure);
         !failure && at != fs::directory_iterator(); at.increment(failure)) {
        names.push_back(at->path().filename().string());
    }
    std::ranges::sort(names);  // The order of a folder differs between computers.
    const std::vector<std::string_view> views(names.begin(), names.end());
    const std::string wished = path.filename().string();
    const std::string_view best = isa::nearest(wished, views);
    return best.empty() ? "" : fmt::format("; did you mean {}?", best);
}

/// The fewest bytes of a file that can hold `values` values of `needed` bytes.
std::uint64_t least_bytes(Encoding encoding, std::uint64_t needed, std::uint64_t values) {
    switch (encoding) {
        case Encoding::raw:
            return needed;
        case Encoding::ascii:
            return values * min_ascii_bytes - 1;
        case Encoding::hex:
            return 2 * needed;
        case Encoding::base64:
            return base64_chars(needed) - 2;  // Some leave out the padding.
        case Encoding::gzip:
        case Encoding::gzip_base64:
            return needed / max_gzip_ratio;
        case Encoding::bzip2:
            return needed / max_bzip2_ratio;
    }
    return needed;
}

/// Values of one data file must fit in it.
void check_data_file(const fs::path& path, const fs::path& data_file, std::uint64_t needed,
                     StoredHeader& header) {
    const std::string file = path.string();
    const std::uint64_t file_bytes = DataFile(path, data_file, header.allowed).size_bytes();
    const bool is_raw = header.encoding == Encoding::raw;
    const std::uint64_t before =
        header.offset_bytes +
        (is_raw && !header.at_end ? header.byte_skip + header.bytes_before() : 0);
    const std::uint64_t available = file_bytes - std::min(file_bytes, before);
    const std::uint64_t values = needed / component_bytes(header.component);
    const std::uint64_t all = header.frames * needed, behind = header.bytes_behind();
    if (is_raw && header.frames > 1 && available < (header.at_end ? all : needed)) {
        const std::string what =
            header.at_end ? fmt::format("its {} volumes need", header.frames)
                          : fmt::format("volume {} of {} ends after", header.frame, header.frames);
        throw ImportError(fmt::format("{}: {} {} bytes, {} has {}", file, what,
                                      before + (header.at_end ? all : needed),
                                      data_file.filename().string(), file_bytes));
    }
    const std::uint64_t least = least_bytes(header.encoding, needed, values);
    if (available < least && header.encoding == Encoding::ascii) {
        throw ImportError(
            fmt::format("{}: {} values of {} as text need {} bytes or more, {} has {}", file,
                        values, header.type, least, data_file.filename().string(), available));
    }
    if (available < least) {
        throw ImportError(fmt::format("{}: {} of {} need {} bytes{}, {} has {}", file,
                                      join_sizes(header.sizes), header.type,
                                      is_compressed(header.encoding) ? needed : least,
                                      is_compressed(header.encoding) ? " when decompressed" : "",
                                      data_file.filename().string(), available));
    }
    if (is_raw && available < needed + behind) {
        header.findings.push_back(cut_series(header, data_file, available - needed));
    }
    if (header.ends_file && is_raw && available > needed + behind) {
        // More bytes than stated often mean another type or size than stated.
        header.find(FindingKind::note,
                    fmt::format("{} holds {} bytes more than the header states",
                                data_file.filename().string(), available - needed - behind));
    }
}

/// Sizes without those of 1 after the third.
std::vector<std::uint64_t> significant_sizes(std::vector<std::uint64_t> sizes) {
    while (sizes.size() > 3 && sizes.back() == 1) {
        sizes.pop_back();
    }
    return sizes;
}

}  // namespace

std::uint64_t StoredHeader::bytes_before() const {
    return (frame - 1) * needed_bytes(*this);
}

std::uint64_t StoredHeader::bytes_behind() const {
    return (frames - frame) * needed_bytes(*this);
}

Finding cut_series(const StoredHeader& header, const fs::path& data_file,
                   std::uint64_t bytes_there) {
    const std::uint64_t last = header.frame + bytes_there / needed_bytes(header);
    return {FindingKind::missing_volumes,
            fmt::format("{} ends after volume {} of {}: the file is cut off, and the later volumes "
                        "cannot be shown. curve and cine need to={}",
                        data_file.filename().string(), last, header.frames, last)};
}

void take_frames(const std::string& file, std::uint32_t frame, FourthAxis axis,
                 StoredHeader& header) {
    const std::vector<std::uint64_t> sizes = significant_sizes(header.sizes);
    const bool is_series = sizes.size() == 4;
    const std::uint64_t frames = is_series ? sizes[3] : 1;
    if (!is_series) {
        volume_dims(file, header.sizes);
    }
    // The bytes of too many could not be counted.
    check_frame(file, "file", frame, frames);
    if (!is_series) {
        return;
    }
    header.sizes.resize(3);
    volume_dims(file, header.sizes);
    if (frame == 0 && axis == FourthAxis::unknown) {
        throw ImportError(
            fmt::format("{}: has 4 axes ({}). If it is a time series, select a volume with "
                        "frame=N, 1 to {}. Vectors and color are not read",
                        file, join_sizes(sizes), frames));
    }
    header.frames = frames;
    header.frame = std::max<std::uint32_t>(frame, 1);
    header.series_frame = static_cast<int>(header.frame);
    header.series_frames = static_cast<int>(frames);
    header.find(FindingKind::note,
                fmt::format("volume {} of {} of a time series", header.frame, frames));
}

void drop_single_frame(StoredHeader& header) {
    header.sizes = significant_sizes(std::move(header.sizes));
}

void keep_files_of_frame(const std::string& file, StoredHeader& header) {
    const std::uint64_t files = header.data_files.size();
    if (header.frames == 1 || files == 1) {
        return;
    }
    if (files % header.frames != 0) {
        throw ImportError(
            fmt::format("{}: has {} data files for {} volumes, must have one file, "
                        "or as many for each volume",
                        file, files, header.frames));
    }
    const auto share = static_cast<std::ptrdiff_t>(files / header.frames);
    const auto first =
        header.data_files.begin() + share * static_cast<std::ptrdiff_t>(header.frame - 1);
    header.data_files = {first, first + share};
    header.frames = header.frame = 1;
}

std::array<int, 3> volume_dims(const std::string& file, const std::vector<std::uint64_t>& sizes) {
    std::vector<std::uint64_t> significant = significant_sizes(sizes);
    const bool has_empty = sizes.size() > 3 && (significant[0] < min_volume_voxels ||
                                                significant[1] < min_volume_voxels);
    if (significant.size() < 2 || significant.size() > 3 || has_empty) {
        throw ImportError(fmt::format("{}: has {} axes ({}), a volume has 3{}", file, sizes.size(),
                                      join_sizes(sizes),
                                      sizes.size() < 2 ? "" : ": vectors and color are not read"));
    }
    significant.resize(3, 1);
    std::array<int, 3> dims{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int least = axis < 2 ? min_volume_voxels : 1;
        if (significant[axis] < static_cast<std::uint64_t>(least) ||
            significant[axis] > max_volume_voxels) {
            throw ImportError(fmt::format("{}: {} voxels along {}, must be {} to {}", file,
                                          significant[axis], "xyz"[axis], least,
                                          max_volume_voxels));
        }
        dims[axis] = static_cast<int>(significant[axis]);
    }
    return dims;
}

std::uint64_t needed_bytes(const StoredHeader& header) {
    std::uint64_t bytes = component_bytes(header.component);
    for (const std::uint64_t size : header.sizes) {
        bytes *= size;  // Cannot overflow: sizes have been checked against max_volume_voxels.
    }
    return bytes;
}

std::string join_sizes(const std::vector<std::uint64_t>& sizes) {
    std::string text;
    for (std::size_t axis = 0; axis < std::min(sizes.size(), max_axes); ++axis) {
        text += (axis == 0 ? "" : "x") + std::to_string(sizes[axis]);
    }
    return sizes.size() > max_axes ? text + "x..." : text;
}

Format format_of(const fs::path& path) {
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!fs::exists(status)) {
        throw ImportError(
            fmt::format("{}: {}{}", path.string(), failure.message(), nearest_file(path)));
    }
    if (fs::is_directory(status)) {
        return Format::dicom;
    }
    if (const std::string reason = why_unreadable(path); !reason.empty()) {
        throw ImportError(fmt::format("{}: {}", path.string(), reason));
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
    if (ends_with_any(name, {".mgh", ".mgz", ".mgh.gz"})) {
        return Format::mgh;
    }
    if (ends_with_any(name, {".vtk"})) {
        return Format::vtk;
    }
    if (ends_with_any(name, {".vti"})) {
        return Format::vti;
    }
    if (is_archive_name(name)) {
        return Format::packed;
    }
    if (is_picture(path)) {
        return Format::pictures;
    }
    return ends_with_any(name, {".dcm", ".ima"}) ? Format::dicom : format_by_content(path);
}

bool is_packed(const fs::path& path) {
    try {
        return format_of(path) == Format::packed;
    } catch (const ImportError&) {
        return false;
    }
}

void check_stored_header(const fs::path& path, StoredHeader& header) {
    const std::string file = path.string();
    volume_dims(file, header.sizes);
    constexpr std::uint64_t most_skipped = std::uint64_t{1} << 53;
    for (const std::uint64_t skipped : {header.offset_bytes, header.byte_skip}) {
        if (skipped > most_skipped) {
            throw ImportError(fmt::format("{}: its values begin after {} bytes, must be at most {}",
                                          file, skipped, most_skipped));
        }
    }
    const std::uint64_t needed = needed_bytes(header);
    const std::uint64_t files = header.data_files.size();
    if (!why_not_by_gps(header).empty() ||
        DataFile(path, header.data_files.front(), header.allowed).size_bytes() < needed / files) {
        check_volume_bytes(file, fmt::format("{} of {}", join_sizes(header.sizes), header.type),
                           needed);
    }
    const std::uint64_t values = needed / component_bytes(header.component);
    if (files == 0 || values % files != 0) {
        throw ImportError(fmt::format("{}: its {} values do not divide among {} data files", file,
                                      values, files));
    }
    for (const fs::path& data_file : header.data_files) {
        check_data_file(path, data_file, needed / files, header);
    }
}

std::vector<fs::path> numbered_files(const fs::path& header_file, const std::string& field,
                                     const std::string& text) {
    const std::string file = header_file.string();
    const std::vector<std::string> words = words_of(text);
    if (words.size() < 4 || !is_file_pattern(words[0])) {
        throw ImportError(
            fmt::format("{}: {} '{}' must be LOCAL, LIST, a name, or a pattern with "
                        "one %d, first, last and step",
                        file, field, shown(text)));
    }
    const auto range = numbers(file, field, words[1] + " " + words[2] + " " + words[3]);
    const double first = range[0], last = range[1], step = range[2];
    if (!(step != 0) || !((last - first) / step >= 0) ||
        !((last - first) / step < static_cast<double>(max_data_files))) {
        throw ImportError(
            fmt::format("{}: {} '{}' counts from {} to {} by {}: must be 1 to {} "
                        "files",
                        file, field, shown(text), first, last, step, max_data_files));
    }
    const std::size_t percent = words[0].find('%'), end = words[0].find('d', percent);
    const std::string width_text = words[0].substr(percent + 1, end - percent - 1);
    const std::size_t width = width_text.empty() ? 0 : std::stoul(width_text);
    const char fill = width_text.starts_with('0') ? '0' : ' ';
    std::vector<fs::path> files;
    for (std::size_t i = 0; first + static_cast<double>(i) * step <= std::max(first, last) &&
                            first + static_cast<double>(i) * step >= std::min(first, last);
         ++i) {
        std::string digits =
            std::to_string(static_cast<long long>(first + static_cast<double>(i) * step));
        digits.insert(0, digits.size() < width ? width - digits.size() : 0, fill);
        files.push_back(header_file.parent_path() /
                        (words[0].substr(0, percent) + digits + words[0].substr(end + 1)));
    }
    return files;
}

}  // namespace pxpl5::host::io
