#include "gp_firmware/volume/slice_packer.hpp"

#include <zstd.h>

#include <cassert>
#include <cstdint>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

namespace pxpl5::gp {

namespace {

constexpr int fastest_level = 1;

/// Byte k of all differences, then byte k + 1. In smooth data, the high bytes are almost equal.
template <class Word>
void sort_bytes(std::span<const std::byte> values, std::span<std::byte> sorted) {
    const std::size_t count = values.size() / sizeof(Word);
    Word before = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Word value{};
        std::memcpy(&value, values.data() + i * sizeof value, sizeof value);
        const auto difference = static_cast<Word>(value - before);
        before = value;
        for (std::size_t k = 0; k < sizeof(Word); ++k) {
            sorted[k * count + i] = static_cast<std::byte>(difference >> (8 * k) & 0xff);
        }
    }
}

template <class Word>
void restore_bytes(std::span<const std::byte> sorted, std::span<std::byte> values) {
    const std::size_t count = values.size() / sizeof(Word);
    Word value = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Word difference = 0;
        for (std::size_t k = 0; k < sizeof(Word); ++k) {
            const auto byte = static_cast<std::uint32_t>(sorted[k * count + i]);
            difference = static_cast<Word>(difference | byte << (8 * k));
        }
        value = static_cast<Word>(value + difference);
        std::memcpy(values.data() + i * sizeof value, &value, sizeof value);
    }
}

/// Calls `work` with a zero of the unsigned type of `bytes` bytes.
template <class Work>
void with_word(std::size_t bytes, Work&& work) {
    assert(bytes == 1 || bytes == 2 || bytes == 4);
    if (bytes == 1) {
        work(std::uint8_t{});
    } else if (bytes == 2) {
        work(std::uint16_t{});
    } else {
        work(std::uint32_t{});
    }
}

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
    with_word(value_bytes_, [&]<class Word>(Word) { sort_bytes<Word>(values, sorted_); });
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
    with_word(value_bytes_, [&]<class Word>(Word) { restore_bytes<Word>(sorted_, values); });
}

}  // namespace pxpl5::gp
