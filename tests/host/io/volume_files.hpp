// Small volume files, written byte by byte, for the tests of import.
#pragma once

#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/gzip.hpp"

namespace pxpl5::test {

/// A folder that is gone at the end of the test.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        static std::atomic<int> count{0};
        path_ = std::filesystem::temp_directory_path() /
                ("pxpl5-io-" + std::to_string(getpid()) + "-" + std::to_string(count++));
        std::filesystem::create_directory(path_);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::string file(const std::string& name) const { return (path_ / name).string(); }

    std::string write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return file(name);
    }

  private:
    std::filesystem::path path_;
};

/// The bytes of `value`, most significant first if `big_endian`.
template <typename T>
std::string bytes_of(T value, bool big_endian = false) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big_endian) {
        std::reverse(bytes.begin(), bytes.end());
    }
    return bytes;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values, bool big_endian = false) {
    std::string bytes;
    for (const T value : values) {
        bytes += bytes_of(value, big_endian);
    }
    return bytes;
}

/// `count` values of which no two neighbors are equal; the first is the type's lowest, the last
/// its highest.
template <typename T>
std::vector<T> ramp(std::size_t count) {
    std::vector<T> values(count);
    for (std::size_t index = 0; index < count; ++index) {
        values[index] =
            static_cast<T>(static_cast<T>(index * 7 % 101) - T{3} * std::is_signed_v<T>);
    }
    values.front() = std::numeric_limits<T>::lowest();
    values.back() = std::numeric_limits<T>::max();
    return values;
}

/// A NIfTI-1 header of int16 voxels, to be changed field by field. Offsets are those of nifti1.h.
class NiftiHeader {
  public:
    explicit NiftiHeader(bool big_endian = false) : big_endian_(big_endian), bytes_(352, '\0') {
        put<std::int32_t>(0, 348);
        put_dims({3, 4, 3, 2, 1, 1, 1, 1});
        put<std::int16_t>(70, 4);   // datatype int16
        put<std::int16_t>(72, 16);  // bitpix
        for (std::size_t axis = 0; axis < 4; ++axis) {
            put<float>(76 + 4 * axis, 1.0F);
        }
        put<float>(108, 352.0F);  // vox_offset
        bytes_[123] = 2;          // millimeters
        std::memcpy(bytes_.data() + 344, "n+1", 4);
    }

    template <typename T>
    NiftiHeader& put(std::size_t offset, T value) {
        bytes_.replace(offset, sizeof(T), bytes_of(value, big_endian_));
        return *this;
    }
    NiftiHeader& put_dims(const std::array<std::int16_t, 8>& dims) {
        for (std::size_t index = 0; index < 8; ++index) {
            put<std::int16_t>(40 + 2 * index, dims[index]);
        }
        return *this;
    }
    /// sform rows: what NIfTI calls srow_x, srow_y, srow_z (RAS millimeters).
    NiftiHeader& put_sform(const std::array<std::array<float, 4>, 3>& rows) {
        put<std::int16_t>(254, 1);
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 4; ++column) {
                put<float>(280 + 16 * row + 4 * column, rows[row][column]);
            }
        }
        return *this;
    }
    const std::string& bytes() const { return bytes_; }

  private:
    bool big_endian_;
    std::string bytes_;
};

/// The bytes of a gzip file with these contents. Uses a file in `folder`, and removes it.
inline std::string gzipped(const TemporaryFolder& folder, const std::string& bytes) {
    return gzipped_at(folder.file("scratch.gz"), bytes);
}

}  // namespace pxpl5::test
