// Range checks of message fields. Plain helpers of ranges.cpp and ranges_model.cpp.
#pragma once

#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Collects the first field that is out of range.
class Check {
  public:
    template <typename Value, typename Low, typename High>
    Check& within(const char* field, Value value, Low low, High high) {
        if (!(is_at_most(low, value) && is_at_most(value, high))) {
            fail(fmt::format("{} is {}, allowed are {} .. {}", field, value, low, high));
        }
        return *this;
    }
    template <typename Value>
    Check& equal(const char* field, Value value, Value wanted) {
        if (value != wanted) {
            fail(fmt::format("{} is {}, expected {}", field, value, wanted));
        }
        return *this;
    }
    Check& finite(const char* field, const schema::Matrix& matrix) {
        for (const double value : *matrix.m()) {
            if (!std::isfinite(value)) {
                fail(fmt::format("{} holds {}", field, value));
            }
        }
        return *this;
    }
    Check& finite(const char* field, double value) {
        if (!std::isfinite(value)) {
            fail(fmt::format("{} is {}", field, value));
        }
        return *this;
    }
    /// Checks that a length is finite and not negative.
    Check& length(const char* field, double value) {
        return within(field, value, 0.0, std::numeric_limits<double>::max());
    }
    Check& add(const std::string& reason) {
        if (!reason.empty()) {
            fail(reason);
        }
        return *this;
    }
    template <typename Enum>
    Check& known(const char* field, Enum value) {
        return within(field, static_cast<int>(value), static_cast<int>(Enum::MIN),
                      static_cast<int>(Enum::MAX));
    }
    template <typename Value, typename Limit>
    Check& at_most(const char* field, Value value, Limit limit) {
        if (!is_at_most(value, limit)) {
            fail(fmt::format("{} is {}, allowed are at most {}", field, value, limit));
        }
        return *this;
    }
    const std::string& reason() const { return reason_; }

  private:
    /// Compares in the common type. No limit is negative where the value is unsigned.
    template <typename A, typename B>
    static bool is_at_most(A a, B b) {
        using Common = std::common_type_t<A, B>;
        return static_cast<Common>(a) <= static_cast<Common>(b);
    }
    void fail(const std::string& reason) {
        if (reason_.empty()) {
            reason_ = reason;
        }
    }
    std::string reason_;
};

template <typename Vector>
std::size_t size_of(const Vector* vector) {
    return vector == nullptr ? 0 : vector->size();
}

/// Counts the elements in the lists of a message. Each element takes a byte at least, so that more
/// elements than bytes are a sign of lists that share elements.
class Elements {
  public:
    explicit Elements(std::size_t body_bytes) : left_(body_bytes), body_bytes_(body_bytes) {}

    /// Returns false, and lets `check` fail, if there are too many.
    bool take(Check& check, std::size_t count) {
        if (count > left_) {
            check.add(fmt::format("its lists have more elements than its {} bytes", body_bytes_));
            return false;
        }
        left_ -= count;
        return true;
    }

  private:
    std::size_t left_, body_bytes_;
};

/// Checks messages about volumes, surfaces, scenes, pictures and meshes. Returns "" if all fields
/// are in range, and for messages of other kinds.
std::string model_out_of_range(const schema::Message& message, std::size_t body_bytes);

/// The same for volumes.
std::string volume_out_of_range(const schema::Message& message, std::size_t body_bytes);

/// Returns the first field of the header's files that is out of range, with its value; empty if
/// none is, or if the header has no files. The values lie within the files, which have all slices.
/// elements  Takes the paths, each of which the host copies.
std::string files_out_of_range(const schema::VolumeHeader& header, Elements& elements);

}  // namespace pxpl5::bus
