// Shapes and texts of an SVG picture. Lengths are pixels, y downwards.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/timing/plot.hpp"

namespace pxpl5::host::timing {

inline constexpr double text_px = 12;
inline constexpr double title_px = 14;
inline constexpr std::string_view ink = "#222222", pale_ink = "#555555", grid_ink = "#dddddd",
                                  axis_ink = "#777777";

/// One of eight colours, going round.
std::string_view colour_of(std::size_t index);

/// No less than what the text needs: fonts differ.
double text_width(std::string_view text, double size_px = text_px);

/// Where a text's (x, y), which is on its base line, lies in it.
enum class Anchor : std::uint8_t { start, middle, end };

struct TextStyle {
    Anchor anchor = Anchor::start;
    double size_px = text_px;
    std::string_view colour = ink;
    bool bold = false;
};

struct Box {
    double x = 0, y = 0, width = 0, height = 0;
};

/// The elements of a picture, or of one plot of it.
struct Svg {
    std::string body;
    double width = 0, height = 0;

    void text(PlotPoint at, const std::string& text, const TextStyle& style = {});
    void line(PlotPoint from, PlotPoint to, std::string_view colour, double width_px = 1);
    void rectangle(const Box& box, std::string_view colour);
    void curve(std::span<const PlotPoint> points, std::string_view colour, bool dashed);
    /// Filled, or a ring around what is there.
    void disc(PlotPoint centre, double radius, std::string_view colour, bool ring = false);
    /// All of `other`, moved.
    void place(const Svg& other, PlotPoint at);
    /// The picture as a document, on white.
    std::string document() const;
};

}  // namespace pxpl5::host::timing
