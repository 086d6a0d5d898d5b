// Gathers a volume's values chunk by chunk, in the narrowest of our four types that holds them.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "host/io/values/component.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

using Scale = StoredScale;

/// Differences up to these are no loss.
struct Tolerance {
    double absolute = 0, relative = 0;
};

/// Keeps uint8, int16, uint16 and float32 while all chunks have one of these types and no scale.
/// Otherwise whole numbers become int16 or uint16 if all fit, and other values become float32. A
/// chunk converts the earlier values if needed. The result does not depend on the order of chunks.
class ValueSink {
  public:
    /// Whether the sink keeps the values. Without them it reports type, range and conversion only.
    enum class Keeps : std::uint8_t { all, none };

    /// value_count  Of the whole volume: memory is reserved once.
    explicit ValueSink(std::size_t value_count, Keeps keeps = Keeps::all)
        : value_count_(value_count), keeps_(keeps) {}

    /// Appends `native`, values of `component` in this machine's byte order.
    void add(std::span<const std::byte> native, Component component, Scale scale = {});

    /// Values so far.
    std::size_t count() const { return dropped_ + values_.size() / size_bytes(type_); }

    /// Hands over type, values, minimum and maximum, and says what was converted.
    /// file     For error texts.
    /// Throws   ImportError if no value is finite, or one is beyond float32.
    void finish(const std::string& file, Volume& volume);

  private:
    template <typename T>
    void keep(std::span<const T> values);
    template <typename T>
    void fit(std::span<const T> values, Scale scale);
    void reserve_all(std::size_t value_bytes);
    void convert_held_to(Scalar type);
    void append(std::span<const double> values, Tolerance tolerance);
    void note_conversion(Volume& volume) const;

    std::size_t value_count_;
    Keeps keeps_;
    std::size_t dropped_ = 0;  ///< Values that are not kept.
    std::vector<std::byte> values_;
    Scalar type_ = Scalar::uint8;
    bool started_ = false, fitting_ = false, is_mixed_ = false, is_scaled_ = false;
    Component first_ = Component::uint8;
    double minimum_ = std::numeric_limits<double>::infinity();
    double maximum_ = -std::numeric_limits<double>::infinity();
    std::uint64_t not_finite_ = 0, inexact_ = 0;
};

}  // namespace pxpl5::host::io
