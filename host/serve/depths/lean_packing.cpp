#include "host/serve/depths/lean_packing.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pxpl5::host::serve {
namespace {

constexpr int half_range = (max_lean + 1) / 2;
constexpr int level = 1;              ///< A third of the time of level 6, a sixth more bytes.
constexpr int raw_window_bits = -15;  ///< Negative: no header and no checksum.
constexpr int memory_level = 9;

/// A difference in 12 bits, the sign lowest. More than half of the range wraps.
std::uint32_t folded(int difference) {
    const int wrapped = ((difference + half_range) & max_lean) - half_range;
    return static_cast<std::uint32_t>(wrapped < 0 ? -2 * wrapped - 1 : 2 * wrapped);
}

/// Predicts each corner from its neighbors, and writes what differs.
class Differences {
  public:
    explicit Differences(const LeanDepths& lean)
        : lean_(lean), above_(static_cast<std::size_t>(lean.columns)), row_(above_) {}

    /// The differences of the next row of corners.
    template <typename Put>
    void next_row(std::size_t row, const Put& put) {
        std::swap(above_, row_);
        int left = 0, upper_left = 0;
        for (std::size_t column = 0; column < row_.size(); ++column) {
            const int up = row == 0 ? 0 : above_[column];
            const int predicted = std::clamp(left + up - upper_left, 1, int{max_lean});
            const int corner = lean_.corners[row * row_.size() + column];
            const int value = corner == 0 ? predicted : corner;
            put(folded(value - predicted));
            row_[column] = value;
            left = value;
            upper_left = up;
        }
    }

  private:
    const LeanDepths& lean_;
    std::vector<int> above_, row_;
};

/// Low bytes of values, then their high bytes.
void add_planes(std::vector<std::uint8_t>& bytes, const std::vector<std::uint32_t>& values) {
    for (const unsigned shift : {0U, 8U}) {
        for (const std::uint32_t value : values) {
            bytes.push_back(static_cast<std::uint8_t>(value >> shift));
        }
    }
}

void add_corners(std::vector<std::uint8_t>& bytes, const LeanDepths& lean) {
    std::vector<std::uint32_t> values;
    values.reserve(lean.corners.size());
    Differences differences(lean);
    for (std::size_t row = 0; row < static_cast<std::size_t>(lean.rows); ++row) {
        differences.next_row(row, [&](std::uint32_t folded) { values.push_back(folded); });
    }
    add_planes(bytes, values);
}

void add_seams(std::vector<std::uint8_t>& bytes, const LeanDepths& lean) {
    const std::size_t first = bytes.size();
    bytes.resize(first + (lean.cell_count() + 7) / 8);
    std::vector<std::uint32_t> pixels;
    std::array<std::vector<std::uint32_t>, 8> depths;  // Four of `near`, four of `far`.
    for (const Seam& seam : lean.seams) {
        std::uint8_t& byte = bytes[first + seam.cell / 8];
        byte = static_cast<std::uint8_t>(byte | 1U << (seam.cell % 8));
        pixels.push_back(seam.near_pixels);
        const std::array<std::uint16_t, 4> corners = lean.corners_of(seam.cell);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            depths[k].push_back(folded(seam.near[k] - corners[k]));
            depths[4 + k].push_back(folded(seam.far[k] - corners[k]));
        }
    }
    add_planes(bytes, pixels);
    for (const std::vector<std::uint32_t>& each : depths) {
        add_planes(bytes, each);
    }
}

/// The bytes before they are deflated.
std::vector<std::uint8_t> plain_bytes(const LeanDepths& lean) {
    const std::size_t row_bytes = mask_row_bytes(lean.width);
    std::vector<std::uint8_t> bytes = lean.mask;
    for (std::size_t at = bytes.size(); at-- > row_bytes;) {
        bytes[at] ^= lean.mask[at - row_bytes];
    }
    add_corners(bytes, lean);
    add_seams(bytes, lean);
    return bytes;
}

}  // namespace

std::string packed(const LeanDepths& lean) {
    std::vector<std::uint8_t> plain = plain_bytes(lean);
    z_stream stream{};
    if (deflateInit2(&stream, level, Z_DEFLATED, raw_window_bits, memory_level,
                     Z_DEFAULT_STRATEGY) != Z_OK) {
        throw std::runtime_error("cannot pack the depths of a picture: zlib has no memory");
    }
    std::string bytes(deflateBound(&stream, plain.size()), '\0');
    stream.next_in = plain.data();
    stream.avail_in = static_cast<uInt>(plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(bytes.size());
    const int result = deflate(&stream, Z_FINISH);
    bytes.resize(stream.total_out);
    deflateEnd(&stream);
    if (result != Z_STREAM_END) {
        throw std::runtime_error(
            fmt::format("cannot pack the depths of a picture of {} x {} pixels: zlib returned {}",
                        lean.width, lean.height, result));
    }
    return bytes;
}

std::string packed_stack(int width, int height, int pictures,
                         std::span<const std::uint32_t> depths) {
    const std::size_t each = depths.size() / static_cast<std::size_t>(pictures);
    std::string stack;
    for (std::size_t at = 0; at < static_cast<std::size_t>(pictures) * each; at += each) {
        const std::string bytes = packed(lean_depths(width, height, depths.subspan(at, each)));
        for (unsigned shift = 0; shift < 32; shift += 8) {
            stack += static_cast<char>(bytes.size() >> shift);
        }
        stack += bytes;
    }
    return stack;
}

}  // namespace pxpl5::host::serve
