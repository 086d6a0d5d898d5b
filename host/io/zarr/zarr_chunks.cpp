#include "host/io/zarr/zarr_chunks.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace pxpl5::host::io {

ZarrChunks::ZarrChunks(const ZarrLevel& level, std::uint64_t frame, const AllowedFolders& allowed)
    : array_(level.array), allowed_(allowed), chunk_(level.array.chunk_bytes()) {
    const ZarrArray& array = level.array;
    const std::vector<ZarrAxis>& axes = level.axes;
    const std::size_t count = array.shape.size();
    strides_.assign(count, component_bytes(array.component));
    for (std::size_t i = 1; i < count; ++i) {
        const std::size_t axis = array.is_c_order ? count - 1 - i : i;
        const std::size_t inner = array.is_c_order ? axis + 1 : axis - 1;
        strides_[axis] = strides_[inner] * array.chunks[inner];
    }
    index_.assign(count, 0);
    for (std::size_t axis = 0; axis < count; ++axis) {
        const std::size_t at = std::string_view("xyz").find(axes[axis].name);
        if (at != std::string_view::npos) {
            place_[at] = axis;
        } else if (axes[axis].name == "t") {
            index_[axis] = frame / array.chunks[axis];
            offset_ += frame % array.chunks[axis] * strides_[axis];
        }
    }
}

void ZarrChunks::read(ValueSink& sink) {
    for (std::uint64_t z = 0; z < size(2); z += chunk(2)) {
        const std::uint64_t depth = std::min(chunk(2), size(2) - z);
        std::vector<std::byte> slab(depth * size(1) * size(0) * value_bytes());
        for (std::uint64_t y = 0; y < size(1); y += chunk(1)) {
            for (std::uint64_t x = 0; x < size(0); x += chunk(0)) {
                go_to({x, y, z});
                read_chunk(array_, index_, allowed_, chunk_);
                place({x, y, depth}, slab);
            }
        }
        if (array_.big_endian) {
            swap_bytes(slab, value_bytes());
        }
        sink.add(slab, array_.component);
    }
}

std::uint64_t ZarrChunks::files() {
    std::uint64_t files = 0;
    for (std::uint64_t z = 0; z < size(2); z += chunk(2)) {
        for (std::uint64_t y = 0; y < size(1); y += chunk(1)) {
            for (std::uint64_t x = 0; x < size(0); x += chunk(0)) {
                go_to({x, y, z});
                files += has_chunk_file(array_, index_) ? 1 : 0;
            }
        }
    }
    return files;
}

std::filesystem::path ZarrChunks::first_file() {
    go_to({0, 0, 0});
    return chunk_file(array_, index_);
}

std::uint64_t ZarrChunks::count() const {
    std::uint64_t chunks = 1;
    for (std::size_t at = 0; at < 3; ++at) {
        chunks *= (size(at) + chunk(at) - 1) / chunk(at);
    }
    return chunks;
}

std::uint64_t ZarrChunks::size(std::size_t at) const {
    return place_[at] == none ? 1 : array_.shape[place_[at]];
}

std::uint64_t ZarrChunks::chunk(std::size_t at) const {
    return place_[at] == none ? 1 : array_.chunks[place_[at]];
}

std::uint64_t ZarrChunks::stride(std::size_t at) const {
    return place_[at] == none ? 0 : strides_[place_[at]];
}

/// Selects the chunk that begins at a voxel.
void ZarrChunks::go_to(const std::array<std::uint64_t, 3>& first) {
    for (std::size_t at = 0; at < 3; ++at) {
        if (place_[at] != none) {
            index_[place_[at]] = first[at] / chunk(at);
        }
    }
}

/// Copies the values of the chunk into a slab that begins at its z. Chunks at the end of an
/// axis reach beyond it.
/// begin  Its first x and y, and the slab's depth.
void ZarrChunks::place(const std::array<std::uint64_t, 3>& begin,
                       std::vector<std::byte>& slab) const {
    const std::size_t bytes = value_bytes();
    const std::uint64_t columns = std::min(chunk(0), size(0) - begin[0]);
    const std::uint64_t rows = std::min(chunk(1), size(1) - begin[1]);
    for (std::uint64_t z = 0; z < begin[2]; ++z) {
        for (std::uint64_t y = 0; y < rows; ++y) {
            const std::byte* from = chunk_.data() + offset_ + z * stride(2) + y * stride(1);
            std::byte* to =
                slab.data() + ((z * size(1) + begin[1] + y) * size(0) + begin[0]) * bytes;
            if (stride(0) == bytes) {
                std::copy_n(from, columns * bytes, to);
                continue;
            }
            for (std::uint64_t x = 0; x < columns; ++x) {
                std::copy_n(from + x * stride(0), bytes, to + x * bytes);
            }
        }
    }
}

}  // namespace pxpl5::host::io
