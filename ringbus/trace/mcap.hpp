// MCAP container files: records, fields and their encoding.
//
// A file is <magic> Header Metadata (Chunk MessageIndex...)... DataEnd
//           <summary> <summary offsets> Footer <magic>
// A record is an opcode, the length of its content, and the content; numbers are little endian.
// Source: MCAP format specification, https://mcap.dev/spec.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::bus::trace::mcap {

inline constexpr std::array<std::uint8_t, 8> magic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Op : std::uint8_t {
    header = 1,
    footer = 2,
    schema = 3,
    channel = 4,
    message = 5,
    chunk = 6,
    message_index = 7,
    chunk_index = 8,
    statistics = 11,
    metadata = 12,
    metadata_index = 13,
    summary_offset = 14,
    data_end = 15,
};

inline constexpr std::size_t record_head_bytes = 9;  ///< Opcode and length.
inline constexpr std::size_t message_head_bytes =
    22;                                          ///< Content of a message record before its data.
inline constexpr std::size_t footer_bytes = 20;  ///< Content of the footer.
/// Size of a full chunk. A writer ends a chunk when a message has filled it, so that only the last
/// message of a chunk can end beyond this size. Larger chunks compress no better (measured,
/// README).
inline constexpr std::size_t chunk_bytes = std::size_t{1} << 20;
/// Limit of a chunk. A chunk has whole messages, and a message has at most 1 GiB and a head.
inline constexpr std::uint64_t max_chunk_bytes =
    (std::uint64_t{1} << 30) + (std::uint64_t{8} << 20);
/// Limit of every other record.
inline constexpr std::uint64_t max_record_bytes = std::uint64_t{64} << 20;

using Bytes = std::vector<std::uint8_t>;
using Metadata = std::map<std::string, std::string>;

/// Extends the CRC-32 `before` by `bytes`.
std::uint32_t crc_of(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

/// Thrown for damaged bytes. `what` continues "at offset N: ".
struct Damage : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws Damage unless the CRC-32 `got` is `wanted`, or `wanted` is 0, which means: no checksum.
void check_crc(const char* of, std::uint32_t got, std::uint32_t wanted);

/// Appends fields to `to`.
class Out {
  public:
    explicit Out(Bytes& to) : to_(to) {}
    template <typename Number>
    Out& number(Number value) {
        for (std::size_t i = 0; i < sizeof value; ++i) {
            to_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
        }
        return *this;
    }
    Out& op(Op value) { return number(static_cast<std::uint8_t>(value)); }
    Out& raw(std::span<const std::uint8_t> bytes);
    Out& text(std::string_view value);
    Out& texts(const Metadata& values);

    /// Appends a list or map: its length in bytes, then what `fill` appends.
    template <typename Fill>
    Out& counted(const Fill& fill) {
        return measured<std::uint32_t>(fill);
    }
    /// Appends a record whose content `fill` appends.
    template <typename Fill>
    Out& record(Op opcode, const Fill& fill) {
        op(opcode);
        return measured<std::uint64_t>(fill);
    }

  private:
    template <typename Length, typename Fill>
    Out& measured(const Fill& fill) {
        const std::size_t at = to_.size();
        number(Length{0});
        fill();
        const auto length = static_cast<Length>(to_.size() - at - sizeof(Length));
        for (std::size_t i = 0; i < sizeof(Length); ++i) {
            to_[at + i] = static_cast<std::uint8_t>(length >> (8 * i));
        }
        return *this;
    }

    Bytes& to_;
};

/// Takes fields from the front of bytes. Throws Damage if the bytes end before a field.
class In {
  public:
    explicit In(std::span<const std::uint8_t> bytes) : left_(bytes) {}
    bool empty() const { return left_.empty(); }
    std::size_t size() const { return left_.size(); }
    template <typename Number>
    Number number() {
        Number value = 0;
        const auto bytes = raw(sizeof value);
        for (std::size_t i = 0; i < sizeof value; ++i) {
            value = static_cast<Number>(value | static_cast<Number>(bytes[i]) << (8 * i));
        }
        return value;
    }
    std::span<const std::uint8_t> raw(std::uint64_t count);
    std::span<const std::uint8_t> rest() { return raw(left_.size()); }
    std::string text();
    Metadata texts();

  private:
    std::span<const std::uint8_t> left_;
};

}  // namespace pxpl5::bus::trace::mcap
