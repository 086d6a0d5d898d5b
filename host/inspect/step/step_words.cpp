#include "host/inspect/step/step_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/inspect/step/step_view.hpp"

namespace pxpl5::host::inspect {

namespace {

PrimitiveBreak cell_break(const std::vector<std::string>& words) {
    const std::vector<std::string> ijk = split(joined(words, 1), ", ");
    if (ijk.size() != 3) {
        refuse("a cell has three numbers: break cell I,J,K");
    }
    PrimitiveBreak stop;
    stop.cell = {index_of(ijk[0], "I"), index_of(ijk[1], "J"), index_of(ijk[2], "K")};
    return stop;
}

}  // namespace

void refuse(const std::string& text) {
    refuse_command(text);
}

std::int64_t number_of(const std::string& text, const char* what) {
    std::int64_t value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) {
        refuse(fmt::format("'{}' is no number: {} is expected", text, what));
    }
    return value;
}

std::int64_t number_or(const std::vector<std::string>& words, std::size_t index,
                       std::int64_t fallback, const char* what) {
    return index < words.size() ? number_of(words[index], what) : fallback;
}

std::uint32_t index_of(const std::string& text, const char* what) {
    const std::int64_t value = number_of(text, what);
    if (value < 0 || value > 0xFFFF'FFFF) {
        refuse(fmt::format("'{}' is out of range: {} is expected", text, what));
    }
    return static_cast<std::uint32_t>(value);
}

std::vector<std::string> split(const std::string& text, const char* separators) {
    std::vector<std::string> words;
    for (std::size_t at = 0; (at = text.find_first_not_of(separators, at)) != std::string::npos;) {
        const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end;
    }
    return words;
}

std::string joined(const std::vector<std::string>& words, std::size_t first) {
    std::string text;
    for (std::size_t i = first; i < words.size(); ++i) {
        text += (i == first ? "" : " ") + words[i];
    }
    return text;
}

Break break_of(const std::vector<std::string>& words, const Stepper& stepper) {
    const std::string kind = words.empty() ? "" : words[0];
    const auto pixel = [&](std::size_t at) {
        const int x = static_cast<int>(number_of(words[at], "X"));
        const int y = static_cast<int>(number_of(words[at + 1], "Y"));
        stepper.frame().region_at(x, y);  // Refuses what is outside.
        return std::pair(x, y);
    };
    if (kind == "op" && words.size() == 2) {
        return OpBreak{words[1]};
    }
    if (kind == "pixel" && words.size() == 3) {
        const auto [x, y] = pixel(1);
        return PixelBreak{x, y};
    }
    if (kind == "z" && words.size() == 5 && words[3] == "<") {
        const auto [x, y] = pixel(1);
        return DepthBreak{x, y, index_of(words[4], "a depth")};
    }
    if (kind == "empty" && words.size() == 1) {
        return EmptyBreak{};
    }
    if (kind == "cell" && words.size() > 1) {
        return cell_break(words);
    }
    if (kind == "primitive" && words.size() == 2) {
        PrimitiveBreak stop;
        stop.number = index_of(words[1], "a primitive's number");
        return stop;
    }
    if (kind == "at" && words.size() > 1) {
        return AddressBreak{stepper.region().place.number,
                            address_of(stepper.region().plan, joined(words, 1))};
    }
    refuse(
        "a breakpoint is one of: break op PATTERN, break pixel X Y, break z X Y < V, "
        "break empty, break cell I,J,K, break primitive N, break at ADDRESS");
}

}  // namespace pxpl5::host::inspect
