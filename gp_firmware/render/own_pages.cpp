#include "gp_firmware/render/own_pages.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cassert>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace pxpl5::gp {

namespace {

std::byte* checked(void* memory) {
    if (memory == nullptr || memory == MAP_FAILED) {
        throw std::bad_alloc();
    }
    return static_cast<std::byte*>(memory);
}

std::size_t whole_pages(std::size_t bytes) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return (bytes + page - 1) / page * page;
}

}  // namespace

OwnPages::~OwnPages() {
    free();
}

OwnPages::OwnPages(OwnPages&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

OwnPages& OwnPages::operator=(OwnPages&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

void OwnPages::free() {
    if (bytes_ < least_bytes) {
        std::free(data_);
    } else {
        munmap(data_, bytes_);
    }
}

void OwnPages::grow(std::size_t used, std::size_t bytes) {
    assert(used <= bytes_ && bytes > bytes_);
    if (bytes < least_bytes) {
        data_ = checked(std::realloc(data_, bytes));
        bytes_ = bytes;
        return;
    }
    bytes = whole_pages(bytes);
    if (bytes_ >= least_bytes) {
        data_ = checked(mremap(data_, bytes_, bytes, MREMAP_MAYMOVE));
        bytes_ = bytes;
        return;
    }
    std::byte* const pages =
        checked(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (used > 0) {
        std::memcpy(pages, data_, used);
    }
    std::free(data_);
    data_ = pages;
    bytes_ = bytes;
}

}  // namespace pxpl5::gp
