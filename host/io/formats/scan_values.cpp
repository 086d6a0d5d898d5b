#include "host/io/formats/scan_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "host/base/digest.hpp"
#include "host/io/formats/byte_source.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/values/import_request.hpp"
#include "host/io/values/value_sink.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

std::size_t voxels_of(int nx, int ny, int nz) {
    return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) *
           static_cast<std::size_t>(nz);
}

/// The least reduction with which the copy has at most `most_bytes`.
int reduction_for(const Volume& volume, std::uint64_t most_bytes) {
    int reduction = 1;
    while (reduction < max_volume_voxels) {
        const std::size_t voxels =
            voxels_of(kept_of(volume.nx, reduction), kept_of(volume.ny, reduction),
                      kept_of(volume.nz, reduction));
        if (voxels * size_bytes(volume.type) <= most_bytes) {
            break;
        }
        ++reduction;
    }
    return reduction;
}

/// Takes all slices in order. Keeps every n-th voxel, and the digest of all voxels.
class Copier {
  public:
    Copier(const Volume& volume, std::uint64_t most_bytes)
        : reduction_(reduction_for(volume, most_bytes)),
          nx_(static_cast<std::size_t>(volume.nx)),
          voxel_bytes_(size_bytes(volume.type)),
          copy_(reduced_shape(volume, reduction_)) {
        copy_.values.reserve(voxels_of(copy_.nx, copy_.ny, copy_.nz) * voxel_bytes_);
    }

    void add(std::span<const std::byte> slice) {
        digest_.add(slice);
        if (slices_++ % reduction_ != 0) {
            return;
        }
        const std::size_t row_bytes = nx_ * voxel_bytes_;
        const std::size_t step = static_cast<std::size_t>(reduction_) * voxel_bytes_;
        for (std::size_t row = 0; row < slice.size();
             row += row_bytes * static_cast<std::size_t>(reduction_)) {
            for (std::size_t x = 0; x < row_bytes; x += step) {
                const auto voxel =
                    slice.subspan(row + x, reduction_ == 1 ? row_bytes : voxel_bytes_);
                copy_.values.insert(copy_.values.end(), voxel.begin(), voxel.end());
                if (reduction_ == 1) {
                    break;
                }
            }
        }
    }

    void finish(Volume& volume) {
        volume.digest = digest_.value();
        volume.reduction = reduction_;
        if (reduction_ == 1) {
            volume.values = std::move(copy_.values);
        } else {
            volume.reduced = std::make_shared<const Volume>(std::move(copy_));
        }
    }

  private:
    int reduction_, slices_ = 0;
    std::size_t nx_, voxel_bytes_;
    Volume copy_;
    Digest digest_;
};

[[noreturn]] void refuse_changed(const ScanPlace& place, const std::string& path) {
    throw ImportError(
        fmt::format("{}: {} has changed while it was read; load it again when it is complete",
                    place.source, path));
}

/// The slices in their files, in order.
class StoredSlices {
  public:
    StoredSlices(const ScanPlace& place, const Volume& volume)
        : place_(place),
          stored_(*volume.stored),
          slice_(voxels_of(volume.nx, volume.ny, 1) * component_bytes(stored_.component)) {}

    /// The files with their facts.
    const StoredVolume& stored() const { return stored_; }

    /// Calls `take` with each slice and its file. The values are those of read_stored().
    template <typename Take>
    void read_all(Take take) {
        for (std::size_t at = 0; at < stored_.files.size(); ++at) {
            SlicesFile& file = stored_.files[at];
            DataFile& opened = open(file.path);
            if (file.facts == FileFacts{}) {
                file.facts = opened.facts();
            }
            ByteSource bytes(opened.path(), Encoding::raw, file.offset_bytes);
            for (std::uint32_t slice = 0; slice < file.slices; ++slice) {
                if (bytes.read(slice_) < slice_.size()) {
                    refuse_changed(place_, file.path);
                }
                read_stored(slice_, stored_);
                take(std::span(slice_), file);
            }
            if (opened.facts_now() != file.facts) {
                refuse_changed(place_, file.path);
            }
        }
    }

  private:
    /// Frames of one file follow each other, so that the last file stays open.
    DataFile& open(const std::string& path) {
        if (!opened_ || path != open_path_) {
            opened_.reset();
            opened_.emplace(place_.header.empty() ? fs::path(path) : place_.header, path,
                            place_.allowed);
            open_path_ = path;
        }
        return *opened_;
    }

    const ScanPlace& place_;
    StoredVolume stored_;
    std::optional<DataFile> opened_;
    std::string open_path_;
    std::vector<std::byte> slice_;
};

/// The type of the voxels if they are the stored values.
std::optional<Scalar> type_as_stored(const StoredVolume& stored) {
    for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32}) {
        const auto as_stored = [&](const SlicesFile& file) {
            return are_voxels(stored.component, file.scale, type);
        };
        if (std::ranges::all_of(stored.files, as_stored)) {
            return type;
        }
    }
    return std::nullopt;
}

/// Reads the values again: the type of converted voxels depends on all of them.
Copier convert_slices(const ScanPlace& place, const Volume& volume, StoredSlices& slices) {
    Copier copier(volume, place.reduced_bytes);
    std::vector<std::byte> voxels(voxels_of(volume.nx, volume.ny, 1) * size_bytes(volume.type));
    slices.read_all([&](std::span<const std::byte> slice, const SlicesFile& file) {
        if (!convert_stored(slice, slices.stored().component, file.scale, volume.type, voxels)) {
            refuse_changed(place, file.path);
        }
        copier.add(voxels);
    });
    return copier;
}

/// "scan.raw", or "112 files, the first of which is 1.dcm".
std::string files_text(const StoredVolume& stored) {
    std::size_t files = 1;
    for (std::size_t at = 1; at < stored.files.size(); ++at) {
        files += stored.files[at].path != stored.files[at - 1].path ? 1 : 0;
    }
    const std::string& first = stored.files.front().path;
    return files == 1 ? first : fmt::format("{} files, the first of which is {}", files, first);
}

void report_reduction(Volume& volume) {
    const std::string text =
        fmt::format("the GPs read the values from {}", files_text(*volume.stored));
    const std::int64_t voxels =
        std::int64_t{volume.reduction} * volume.reduction * volume.reduction;
    volume.findings.push_back(
        {FindingKind::note,
         volume.reduction == 1
             ? text
             : fmt::format("{}; the host keeps one voxel in {} along each axis (reduced by {}), so "
                           "percentiles and histograms count 1 of {} voxels",
                           text, volume.reduction, volume.reduction, voxels)});
}

/// Where the values begin in a file of the header.
std::uint64_t offset_of(const std::string& file, const fs::path& data, const DataFile& opened,
                        const StoredHeader& header, std::uint64_t needed) {
    const std::uint64_t size = opened.size_bytes();
    std::uint64_t offset = header.line_skip == 0
                               ? header.offset_bytes
                               : offset_after_lines(data.string(), opened.path(),
                                                    header.offset_bytes, header.line_skip);
    const std::uint64_t after = size - std::min(size, offset);
    const std::uint64_t volumes = header.frames * needed;
    if (header.at_end && after < volumes) {
        throw too_short(file, header, data, after);
    }
    offset += (header.at_end ? after - volumes : header.byte_skip) + header.bytes_before();
    if (offset > size || size - offset < needed) {
        throw too_short(file, header, data, size - std::min(size, offset));
    }
    return offset;
}

StoredVolume stored_volume_of(const fs::path& path, const StoredHeader& header, int slices) {
    StoredVolume stored{header.component, header.big_endian, 0, {}};
    const std::size_t count = header.data_files.size();
    for (const fs::path& data : header.data_files) {
        const DataFile opened(path, data, header.allowed);
        SlicesFile& file = stored.files.emplace_back();
        file.path = fs::absolute(data).string();
        file.offset_bytes =
            offset_of(path.string(), data, opened, header, needed_bytes(header) / count);
        file.slices = static_cast<std::uint32_t>(slices) / static_cast<std::uint32_t>(count);
        file.scale = header.scale;
        file.facts = opened.facts();
    }
    return stored;
}

}  // namespace

std::string why_not_by_gps(const StoredHeader& header) {
    if (header.encoding != Encoding::raw) {
        return is_compressed(header.encoding) ? "its values are compressed"
                                              : "its values are written as text";
    }
    const std::uint64_t slices = header.sizes.size() < 3 ? 1 : header.sizes[2];
    return !header.data_files.empty() && slices % header.data_files.size() == 0
               ? ""
               : fmt::format("its {} files do not have whole slices, of which there are {}",
                             header.data_files.size(), slices);
}

void scan_values(const ScanPlace& place, Volume& volume) {
    StoredSlices slices(place, volume);
    const Component component = volume.stored->component;
    ValueSink sink(voxels_of(volume.nx, volume.ny, volume.nz), ValueSink::Keeps::none);
    std::optional<Copier> copier;
    if (const std::optional<Scalar> type = type_as_stored(*volume.stored)) {
        volume.type = *type;
        copier.emplace(volume, place.reduced_bytes);
    }
    slices.read_all([&](std::span<const std::byte> slice, const SlicesFile& file) {
        sink.add(slice, component, file.scale);
        if (copier) {
            copier->add(slice);
        }
    });
    sink.finish(place.source, volume);
    if (!copier) {
        copier.emplace(convert_slices(place, volume, slices));
    }
    volume.stored = slices.stored();
    copier->finish(volume);
    report_reduction(volume);
}

Volume scan_stored_values(const fs::path& path, const StoredHeader& header,
                          std::uint64_t reduced_bytes) {
    Volume volume = empty_volume(path, header);
    volume.stored = stored_volume_of(path, header, volume.nz);
    scan_values({path.string(), path, header.allowed, reduced_bytes}, volume);
    return volume;
}

}  // namespace pxpl5::host::io
