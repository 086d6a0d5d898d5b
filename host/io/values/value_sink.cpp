#include "host/io/values/value_sink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>

#include "host/io/values/import_request.hpp"
#include "host/io/values/scalar_types.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t block_values = 4096;  // As float64, 32 KiB stay in the cache.
constexpr double float_rounding = 0x1p-24;  // Share of a value that float32 rounds away at most.
constexpr double max_value = std::numeric_limits<float>::max();  // What float32 holds.

std::optional<Scalar> kept_type(Component component) {
    switch (component) {
        case Component::uint8:
            return Scalar::uint8;
        case Component::int16:
            return Scalar::int16;
        case Component::uint16:
            return Scalar::uint16;
        case Component::float32:
            return Scalar::float32;
        default:
            return std::nullopt;
    }
}

struct Block {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    std::uint64_t not_finite = 0;
    bool whole = true;

    void look_at(double value) {
        if (!std::isfinite(value)) {
            ++not_finite;
            whole = false;
            return;
        }
        low = std::min(low, value);
        high = std::max(high, value);
        whole = whole && std::trunc(value) == value;
    }
};

template <typename T>
bool fits(double low, double high) {
    return low >= std::numeric_limits<T>::min() && high <= std::numeric_limits<T>::max();
}

}  // namespace

void ValueSink::add(std::span<const std::byte> native, Component component, Scale scale) {
    if (native.empty()) {
        return;
    }
    const std::optional<Scalar> kept = kept_type(component);
    const bool keeps = kept && scale.is_identity() && !fitting_ && (!started_ || type_ == *kept);
    is_mixed_ = is_mixed_ || (started_ && component != first_);
    is_scaled_ = is_scaled_ || !scale.is_identity();
    if (!started_) {
        first_ = component;
        type_ = keeps ? *kept : Scalar::int16;
    }
    with_type(component, [&]<typename T>(T*) {
        keeps ? keep(typed<T>(native)) : fit(typed<T>(native), scale);
    });
    started_ = true;
    if (keeps_ == Keeps::none) {
        dropped_ = count();
        values_.clear();
    }
}

void ValueSink::reserve_all(std::size_t value_bytes) {
    if (keeps_ == Keeps::all) {
        values_.reserve(value_count_ * value_bytes);
    }
}

template <typename T>
void ValueSink::keep(std::span<const T> values) {
    T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
    std::uint64_t not_finite = 0;
    for (const T value : values) {
        if constexpr (std::is_floating_point_v<T>) {
            if (!std::isfinite(value)) {
                ++not_finite;
                continue;
            }
        }
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (not_finite < values.size()) {
        minimum_ = std::min(minimum_, static_cast<double>(low));
        maximum_ = std::max(maximum_, static_cast<double>(high));
    }
    not_finite_ += not_finite;
    reserve_all(sizeof(T));
    const auto bytes = std::as_bytes(values);
    values_.insert(values_.end(), bytes.begin(), bytes.end());
}

template <typename T>
void ValueSink::fit(std::span<const T> values, Scale scale) {
    std::array<double, block_values> wide{};
    const bool is_whole_type = std::is_integral_v<T>;
    // Scaled values have digits that their file does not: those of whole numbers are lost only if
    // two of them become one, those of float32 only beyond float32.
    const Tolerance tolerance{is_whole_type ? std::abs(scale.slope) / 4 : 0,
                              std::is_same_v<T, float> ? float_rounding : 0};
    if (!fitting_ && type_ == Scalar::uint8) {
        convert_held_to(Scalar::int16);
    } else if (!fitting_ && type_ == Scalar::uint16 && maximum_ <= INT16_MAX) {
        type_ = Scalar::int16;
    }
    fitting_ = true;
    for (std::size_t begin = 0; begin < values.size(); begin += block_values) {
        const std::size_t count = std::min(block_values, values.size() - begin);
        Block block;
        for (std::size_t i = 0; i < count; ++i) {
            const T stored = values[begin + i];
            wide[i] = scaled(stored, scale);
            if constexpr (sizeof(T) == 8 && std::is_integral_v<T>) {
                // Counted here only if append() will not see it.
                inexact_ += scale.is_identity() &&
                            static_cast<long double>(wide[i]) != static_cast<long double>(stored) &&
                            static_cast<double>(static_cast<float>(wide[i])) == wide[i];
            }
            block.look_at(wide[i]);
        }
        not_finite_ += block.not_finite;
        minimum_ = std::min(minimum_, block.low);
        maximum_ = std::max(maximum_, block.high);
        const bool whole = is_whole_type && block.whole && type_ != Scalar::float32;
        convert_held_to(whole && fits<std::int16_t>(minimum_, maximum_)    ? Scalar::int16
                        : whole && fits<std::uint16_t>(minimum_, maximum_) ? Scalar::uint16
                                                                           : Scalar::float32);
        append({wide.data(), count}, tolerance);
    }
}

/// Stored values fit `type`, because their range does.
void ValueSink::convert_held_to(Scalar type) {
    if (type == type_) {
        return;
    }
    if (size_bytes(type) != size_bytes(type_)) {
        std::vector<std::byte> old = std::move(values_);
        const std::size_t count = old.size() / size_bytes(type_);
        values_ = {};
        reserve_all(size_bytes(type));
        values_.resize(count * size_bytes(type));
        with_scalar(type_, [&]<typename From>(From*) {
            const auto from = typed<From>(std::span<const std::byte>(old));
            with_scalar(type, [&]<typename To>(To*) {
                auto* to = reinterpret_cast<To*>(values_.data());
                std::transform(from.begin(), from.end(), to,
                               [](From value) { return static_cast<To>(value); });
            });
        });
    }
    type_ = type;  // Between int16 and uint16 the bits of a value that fits both are the same.
}

void ValueSink::append(std::span<const double> values, Tolerance tolerance) {
    const std::size_t before = values_.size();
    reserve_all(size_bytes(type_));
    values_.resize(before + values.size() * size_bytes(type_));
    with_scalar(type_, [&]<typename To>(To*) {
        auto* to = reinterpret_cast<To*>(values_.data() + before);
        for (std::size_t i = 0; i < values.size(); ++i) {
            to[i] = static_cast<To>(values[i]);
            const bool is_nan = values[i] != values[i];
            const auto held = static_cast<double>(to[i]);
            const double most = tolerance.absolute + tolerance.relative * std::abs(values[i]);
            inexact_ += !is_nan && held != values[i] && !(std::abs(held - values[i]) <= most);
        }
    });
}

void ValueSink::note_conversion(Volume& volume) const {
    if (!fitting_) {
        return;
    }
    const std::string from = fmt::format("{}{} values", is_scaled_ ? "scaled " : "",
                                         is_mixed_ ? "slices' differing" : component_name(first_));
    const char* to = enum_name(type_);
    if (is_scaled_ && inexact_ == 0 && to == std::string_view(component_name(first_))) {
        return;
    }
    volume.findings.push_back(
        {FindingKind::conversion, inexact_ == 0
                                      ? fmt::format("{} are held as {}, without loss", from, to)
                                      : fmt::format("{} are held as {}: {} of {} are rounded", from,
                                                    to, inexact_, count())});
}

void ValueSink::finish(const std::string& file, Volume& volume) {
    if (count() != value_count_) {  // A file may change while it is read.
        throw ImportError(
            fmt::format("{}: {} values were read, {} were expected: the file has "
                        "changed; read it again when it is complete",
                        file, count(), value_count_));
    }
    if (not_finite_ == count()) {
        throw ImportError(fmt::format("{}: none of its {} values is finite", file, count()));
    }
    if (minimum_ < -max_value || maximum_ > max_value) {
        throw ImportError(
            fmt::format("{}: its values reach from {:g} to {:g}, must be within +-{:g} (float32)",
                        file, minimum_, maximum_, max_value));
    }
    if (not_finite_ > 0) {
        volume.findings.push_back({FindingKind::note, fmt::format("{} of {} values are not finite",
                                                                  not_finite_, count())});
    }
    note_conversion(volume);
    volume.type = type_;
    // Looked up in the type, since g++ 12 drops the narrowing of `b ? double(float(x)) : x`.
    with_scalar(type_, [&]<typename T>(T*) {
        volume.minimum = static_cast<double>(static_cast<T>(minimum_));
        volume.maximum = static_cast<double>(static_cast<T>(maximum_));
    });
    volume.values = std::move(values_);
}

}  // namespace pxpl5::host::io
