#include "ringbus/trace/mcap.hpp"

#include <fmt/core.h>
#include <zlib.h>

namespace pxpl5::bus::trace::mcap {

std::uint32_t crc_of(std::span<const std::uint8_t> bytes, std::uint32_t before) {
    return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

void check_crc(const char* of, std::uint32_t got, std::uint32_t wanted) {
    if (wanted != 0 && got != wanted) {
        throw Damage(fmt::format("the CRC of {} is {:08x}, recorded is {:08x}", of, got, wanted));
    }
}

Out& Out::raw(std::span<const std::uint8_t> bytes) {
    to_.insert(to_.end(), bytes.begin(), bytes.end());
    return *this;
}

Out& Out::text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    to_.insert(to_.end(), value.begin(), value.end());
    return *this;
}

Out& Out::texts(const Metadata& values) {
    return counted([&] {
        for (const auto& [key, value] : values) {
            text(key).text(value);
        }
    });
}

std::span<const std::uint8_t> In::raw(std::uint64_t count) {
    if (count > left_.size()) {
        throw Damage(fmt::format("a field of {} bytes where {} are left", count, left_.size()));
    }
    const auto taken = left_.first(static_cast<std::size_t>(count));
    left_ = left_.subspan(static_cast<std::size_t>(count));
    return taken;
}

std::string In::text() {
    const auto bytes = raw(number<std::uint32_t>());
    return {bytes.begin(), bytes.end()};
}

Metadata In::texts() {
    In entries(raw(number<std::uint32_t>()));
    Metadata values;
    while (!entries.empty()) {
        std::string key = entries.text();
        values[std::move(key)] = entries.text();
    }
    return values;
}

}  // namespace pxpl5::bus::trace::mcap
