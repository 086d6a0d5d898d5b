#include "gp_firmware/volume/slice_packer.hpp"

#include <zstd.h>

#include <new>
#include <stdexcept>
#include <string>

#include "ringbus/rules/byte_planes.hpp"

namespace pxpl5::gp {

namespace {

constexpr int fastest_level = 1;

}  // namespace

struct SlicePacker::Contexts {
    ZSTD_CCtx* pack = ZSTD_createCCtx();
    ZSTD_DCtx* unpack = ZSTD_createDCtx();
    Contexts() = default;
    ~Contexts() {
        ZSTD_freeCCtx(pack);
        ZSTD_freeDCtx(unpack);
    }
    Contexts(const Contexts&) = delete;
    Contexts& operator=(const Contexts&) = delete;
};

SlicePacker::SlicePacker(std::size_t value_bytes)
    : contexts_(std::make_unique<Contexts>()), value_bytes_(value_bytes) {
    if (contexts_->pack == nullptr || contexts_->unpack == nullptr) {
        throw std::bad_alloc();
    }
}

SlicePacker::~SlicePacker() = default;

std::vector<std::byte> SlicePacker::pack(std::span<const std::byte> values) {
    sorted_.resize(values.size());
    split_into_planes(values, value_bytes_, sorted_);
    bound_.resize(ZSTD_compressBound(values.size()));
    const std::size_t size = ZSTD_compressCCtx(contexts_->pack, bound_.data(), bound_.size(),
                                               sorted_.data(), sorted_.size(), fastest_level);
    if (ZSTD_isError(size) != 0) {
        throw std::bad_alloc();  // The buffer is large enough, so that memory is short.
    }
    return {bound_.begin(), bound_.begin() + static_cast<std::ptrdiff_t>(size)};
}

void SlicePacker::unpack(std::span<const std::byte> packed, std::span<std::byte> values) {
    sorted_.resize(values.size());
    const std::size_t size = ZSTD_decompressDCtx(contexts_->unpack, sorted_.data(), sorted_.size(),
                                                 packed.data(), packed.size());
    if (ZSTD_isError(size) != 0 || size != values.size()) {
        throw std::logic_error("a compressed slice of " + std::to_string(packed.size()) +
                               " bytes does not have " + std::to_string(values.size()) +
                               " bytes of values");
    }
    join_planes(sorted_, value_bytes_, values);
}

}  // namespace pxpl5::gp
