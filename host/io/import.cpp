#include "host/io/import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>

#include "host/base/part_file.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/folder_files.hpp"
#include "host/io/formats/picture_stack.hpp"
#include "host/io/formats/read_header.hpp"
#include "host/io/formats/scan_values.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/place.hpp"
#include "host/io/values/processing.hpp"
#include "host/io/zarr/zarr_image.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host::io {

/// The request for the volumes of a time series, and their files.
struct Importer::Shared {
    ImportRequest request;  ///< Its frame is that of the volume that is read.
    bool later_follow = false;
    std::optional<FolderFiles> folder;
    std::vector<DicomSlice> slices;  ///< All of a DICOM file.
    StoredReader stored;
};

namespace {

namespace fs = std::filesystem;

constexpr const char* other_reader =
    "Load it with read=host, or write it as an uncompressed NRRD, MetaImage or NIfTI file first";

[[noreturn]] void refuse_gps(const std::string& source, const std::string& reason,
                             const std::string& remedy = other_reader) {
    throw ImportError(fmt::format("{}: GPs cannot read the values from this {}: {}. {}", source,
                                  fs::is_directory(source) ? "folder" : "file", reason, remedy));
}

/// The host cannot read larger files either, not even a part.
std::string remedy_for(std::uint64_t needed_bytes) {
    return needed_bytes > max_volume_bytes
               ? fmt::format(
                     "It has {} bytes, and the host reads at most {}. Write it, or the part "
                     "that is needed, to an uncompressed NRRD, MetaImage or NIfTI file first",
                     needed_bytes, max_volume_bytes)
               : other_reader;
}

/// Whether the GPs read the values. Throws ImportError if they are asked to, and cannot.
/// reason  Why they cannot read the files; empty if they can.
bool is_read_by_gps(const std::string& source, std::string reason, std::uint64_t needed_bytes,
                    const ImportRequest& request) {
    if (request.crop_first || request.resample_size || request.resample_spacing_mm ||
        request.smooth_mm != 0) {
        reason = "crop=, resample= and smooth= need all values in the io process";
    }
    if (request.read == ReadBy::gps && !reason.empty()) {
        refuse_gps(source, reason, remedy_for(needed_bytes));
    }
    return request.read == ReadBy::gps || (request.read == ReadBy::automatic && reason.empty() &&
                                           needed_bytes > request.host_bytes);
}

/// The values of the slices, for the GPs.
SeriesVolume scan_series(const std::string& source, OrderedSeries series,
                         const ImportRequest& request) {
    series.result.volume.stored = stored_volume_of(series.slices);
    scan_values({source, {}, request.allowed, request.reduced_bytes}, series.result.volume);
    return std::move(series.result);
}

/// Bytes of all voxels in the host, which decode_series() takes to have 2 bytes or more.
std::uint64_t needed_bytes(const std::vector<DicomSlice>& slices) {
    const DicomSlice& first = slices.front();
    return static_cast<std::uint64_t>(first.columns) * static_cast<std::uint64_t>(first.rows) *
           static_cast<std::uint64_t>(std::max(first.bits / 8, 2)) * slices.size();
}

Volume import_slices(const std::string& source, std::vector<DicomSlice> slices,
                     const ImportRequest& request) {
    DicomPixels pixels;
    const auto decode = [&](const DicomSlice& slice, ValueSink& sink) {
        try {
            pixels.add(slice, sink);
        } catch (const ImportError& error) {
            throw UnreadablePixels(slice.path, error);
        }
    };
    OrderedSeries series = order_series(source, std::move(slices), request);
    const bool by_gps =
        is_read_by_gps(source, why_not_by_gps(series.slices), needed_bytes(series.slices), request);
    auto [volume, stated] = by_gps ? scan_series(source, std::move(series), request)
                                   : decode_series(source, std::move(series), decode);
    take_directions(source, request, {}, volume);
    stated[2] = stated[2] || !request.spacing_mm;  // What is assumed along z was said already.
    take_spacing(source, request, stated, volume);
    return std::move(volume);
}

/// The folder's slices without files that cannot be decoded; later volumes may not lack one.
Volume import_readable(const std::string& source, FolderFiles& files,
                       const ImportRequest& request) {
    constexpr std::size_t max_unreadable = 16;  // Each makes the others be decoded again.
    for (std::size_t unreadable = 0;; ++unreadable) {
        try {
            return import_slices(source, files.slices, request);
        } catch (const UnreadablePixels& error) {
            const auto broken = [&](const DicomSlice& slice) { return slice.path == error.path; };
            const auto first = std::find_if(files.slices.begin(), files.slices.end(), broken);
            const std::string series = first->series;
            std::erase_if(files.slices, broken);
            const bool others_stay =
                std::any_of(files.slices.begin(), files.slices.end(),
                            [&](const DicomSlice& slice) { return slice.series == series; });
            if (unreadable == max_unreadable || !others_stay || request.frame > 1) {
                throw;
            }
            files.left_out.push_back({FindingKind::missing_slices, error.what()});
        }
    }
}

FolderFiles files_of_volume(const fs::path& folder, const ImportRequest& request) {
    const std::string source = folder.string();
    FolderFiles files = look_through(folder, request.allowed);
    if (files.slices.empty() && files.pictures.empty()) {
        throw ImportError(
            files.left_out.empty()
                ? fmt::format("{}: none of its {} files is a DICOM image", source, files.others)
                : files.left_out.front().text);
    }
    const std::size_t pictures = files.pictures.size();
    keep_one_kind(files.pictures);
    files.other_pictures = pictures - files.pictures.size();
    if (files.slices.empty() && request.read == ReadBy::gps) {
        refuse_gps(source, "pictures are decoded by the io process");
    }
    if (files.slices.empty()) {
        refuse_frame(source, request);
    }
    return files;
}

FolderFiles files_of_archive(const std::string& source, const ImportRequest& request) {
    constexpr const char* remedy = "Unpack it, and load the folder or file that holds the volume";
    if (request.read == ReadBy::gps) {
        refuse_gps(source, "its files are packed", remedy);
    }
    FolderFiles files = look_through_archive(source);
    if (files.slices.empty()) {
        const std::string none =
            files.others == 0 ? "there are no files in it"
            : files.others == 1
                ? "the only file in it is no DICOM image"
                : fmt::format("none of the {} files in it is a DICOM image", files.others);
        throw ImportError(files.left_out.empty() ? fmt::format("{}: {}. {}", source, none, remedy)
                                                 : files.left_out.front().text);
    }
    return files;
}

Volume import_archive(const std::string& source, Importer::Shared& shared) {
    if (!shared.folder) {
        shared.folder = files_of_archive(source, shared.request);
    }
    Volume volume = import_readable(source, *shared.folder, shared.request);
    report_left_out(*shared.folder, volume);
    return volume;
}

Volume import_folder(const fs::path& folder, Importer::Shared& shared) {
    const std::string source = folder.string();
    const ImportRequest& request = shared.request;
    if (!shared.folder) {
        shared.folder = files_of_volume(folder, request);
    }
    FolderFiles& files = *shared.folder;
    Volume volume = files.slices.empty() ? read_pictures(source, files.pictures, request)
                                         : import_readable(source, files, request);
    report_left_out(files, volume);
    return volume;
}

std::vector<DicomSlice> slices_of_file(const fs::path& path) {
    const std::string file = path.string();
    if (!begins_as_dicom(path)) {
        throw ImportError(file + ": is no DICOM file: 'DICM' and an element must follow byte 128");
    }
    std::vector<DicomSlice> slices = read_dicom_slices(path);
    if (slices.empty()) {
        throw ImportError(
            file +
            ": is no DICOM image: rows (0028,0010) or columns (0028,0011) are missing, or "
            "it is cut or broken");
    }
    return slices;
}

Volume import_dicom_file(const fs::path& path, Importer::Shared& shared) {
    if (shared.slices.empty()) {
        shared.slices = slices_of_file(path);
    }
    return import_slices(path.string(), shared.slices, shared.request);
}

Volume import_stored(const fs::path& path, const StoredHeader& header, Importer::Shared& shared) {
    const ImportRequest& request = shared.request;
    const bool by_gps =
        is_read_by_gps(path.string(), why_not_by_gps(header), needed_bytes(header), request);
    Volume volume = by_gps ? scan_stored_values(path, header, request.reduced_bytes)
                           : shared.stored.read(path, header, shared.later_follow);
    take_directions(path.string(), request, header.assumed_directions, volume);
    take_spacing(path.string(), request, header.spacing_stated, volume);
    return volume;
}

Volume import_raw(const fs::path& path, Importer::Shared& shared) {
    const ImportRequest& request = shared.request;
    if (const std::string reason = why_unreadable(path); !reason.empty()) {
        throw ImportError(fmt::format("{}: {}", path.string(), reason));
    }
    const StoredHeader header = read_raw_layout(path, *request.raw);
    if (!request.spacing_mm) {
        throw ImportError(path.string() +
                          ": a raw file states no distances: give spacing=x,y,z in millimeters");
    }
    return import_stored(path, header, shared);
}

Volume import_checked(const fs::path& path, Importer::Shared& shared) {
    const ImportRequest& request = shared.request;
    if (request.raw) {
        refuse_frame(path.string(), request);
        return import_raw(path, shared);
    }
    const Format format = format_of(path);
    const bool has_chunks = fs::is_directory(path) && is_zarr(path);
    if (fs::is_directory(path) && !has_chunks) {
        return import_folder(path, shared);
    }
    if (format == Format::packed) {
        return import_archive(path.string(), shared);
    }
    if (!request.series.empty() && (format != Format::dicom || has_chunks)) {
        throw ImportError(fmt::format("{}: series is '{}', but only DICOM holds series",
                                      path.string(), request.series));
    }
    if (has_chunks) {
        if (request.read == ReadBy::gps) {
            refuse_gps(path.string(), "its values lie in chunks");
        }
        return read_zarr(path, request);
    }
    if (request.read == ReadBy::gps && format == Format::pictures) {
        refuse_gps(path.string(), "pictures are decoded by the io process");
    }
    switch (format) {
        case Format::dicom:
            return import_dicom_file(path, shared);
        case Format::pictures:
            refuse_frame(path.string(), request);
            return read_pictures(path.string(), {path}, request);
        default:
            return import_stored(path, read_stored_header(path, format, request), shared);
    }
}

/// "ct/pelvis.nii.gz" -> "pelvis".
std::string name_of(const fs::path& path) {
    const fs::path tidy = fs::absolute(path).lexically_normal();
    const fs::path last = tidy.has_filename() ? tidy.filename() : tidy.parent_path().filename();
    if (fs::is_directory(path) && is_zarr(path)) {
        const fs::path image = zarr_root(path).stem();  // "scan.ome.zarr" is "scan".
        return image.extension() == ".ome" ? image.stem().string() : image.string();
    }
    if (fs::is_directory(path)) {
        return last.string();
    }
    const fs::path stem = last.stem();  // "scan.nii.gz" and "scan.tar.xz" are "scan".
    return last.extension() == ".gz" || stem.extension() == ".tar" ? stem.stem().string()
                                                                   : stem.string();
}

Volume import_phantom(const ImportRequest& request) {
    if (request.raw || request.spacing_mm || !request.series.empty() ||
        !request.orientation.empty() || request.origin_mm) {
        throw ImportError(request.path +
                          ": a phantom has its own spacing, place, layout and series");
    }
    if (request.read == ReadBy::gps) {
        throw ImportError(request.path + ": a phantom has no file that GPs could read (read=gps)");
    }
    try {
        return make_phantom(request.path, std::max(1, static_cast<int>(request.frame)));
    } catch (const std::invalid_argument& error) {
        throw ImportError(error.what());
    }
}

void check_request(const ImportRequest& request) {
    if (!request.spacing_mm) {
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing = (*request.spacing_mm)[axis];
        if (!std::isfinite(spacing) || !(spacing > 0)) {
            throw ImportError(fmt::format("{}: spacing along {} is {}, must be above 0 mm",
                                          request.path, "xyz"[axis], spacing));
        }
    }
}

}  // namespace

Importer::Importer(ImportRequest request) : shared_(std::make_unique<Shared>()) {
    shared_->request = std::move(request);
}
Importer::~Importer() = default;
Importer::Importer(Importer&&) noexcept = default;
Importer& Importer::operator=(Importer&&) noexcept = default;

Volume Importer::read(std::uint32_t frame, bool later_follow) {
    shared_->request.frame = frame;
    shared_->later_follow = later_follow;
    const ImportRequest& request = shared_->request;
    const std::string& path = request.path;
    try {
        check_request(request);
        const bool phantom = is_phantom(path);
        Volume volume = phantom ? import_phantom(request) : import_checked(path, *shared_);
        if (!phantom) {
            check_place(path, volume);
            volume.name = name_of(path);
        }
        volume.source = path;
        process_volume(request, volume);
        return volume;
    } catch (const std::bad_alloc&) {
        throw ImportError(path + ": does not fit in the memory that the io process may use");
    } catch (const fs::filesystem_error& error) {
        throw ImportError(fmt::format("{}: {}", path, error.code().message()));
    }
}

Volume import_volume(const ImportRequest& request) {
    return Importer(request).read(request.frame);
}

Volume import_volume(const std::string& path) {
    ImportRequest request;
    request.path = path;
    return import_volume(request);
}

std::vector<DicomSlice> find_slices(const std::string& source, const AllowedFolders& allowed) {
    if (fs::is_directory(source) && is_zarr(source)) {
        return {};  // Its many files are chunks.
    }
    if (fs::is_directory(source)) {
        return look_through(source, allowed).slices;
    }
    if (!is_packed(source)) {
        return read_dicom_slices(source);
    }
    FolderFiles files = look_through_archive(source);
    if (files.slices.empty() && !files.left_out.empty()) {
        throw ImportError(files.left_out.front().text);
    }
    return std::move(files.slices);
}

}  // namespace pxpl5::host::io
