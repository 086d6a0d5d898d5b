#include "host/timing/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace pxpl5::host::timing {

namespace {

constexpr std::string_view fonts = "Helvetica, Arial, 'DejaVu Sans', sans-serif";

/// At most two digits of a fraction: a hundredth of a pixel.
std::string px(double length) {
    std::string text = fmt::format("{:.2f}", length);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) {
        text.pop_back();
    }
    return text == "-0" ? "0" : text;
}

std::string_view anchor_word(Anchor anchor) {
    switch (anchor) {
        case Anchor::middle:
            return "middle";
        case Anchor::end:
            return "end";
        case Anchor::start:
            break;
    }
    return "start";
}

}  // namespace

std::string_view colour_of(std::size_t index) {
    constexpr std::array<std::string_view, 8> colours{"#1668ab", "#cf5f12", "#2b8a4e", "#8a4fb0",
                                                      "#b3882a", "#c0395b", "#2aa1a8", "#6a6a6a"};
    return colours[index % colours.size()];
}

double text_width(std::string_view text, double size_px) {
    constexpr double widest_mean_em = 0.62;
    const auto is_start = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
    return static_cast<double>(std::ranges::count_if(text, is_start)) * widest_mean_em * size_px;
}

std::string xml_text(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            case '"':
                safe += "&quot;";
                break;
            case '\'':
                safe += "&apos;";
                break;
            default:
                if (static_cast<unsigned char>(c) >= ' ' && c != '\x7F') {
                    safe += c;
                }
        }
    }
    return safe;
}

void Svg::text(PlotPoint at, const std::string& text, const TextStyle& style) {
    if (text.empty()) {
        return;
    }
    body +=
        fmt::format(R"(<text x="{}" y="{}" text-anchor="{}" font-size="{}" fill="{}"{}>{}</text>)"
                    "\n",
                    px(at.x), px(at.y), anchor_word(style.anchor), px(style.size_px), style.colour,
                    style.bold ? R"( font-weight="600")" : "", xml_text(text));
}

void Svg::line(PlotPoint from, PlotPoint to, std::string_view colour, double width_px) {
    body += fmt::format(R"(<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="{}" stroke-width="{}"/>)"
                        "\n",
                        px(from.x), px(from.y), px(to.x), px(to.y), colour, px(width_px));
}

void Svg::rectangle(const Box& box, std::string_view colour) {
    body += fmt::format(R"(<rect x="{}" y="{}" width="{}" height="{}" fill="{}"/>)"
                        "\n",
                        px(box.x), px(box.y), px(box.width), px(box.height), colour);
}

void Svg::curve(std::span<const PlotPoint> points, std::string_view colour, bool dashed) {
    std::string places;
    for (const PlotPoint& point : points) {
        fmt::format_to(std::back_inserter(places), "{}{},{}", places.empty() ? "" : " ",
                       px(point.x), px(point.y));
    }
    body += fmt::format(R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="2")"
                        R"( stroke-linejoin="round"{}/>)"
                        "\n",
                        places, colour, dashed ? R"( stroke-dasharray="6 4")" : "");
}

void Svg::disc(PlotPoint centre, double radius, std::string_view colour, bool ring) {
    body += fmt::format(
        R"(<circle cx="{}" cy="{}" r="{}" fill="{}" stroke="{}" stroke-width="{}"/>)"
        "\n",
        px(centre.x), px(centre.y), px(radius), ring ? "none" : colour, colour, ring ? 2 : 0);
}

void Svg::place(const Svg& other, PlotPoint at) {
    body +=
        fmt::format("<g transform=\"translate({},{})\">\n{}</g>\n", px(at.x), px(at.y), other.body);
}

std::string Svg::document() const {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}")"
        R"( viewBox="0 0 {0} {1}" font-family="{2}">)"
        "\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{3}</svg>\n",
        px(width), px(height), fonts, body);
}

}  // namespace pxpl5::host::timing
