// The words of a stepper's command line: numbers, places, breakpoints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/inspect/step/stepper.hpp"

namespace pxpl5::host::inspect {

/// Throws RequestError (usage).
[[noreturn]] void refuse(const std::string& text);

std::vector<std::string> split(const std::string& text, const char* separators);
/// Words from `first` on, with blanks between.
std::string joined(const std::vector<std::string>& words, std::size_t first);

/// what  Is named where `text` is no number. Throws RequestError (usage).
std::int64_t number_of(const std::string& text, const char* what);
/// Word `index` as a number; `fallback` if there is none.
std::int64_t number_or(const std::vector<std::string>& words, std::size_t index,
                       std::int64_t fallback, const char* what);
/// A number of 0 .. 2^32-1.
std::uint32_t index_of(const std::string& text, const char* what);

/// The breakpoint of the words behind "break". Throws RequestError (usage) that lists the kinds.
Break break_of(const std::vector<std::string>& words, const Stepper& stepper);

}  // namespace pxpl5::host::inspect
