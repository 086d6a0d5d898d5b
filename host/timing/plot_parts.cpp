#include "host/timing/plot_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/base/error.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr double swatch_width = 22, swatch_gap = 6, entry_gap = 18, disc_radius = 3;

void draw_entry(Svg& svg, const LegendEntry& entry, PlotPoint at) {
    const double middle = at.y - text_px * 0.35;
    if (entry.is_line) {
        const std::vector<PlotPoint> ends{{at.x, middle}, {at.x + swatch_width, middle}};
        svg.curve(ends, entry.colour, entry.dashed);
        if (!entry.dashed) {
            svg.disc({at.x + swatch_width / 2, middle}, disc_radius, entry.colour);
        }
    } else {
        svg.rectangle({at.x + swatch_width - text_px, middle - text_px / 2, text_px, text_px},
                      entry.colour);
    }
    svg.text({at.x + swatch_width + swatch_gap, at.y}, entry.name);
}

double entry_width(const LegendEntry& entry) {
    return swatch_width + swatch_gap + text_width(entry.name);
}

}  // namespace

void refuse_plot(const std::string& plot, const std::string& what) {
    throw RequestError(ExitCode::bad_data,
                       fmt::format("plot '{}' cannot be drawn: {}", plot, what));
}

void check_number(const std::string& plot, const std::string& where, double value) {
    if (!std::isfinite(value)) {
        refuse_plot(plot, fmt::format("{} is {}, no finite number", where, value));
    }
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

void draw_legend_column(Svg& svg, std::span<const LegendEntry> entries, PlotPoint at) {
    for (const LegendEntry& entry : entries) {
        at.y += line_height;
        draw_entry(svg, entry, at);
    }
}

double draw_legend_row(Svg& svg, std::span<const LegendEntry> entries, PlotPoint at, double width) {
    double x = at.x, y = at.y + line_height;
    for (const LegendEntry& entry : entries) {
        if (x > at.x && x + entry_width(entry) > at.x + width) {
            x = at.x;
            y += line_height;
        }
        draw_entry(svg, entry, {x, y});
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

double draw_heading(Svg& svg, const std::string& title, const std::string& y_label, double y) {
    if (!title.empty()) {
        y += title_px;
        svg.text({plot_margin, y}, title, {.size_px = title_px, .bold = true});
        y += 4;
    }
    if (!y_label.empty()) {
        y += line_height;
        svg.text({plot_margin, y}, y_label, {.colour = pale_ink});
    }
    return y + 12;
}

double draw_note(Svg& svg, const std::string& note, double y, double width) {
    constexpr double note_px = 11;
    for (const std::string& line : broken(note, width, note_px)) {
        y += line_height;
        svg.text({plot_margin, y}, line, {.size_px = note_px, .colour = pale_ink});
    }
    return y;
}

double x_in(const Box& box, const ChartAxis& axis, double value) {
    return box.x + box.width * axis.place(value);
}

double y_in(const Box& box, const ChartAxis& axis, double value) {
    return box.y + box.height * (1 - axis.place(value));
}

double y_axis_width(const ChartAxis& axis) {
    double width = 0;
    for (const double tick : axis.ticks) {
        width = std::max(width, text_width(grouped(tick)));
    }
    return width + tick_gap;
}

void draw_y_axis(Svg& svg, const Box& box, const ChartAxis& axis) {
    for (const double tick : axis.ticks) {
        const double y = y_in(box, axis, tick);
        svg.line({box.x, y}, {box.x + box.width, y}, grid_ink);
        svg.text({box.x - tick_gap, y + text_px * 0.35}, grouped(tick), {.anchor = Anchor::end});
    }
}

void draw_x_axis(Svg& svg, const Box& box, const ChartAxis& axis, const std::string& label) {
    const double bottom = box.y + box.height;
    double free_from = box.x - plot_margin;
    for (const double tick : axis.ticks) {
        const double x = x_in(box, axis, tick), half = text_width(grouped(tick)) / 2;
        svg.line({x, box.y}, {x, bottom}, grid_ink);
        if (x - half >= free_from) {
            svg.text({x, bottom + line_height}, grouped(tick), {.anchor = Anchor::middle});
            free_from = x + half + tick_gap;
        }
    }
    svg.line({box.x, bottom}, {box.x + box.width, bottom}, axis_ink);
    svg.text({box.x + box.width / 2, bottom + 2 * line_height + 2}, label,
             {.anchor = Anchor::middle, .colour = pale_ink});
}

}  // namespace pxpl5::host::timing
