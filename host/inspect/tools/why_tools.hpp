// The commands `why` and `why-not`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace pxpl5::host::inspect {

struct PixelOptions {
    std::string run;
    int x = 0, y = 0;
    std::optional<std::uint32_t> frame;
    bool json = false;
    std::string output;
};

struct WhyNotTool {
    PixelOptions pixel;
    std::string cell;
    std::optional<std::uint32_t> surface;
    std::optional<int> triangle;
};

/// Each returns the exit code, and throws RequestError.
int run_why(const PixelOptions& options);
/// 1 if there is no verdict, as data are missing.
int run_why_not(const WhyNotTool& tool);

}  // namespace pxpl5::host::inspect
