#include "host/chart/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

namespace pxpl5::host {

namespace {

constexpr double swatch_width = 22, swatch_gap = 6, entry_gap = 18, disc_radius = 3;
constexpr double ascent_em = 0.928;  // DejaVu Sans, from a line's top to its base line.
constexpr double curve_px = 2, dash_px = 6, dash_gap_px = 4;

glm::vec2 to_mark(ChartPoint p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

std::vector<glm::vec2> to_marks(std::span<const ChartPoint> points) {
    std::vector<glm::vec2> all;
    std::ranges::transform(points, std::back_inserter(all), to_mark);
    return all;
}

std::vector<glm::vec2> circle(ChartPoint center, double radius) {
    constexpr int corners = 24;
    std::vector<glm::vec2> points;
    for (int i = 0; i < corners; ++i) {
        const double turn = 2 * std::numbers::pi * i / corners;
        points.push_back(
            to_mark({center.x + radius * std::cos(turn), center.y + radius * std::sin(turn)}));
    }
    return points;
}

void draw_entry(Chart& chart, const LegendEntry& entry, ChartPoint at) {
    const double middle = at.y - text_px * 0.36;
    if (entry.is_line) {
        const std::array<ChartPoint, 2> ends{ChartPoint{at.x, middle},
                                             ChartPoint{at.x + swatch_width, middle}};
        if (entry.dashed) {
            chart.dashed(ends, entry.color, curve_px);
        } else {
            chart.line(ends, entry.color, curve_px);
            chart.disc({at.x + swatch_width / 2, middle}, disc_radius, entry.color);
        }
    } else {
        const double left = at.x + swatch_width - text_px;
        chart.area({left, middle - text_px / 2, left + text_px, middle + text_px / 2}, entry.color);
    }
    chart.text({at.x + swatch_width + swatch_gap, at.y}, entry.name);
}

double entry_width(const LegendEntry& entry) {
    return swatch_width + swatch_gap + text_width(entry.name);
}

}  // namespace

MarkColor series_color(std::size_t index) {
    constexpr std::array<MarkColor, 8> colors{{{22, 104, 171, 255},
                                               {207, 95, 18, 255},
                                               {43, 138, 78, 255},
                                               {138, 79, 176, 255},
                                               {179, 136, 42, 255},
                                               {192, 57, 91, 255},
                                               {42, 161, 168, 255},
                                               {106, 106, 106, 255}}};
    return colors[index % colors.size()];
}

double ChartBox::x(const ChartAxis& axis, double value) const {
    return left + (right - left) * axis.place(value);
}

double ChartBox::y(const ChartAxis& axis, double value) const {
    return bottom - (bottom - top) * axis.place(value);
}

ChartPoint ChartBox::at(const ChartAxis& x_axis, double x_value, const ChartAxis& y_axis,
                        double y_value) const {
    return {x(x_axis, x_value), y(y_axis, y_value)};
}

void Chart::text(ChartPoint at, const std::string& text, const ChartText& style) {
    if (!text.empty()) {
        marks.push_back(text_mark(to_mark({at.x, at.y - ascent_em * style.size_px}), text,
                                  style.color,
                                  {static_cast<float>(style.size_px), style.align_x, 0, 0}));
    }
}

void Chart::line(std::span<const ChartPoint> points, MarkColor color, double width_px) {
    if (points.size() > 1) {
        marks.push_back(line_mark(to_marks(points), color, static_cast<float>(width_px)));
    }
}

void Chart::line(ChartPoint from, ChartPoint to, MarkColor color, double width_px) {
    const std::array ends{from, to};
    line(ends, color, width_px);
}

void Chart::dashed(std::span<const ChartPoint> points, MarkColor color, double width_px) {
    double from = 0;  // Where in the pattern of a dash and a gap the next segment begins.
    for (std::size_t i = 1; i < points.size(); ++i) {
        const ChartPoint a = points[i - 1], b = points[i];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        if (length == 0) {
            continue;
        }
        const auto along = [&](double at) {
            const double part = std::clamp(at / length, 0.0, 1.0);
            return ChartPoint{a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part};
        };
        double start = -from;
        for (; start < length; start += dash_px + dash_gap_px) {
            if (start + dash_px > 0) {
                line(along(start), along(start + dash_px), color, width_px);
            }
        }
        from = length - (start - dash_px - dash_gap_px);
    }
}

void Chart::area(const ChartBox& box, MarkColor color) {
    marks.push_back(area_mark({to_mark({box.left, box.top}), to_mark({box.right, box.top}),
                               to_mark({box.right, box.bottom}), to_mark({box.left, box.bottom})},
                              color));
}

void Chart::disc(ChartPoint center, double radius, MarkColor color) {
    marks.push_back(area_mark(circle(center, radius), color));
}

void Chart::ring(ChartPoint center, double radius, MarkColor color) {
    std::vector<glm::vec2> points = circle(center, radius);
    points.insert(points.end(), {points[0], points[1]});  // Joins the ends.
    marks.push_back(line_mark(std::move(points), color, static_cast<float>(curve_px)));
}

void Chart::place(const Chart& other, ChartPoint at) {
    for (PictureMark mark : other.marks) {
        for (glm::vec2& p : mark.points) {
            p += to_mark(at);
        }
        marks.push_back(std::move(mark));
    }
}

Chart scaled(Chart chart, double factor) {
    const auto by = static_cast<float>(factor);
    chart.width *= factor;
    chart.height *= factor;
    for (PictureMark& mark : chart.marks) {
        for (glm::vec2& p : mark.points) {
            p *= by;
        }
        mark.width_px *= by;
        mark.height_px *= by;
    }
    return chart;
}

double text_width(std::string_view text, double size_px) {
    double em = 0;
    for (const char c : text) {
        if ((static_cast<unsigned char>(c) & 0xC0U) == 0x80U) {
            continue;  // Not the first byte of a character.
        }
        const std::string_view narrow = " ijlI.,:;'|!()[]/-ftr", wide = "mwMW%@";
        em += narrow.find(c) != std::string_view::npos ? 0.41
              : wide.find(c) != std::string_view::npos ? 0.99
              : c >= 'A' && c <= 'Z'                   ? 0.76
                                                       : 0.637;
    }
    return em * size_px;
}

std::string short_number(double value) {
    const double size = std::abs(value);
    if (size == 0) {
        return "0";
    }
    if (size >= 99.95) {
        return grouped(std::round(value));
    }
    std::string text = fmt::format("{:.{}f}", value, size >= 9.995 ? 1 : 2);
    if (size < 0.00995) {
        text = fmt::format("{:.2g}", value);
    } else {
        text.erase(text.find_last_not_of('0') + 1);
        text.erase(text.ends_with('.') ? text.size() - 1 : text.size());
    }
    return text;
}

double legend_width(std::span<const LegendEntry> entries) {
    double width = 0;
    for (const LegendEntry& entry : entries) {
        width = std::max(width, entry_width(entry));
    }
    return width;
}

void draw_legend_column(Chart& chart, std::span<const LegendEntry> entries, ChartPoint at) {
    for (const LegendEntry& entry : entries) {
        at.y += line_height;
        draw_entry(chart, entry, at);
    }
}

double draw_legend_row(Chart& chart, std::span<const LegendEntry> entries, ChartPoint at,
                       double width) {
    double x = at.x, y = at.y + line_height;
    for (const LegendEntry& entry : entries) {
        if (x > at.x && x + entry_width(entry) > at.x + width) {
            x = at.x;
            y += line_height;
        }
        draw_entry(chart, entry, {x, y});
        x += entry_width(entry) + entry_gap;
    }
    return y - at.y + line_height / 2;
}

std::vector<std::string> broken(const std::string& text, double width, double size_px) {
    std::vector<std::string> lines;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (!lines.empty() && text_width(lines.back() + " " + word, size_px) <= width) {
            lines.back() += " " + word;
        } else {
            lines.push_back(word);
        }
    }
    return lines;
}

double draw_heading(Chart& chart, const std::string& title, const std::string& y_label, double y) {
    if (!title.empty()) {
        y += title_px;
        chart.text({plot_margin, y}, title, {.size_px = title_px});
        y += 5;
    }
    if (!y_label.empty()) {
        y += line_height;
        chart.text({plot_margin, y}, y_label, {.color = pale_ink});
    }
    return y + 12;
}

double draw_note(Chart& chart, const std::string& note, double y, double width) {
    constexpr double note_px = 11;
    for (const std::string& line : broken(note, width, note_px)) {
        y += line_height;
        chart.text({plot_margin, y}, line, {.size_px = note_px, .color = pale_ink});
    }
    return y;
}

double y_axis_width(const ChartAxis& axis) {
    double width = 0;
    for (const double tick : axis.ticks) {
        width = std::max(width, text_width(grouped(tick)));
    }
    return width + tick_gap;
}

void draw_y_axis(Chart& chart, const ChartBox& box, const ChartAxis& axis) {
    for (const double tick : axis.ticks) {
        const double y = box.y(axis, tick);
        chart.line({box.left, y}, {box.right, y}, grid_ink);
        chart.text({box.left - tick_gap, y + text_px * 0.36}, grouped(tick),
                   {.align_x = 1, .color = pale_ink});
    }
}

void draw_x_axis(Chart& chart, const ChartBox& box, const ChartAxis& axis,
                 const std::string& label) {
    double free_from = box.left - plot_margin;
    for (const double tick : axis.ticks) {
        const double x = box.x(axis, tick), half = text_width(grouped(tick)) / 2;
        chart.line({x, box.top}, {x, box.bottom}, grid_ink);
        if (x - half >= free_from) {
            chart.text({x, box.bottom + line_height}, grouped(tick),
                       {.align_x = 0.5F, .color = pale_ink});
            free_from = x + half + tick_gap;
        }
    }
    chart.line({box.left, box.bottom}, {box.right, box.bottom}, axis_ink);
    chart.text({(box.left + box.right) / 2, box.bottom + 2 * line_height + 2}, label,
               {.align_x = 0.5F, .color = pale_ink});
}

}  // namespace pxpl5::host
