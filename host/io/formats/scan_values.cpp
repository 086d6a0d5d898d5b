// Reads the values of a file that GPs read, too: their type, range, digest and a reduced copy.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "host/base/digest.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/values/import_request.hpp"
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

/// The values in their file, slice by slice.
class StoredSlices {
  public:
    StoredSlices(const fs::path& path, const StoredHeader& header)
        : file_(path.string()),
          header_(header),
          data_(header.data_files.front()),
          opened_(path, data_, header.allowed),
          slice_(needed_bytes(header) /
                 static_cast<std::size_t>(volume_dims(file_, header.sizes)[2])) {
        const std::uint64_t needed = needed_bytes(header), size = opened_.size_bytes();
        at_.path = fs::absolute(data_).string();
        at_.offset_bytes = header.line_skip == 0
                               ? header.offset_bytes
                               : offset_after_lines(data_.string(), opened_.path(),
                                                    header.offset_bytes, header.line_skip);
        const std::uint64_t after = size - std::min(size, at_.offset_bytes);
        at_.offset_bytes += !header.at_end ? header.byte_skip : after - std::min(after, needed);
        if (at_.offset_bytes > size || size - at_.offset_bytes < needed) {
            throw too_short(file_, header, data_, size - std::min(size, at_.offset_bytes));
        }
        at_.stored = header.component;
        at_.big_endian = header.big_endian;
        at_.scale = header.scale;
        at_.facts = opened_.facts();
    }

    const SlicesFile& at() const { return at_; }

    /// Calls `take` with the bytes of each slice, in the order of the file.
    template <typename Take>
    void read_all(Take take) {
        ByteSource source(opened_.path(), Encoding::raw, at_.offset_bytes);
        for (std::uint64_t done = 0; done < needed_bytes(header_); done += slice_.size()) {
            const std::size_t came = source.read(slice_);
            if (came < slice_.size()) {
                throw too_short(file_, header_, data_, done + came);
            }
            take(std::span(slice_));
        }
        if (opened_.facts_now() != at_.facts) {
            throw ImportError(
                fmt::format("{}: {} has changed while it was read; load it again "
                            "when it is complete",
                            file_, data_.string()));
        }
    }

  private:
    std::string file_;
    const StoredHeader& header_;
    fs::path data_;
    DataFile opened_;
    SlicesFile at_;
    std::vector<std::byte> slice_;
};

/// The type of the voxels if they are the stored values.
std::optional<Scalar> type_as_stored(const SlicesFile& file) {
    for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32}) {
        if (are_voxels(file, type)) {
            return type;
        }
    }
    return std::nullopt;
}

/// Reads the values again: the type of converted voxels depends on all of them.
Copier convert_slices(const std::string& file, const Volume& volume, StoredSlices& slices,
                      std::uint64_t reduced_bytes) {
    Copier copier(volume, reduced_bytes);
    std::vector<std::byte> voxels(voxels_of(volume.nx, volume.ny, 1) * size_bytes(volume.type));
    slices.read_all([&](std::span<std::byte> slice) {
        if (!convert_stored(slice, *volume.file, volume.type, voxels)) {
            throw ImportError(
                fmt::format("{}: {} has changed while it was read; load it again "
                            "when it is complete",
                            file, volume.file->path));
        }
        copier.add(voxels);
    });
    return copier;
}

void report_reduction(Volume& volume) {
    const std::string text = fmt::format("the GPs read the values from {}", volume.file->path);
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

}  // namespace

std::string why_not_by_gps(const StoredHeader& header) {
    if (header.encoding != Encoding::raw) {
        return is_compressed(header.encoding) ? "its values are compressed"
                                              : "its values are written as text";
    }
    return header.data_files.size() == 1
               ? ""
               : fmt::format("its values are in {} files", header.data_files.size());
}

Volume scan_stored_values(const fs::path& path, const StoredHeader& header,
                          std::uint64_t reduced_bytes) {
    const std::string file = path.string();
    const std::array<int, 3> dims = volume_dims(file, header.sizes);
    Volume volume;
    volume.nx = dims[0];
    volume.ny = dims[1];
    volume.nz = dims[2];
    volume.voxel_to_patient = header.voxel_to_patient;
    volume.findings = header.findings;
    StoredSlices slices(path, header);
    volume.file = slices.at();
    ValueSink sink(voxels_of(volume.nx, volume.ny, volume.nz), ValueSink::Keeps::none);
    std::optional<Copier> copier;
    if (const std::optional<Scalar> type = type_as_stored(*volume.file)) {
        volume.type = *type;
        copier.emplace(volume, reduced_bytes);
    }
    slices.read_all([&](std::span<std::byte> slice) {
        if (header.big_endian) {
            swap_bytes(slice, component_bytes(header.component));
        }
        sink.add(slice, header.component, header.scale);
        if (copier) {
            copier->add(slice);
        }
    });
    sink.finish(file, volume);
    if (!copier) {
        copier.emplace(convert_slices(file, volume, slices, reduced_bytes));
    }
    copier->finish(volume);
    report_reduction(volume);
    return volume;
}

}  // namespace pxpl5::host::io
