// Isovalues and colors of tissues in CT, where values are Hounsfield units.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/base/command_line.hpp"

namespace pxpl5::host {

/// A surface worth trying first. The isovalue ends in .5, so that it never meets a stored integer.
struct Tissue {
    std::string_view name;
    double isovalue_hu;
    Color color;
    std::string_view help;
};

/// By ascending isovalue.
/// Source  Customary windows: air -1000, lung -500, fat -100, water 0, muscle 10..40, soft bone
///         from about 150, cortical bone from about 500, teeth and metal above 2000.
std::span<const Tissue> tissues();

/// The reason why the isovalue of `tissue` means nothing in a scan of `modality`, with advice.
/// Empty for CT, and for scans that state no modality.
std::string refusal_of_tissue(std::string_view tissue, std::string_view modality);

/// Null if there is none of that name.
const Tissue* find_tissue(std::string_view name);

}  // namespace pxpl5::host
