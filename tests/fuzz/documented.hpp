// Checks of numbers and lists, for the ranges of messages.
#pragma once

#include <cmath>
#include <utility>

#include "ringbus/message.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

template <typename Value, typename Low, typename High>
void in(const char* field, Value value, Low low, High high) {
    if constexpr (std::is_floating_point_v<Value>) {
        require(value >= static_cast<Value>(low) && value <= static_cast<Value>(high), field);
    } else {
        require(std::cmp_less_equal(low, value) && std::cmp_less_equal(value, high), field);
    }
}

template <typename... Numbers>
void finite(const char* field, Numbers... values) {
    require((std::isfinite(values) && ...), field);
}

inline void finite(const char* field, const bus::schema::Matrix& matrix) {
    for (const double value : *matrix.m()) {
        finite(field, value);
    }
}

template <typename Enum>
void known(const char* field, Enum value) {
    in(field, static_cast<int>(value), static_cast<int>(Enum::MIN), static_cast<int>(Enum::MAX));
}

template <typename List>
std::size_t length(const List* list) {
    return list == nullptr ? 0 : list->size();
}

inline std::uint64_t regions_of(std::uint32_t width, std::uint32_t height, std::uint32_t views) {
    return std::uint64_t{(width + region_px - 1) / region_px} *
           ((height + region_px - 1) / region_px) * views;
}

/// Calls back for each element of a list, which may be absent.
template <typename List, typename Take>
void each(const List* list, const Take& take) {
    if (list != nullptr) {
        for (const auto& element : *list) {
            take(*element);
        }
    }
}

template <typename List>
void ascending(const char* field, const List* list) {
    for (flatbuffers::uoffset_t i = 1; i < length(list); ++i) {
        require(list->Get(i - 1) < list->Get(i), field);
    }
}

template <typename List, typename Low, typename High>
void triple(const char* field, const List* list, Low low, High high) {
    require(list == nullptr || list->size() == 3, field);
    for (flatbuffers::uoffset_t i = 0; i < length(list); ++i) {
        in(field, list->Get(i), low, high);
    }
}

/// Checks the body if it is a table T.
template <typename T, typename Check>
void if_kind(const bus::Message& message, const Check& check) {
    if (const T* body = message.as<T>()) {
        check(*body);
    }
}

}  // namespace pxpl5::fuzz
