// What checking ranges takes: a collector of the first thing that is wrong.
#pragma once

#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Collects the first thing that is wrong.
class Check {
  public:
    template <typename Value, typename Limit>
    Check& within(const char* field, Value value, Limit low, Limit high) {
        if (!(value >= static_cast<Value>(low) && value <= static_cast<Value>(high))) {
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
    template <typename Value>
    Check& at_most(const char* field, Value value, Value limit) {
        if (!(value <= limit)) {
            fail(fmt::format("{} is {}, allowed are at most {}", field, value, limit));
        }
        return *this;
    }
    const std::string& reason() const { return reason_; }

  private:
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

/// Empty if all is well with a message about volumes, surfaces, scenes, pictures or meshes, or if
/// it is none.
std::string model_out_of_range(const schema::Message& message);

}  // namespace pxpl5::bus
