// The values of one volume, gathered from the chunks of an array.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/io/values/value_sink.hpp"
#include "host/io/zarr/zarr_levels.hpp"

namespace pxpl5::host::io {

class ZarrChunks {
  public:
    /// frame    Volume of a time series, from 0.
    /// allowed  Folders to which links may lead, beside the image's own.
    ZarrChunks(const ZarrLevel& level, std::uint64_t frame, const AllowedFolders& allowed);

    /// Adds all values, x fastest. Keeps one layer of chunks in memory.
    /// Throws ImportError naming the file of a chunk.
    void read(ValueSink& sink);

    /// Chunks of the volume that have a file.
    std::uint64_t files();

    /// The file of the volume's first chunk.
    std::filesystem::path first_file();

    /// Chunks of the volume.
    std::uint64_t count() const;

  private:
    static constexpr std::size_t none = SIZE_MAX;

    std::uint64_t size(std::size_t at) const;
    std::uint64_t chunk(std::size_t at) const;
    std::uint64_t stride(std::size_t at) const;
    std::size_t value_bytes() const { return component_bytes(array_.component); }
    void go_to(const std::array<std::uint64_t, 3>& first);
    void place(const std::array<std::uint64_t, 3>& begin, std::vector<std::byte>& slab) const;

    const ZarrArray& array_;
    const AllowedFolders& allowed_;
    std::vector<std::byte> chunk_;
    std::vector<std::uint64_t> strides_;  ///< Bytes between two values of a chunk, of each axis.
    std::vector<std::uint64_t> index_;    ///< The chunk's number along each axis.
    std::uint64_t offset_ = 0;            ///< The byte of the volume's first value in a chunk.
    std::array<std::size_t, 3> place_ = {none, none, none};  ///< The axis of x, y, z.
};

}  // namespace pxpl5::host::io
