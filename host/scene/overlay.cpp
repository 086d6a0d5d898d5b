#include "host/scene/overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <sstream>
#include <utility>

namespace pxpl5::host {

namespace {

/// Components below this share of a direction have no letter.
const double least_component = std::sin(glm::pi<double>() / 8);
constexpr std::size_t max_legend_lines = 8;
/// Width of DejaVu Sans' letters over its size, on average and a little more.
constexpr double letter_width = 0.62;
/// Distance of two lines over the letters' size.
constexpr double line_step = 1.35;

/// Lengths in pixels, by the picture's shorter side.
struct Measures {
    double width, height;
    double unit;    ///< 1 at 512 pixels.
    double margin;  ///< Free at the picture's sides.
    float letter, small, halo;
    MarkColor ink, shade;  ///< Letters, and what parts lines from the surface behind them.
    MarkColor disc;        ///< Behind the body of directions.
    bool over_light;
};

Measures measures_of(const Overlay& overlay) {
    const Size size = overlay.size;
    const MarkColor& paper = overlay.background;
    const bool over_light = 0.299 * paper.r + 0.587 * paper.g + 0.114 * paper.b >= 128;
    const double unit = std::clamp(std::min(size.width, size.height) / 512.0, 0.6, 4.0);
    return {static_cast<double>(size.width),
            static_cast<double>(size.height),
            unit,
            10 * unit,
            static_cast<float>(20 * unit),
            static_cast<float>(std::max(12 * unit, 9.0)),
            static_cast<float>(std::max(2 * unit, 1.5)),
            over_light ? MarkColor{24, 26, 30, 255} : MarkColor{240, 240, 236, 255},
            over_light ? MarkColor{255, 255, 255, 170} : MarkColor{0, 0, 0, 150},
            over_light ? MarkColor{0, 0, 0, 36} : MarkColor{0, 0, 0, 90},
            over_light};
}

glm::vec2 at(double x, double y) {
    return {static_cast<float>(x), static_cast<float>(y)};
}

/// Right and up of the picture in patient axes.
struct PictureAxes {
    glm::dvec3 right, up, back;
};

PictureAxes axes_of(const Camera& camera, const Subject& subject) {
    const glm::dmat4 eye = camera_matrices(camera, subject, 1).patient_to_eye;
    PictureAxes axes{};
    for (int axis = 0; axis < 3; ++axis) {
        axes.right[axis] = eye[axis][0];
        axes.up[axis] = eye[axis][1];
        axes.back[axis] = eye[axis][2];
    }
    return axes;
}

void add_letters(const Overlay& overlay, const Measures& m, std::vector<PictureMark>& marks) {
    const PictureAxes axes = axes_of(overlay.camera, overlay.subject);
    struct Side {
        glm::dvec3 direction;
        glm::vec2 at;
        float align_x, align_y;
    };
    const double middle_x = m.width / 2, middle_y = m.height / 2;
    const std::array sides = {
        Side{-axes.right, at(m.margin, middle_y), 0, 0.5F},
        Side{axes.right, at(m.width - m.margin, middle_y), 1, 0.5F},
        Side{axes.up, at(middle_x, m.margin), 0.5F, 0},
        Side{-axes.up, at(middle_x, m.height - m.margin), 0.5F, 1},
    };
    for (const Side& side : sides) {
        marks.push_back(text_mark(side.at, direction_letters(side.direction), m.ink,
                                  {m.letter, side.align_x, side.align_y, m.halo}));
    }
}

void add_line(std::vector<glm::vec2> points, double width, const Measures& m,
              std::vector<PictureMark>& marks) {
    marks.push_back(line_mark(points, m.shade, static_cast<float>(width + 2.4)));
    marks.push_back(line_mark(std::move(points), m.ink, static_cast<float>(width)));
}

void add_scale(const Overlay& overlay, const Measures& m, std::vector<PictureMark>& marks) {
    const ScaleBar bar = scale_bar(overlay.camera, overlay.subject, overlay.size, m.width * 0.25);
    const double right = m.width - m.margin, y = m.height - m.margin, tick = 4 * m.unit;
    const double left = right - bar.length_px;
    add_line({at(left, y - 2 * tick), at(left, y), at(right, y), at(right, y - 2 * tick)},
             1.6 * m.unit, m, marks);
    marks.push_back(text_mark(at((left + right) / 2, y - tick),
                              fmt::format("{:g} mm", bar.length_mm), m.ink,
                              {m.small, 0.5F, 1, m.halo}));
}

std::vector<glm::vec2> disc(double x, double y, double radius) {
    constexpr int corners = 32;
    std::vector<glm::vec2> points;
    for (int corner = 0; corner < corners; ++corner) {
        const double angle = 2 * glm::pi<double>() * corner / corners;
        points.push_back(at(x + radius * std::cos(angle), y + radius * std::sin(angle)));
    }
    return points;
}

/// One of the six directions, as it lies in the picture.
struct Direction {
    std::string letter;
    glm::dvec2 place;  ///< Right and up, 1 at the circle.
    double towards;    ///< The viewer; 1 straight at him.
    MarkColor color;   ///< The same for both ends of an axis.
};

std::vector<Direction> six_directions(const PictureAxes& axes) {
    constexpr std::array colors = {MarkColor{226, 116, 104, 255}, MarkColor{122, 186, 106, 255},
                                   MarkColor{104, 152, 226, 255}};
    std::vector<Direction> directions;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            glm::dvec3 d(0);
            d[axis] = sign;
            directions.push_back({direction_letters(d),
                                  {glm::dot(d, axes.right), glm::dot(d, axes.up)},
                                  glm::dot(d, axes.back),
                                  colors[static_cast<std::size_t>(axis)]});
        }
    }
    // What is behind is drawn first. Rounding must not decide between equals.
    std::stable_sort(directions.begin(), directions.end(),
                     [](const Direction& a, const Direction& b) {
                         return std::round(a.towards / direction_rounding) <
                                std::round(b.towards / direction_rounding);
                     });
    return directions;
}

/// Letters on the ends of the patient's axes: full discs point to the viewer, faint ones away.
void add_directions(const Overlay& overlay, const Measures& m, std::vector<PictureMark>& marks) {
    const double radius = 30 * m.unit, knob = 8.5 * m.unit;
    const double x = m.width - m.margin - radius - knob, y = m.margin + radius + knob;
    marks.push_back(area_mark(disc(x, y, radius + knob * 1.25), m.disc));
    for (const Direction& d : six_directions(axes_of(overlay.camera, overlay.subject))) {
        const bool behind = d.towards < -direction_rounding;
        const double px = x + radius * d.place.x, py = y - radius * d.place.y;
        const double size = knob * (1 + 0.15 * d.towards);
        const auto dim = [&](std::uint8_t value) {
            return static_cast<std::uint8_t>(behind ? value * 0.45 : value);
        };
        const MarkColor color{dim(d.color.r), dim(d.color.g), dim(d.color.b), 255};
        marks.push_back(line_mark({at(x, y), at(px, py)}, color, static_cast<float>(1.8 * m.unit)));
        marks.push_back(area_mark(disc(px, py, size), color));
        marks.push_back(
            text_mark(at(px, py), d.letter,
                      behind ? MarkColor{190, 190, 190, 255} : MarkColor{16, 18, 22, 255},
                      {static_cast<float>(size * 1.35), 0.5F, 0.5F, 0}));
    }
}

/// `text` cut to so many characters, whole ones, with an ellipsis in place of the rest.
std::string cut_to(const std::string& text, std::size_t most) {
    std::size_t characters = 0, keep = text.size();
    for (std::size_t index = 0; index < text.size(); ++index) {
        if ((static_cast<unsigned char>(text[index]) & 0xC0) != 0x80 && ++characters == most) {
            keep = index;
        }
    }
    return characters <= most ? text : text.substr(0, keep) + "…";
}

void add_legend(const Overlay& overlay, const Measures& m, std::vector<PictureMark>& marks) {
    const double step = m.small * line_step, swatch = m.small * 0.62;
    const double room = m.width * 0.42 / (m.small * letter_width);
    const auto most = static_cast<std::size_t>(std::max(room, 8.0));  // Up to the bottom letter.
    double y = m.height - m.margin;
    const auto write = [&](double x, const std::string& text) {
        marks.push_back(text_mark(at(x, y), cut_to(text, most), m.ink, {m.small, 0, 1, m.halo}));
    };
    if (const std::string& title = overlay.caption.title; !title.empty()) {
        write(m.margin, title);
        y -= step;
    }
    const auto lines = static_cast<std::size_t>(m.height / 3 / step);
    const std::size_t shown = std::min({overlay.legend.size(), max_legend_lines, lines});
    if (shown < overlay.legend.size()) {
        write(m.margin, fmt::format("and {} more", overlay.legend.size() - shown));
        y -= step;
    }
    for (std::size_t index = shown; index-- > 0;) {
        const double low = y - m.small * 0.3, x = m.margin;
        const auto square = [&](double more) {
            return std::vector{at(x - more, low + more), at(x + swatch + more, low + more),
                               at(x + swatch + more, low - swatch - more),
                               at(x - more, low - swatch - more)};
        };
        marks.push_back(area_mark(square(std::max(1.0, m.unit)), m.shade));
        marks.push_back(area_mark(square(0), overlay.legend[index].color));
        write(x + swatch * 1.7, overlay.legend[index].text);
        y -= step;
    }
}

/// Left of the letter at the top, or, where that is too narrow, below the letter.
void add_alert(const Overlay& overlay, const Measures& m, std::vector<PictureMark>& marks) {
    const bool is_small = std::min(overlay.size.width, overlay.size.height) < smallest_legend_px;
    const double room = is_small ? m.width - 2 * m.margin : m.width / 2 - 2 * m.margin - m.letter;
    const double top = m.margin + (is_small ? m.letter * 1.2 : 0);
    for (PictureMark& mark : warning_marks(
             overlay.caption.warning, {at(m.margin, top), room, m.small, m.halo, m.over_light})) {
        marks.push_back(std::move(mark));
    }
}

/// `text` in lines of at most `most` characters. A longer word has a line of its own.
std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
    std::vector<std::string> lines;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (lines.empty() || lines.back().size() + 1 + word.size() > most) {
            lines.push_back(word);
        } else {
            lines.back() += " " + word;
        }
    }
    return lines;
}

}  // namespace

std::vector<PictureMark> warning_marks(const std::string& warning, const WarningPlace& place) {
    const MarkColor ink =
        place.over_light ? MarkColor{130, 60, 0, 255} : MarkColor{255, 208, 112, 255};
    const double room = place.room_px / (place.height_px * letter_width);
    std::vector<PictureMark> marks;
    glm::vec2 at = place.at;
    for (std::string& line : wrapped(warning, static_cast<std::size_t>(std::max(room, 1.0)))) {
        marks.push_back(
            text_mark(at, std::move(line), ink, {place.height_px, 0, 0, place.halo_px}));
        at.y += place.height_px * static_cast<float>(line_step);
    }
    return marks;
}

std::string direction_letters(const glm::dvec3& direction) {
    const double length = glm::length(direction);
    std::array<std::pair<double, char>, 3> parts;
    for (int axis = 0; axis < 3; ++axis) {
        const double part = length > 0 ? direction[axis] / length : 0;
        parts[static_cast<std::size_t>(axis)] = {std::abs(part),
                                                 part > 0 ? "LPS"[axis] : "RAI"[axis]};
    }
    std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
        return std::round(a.first / direction_rounding) > std::round(b.first / direction_rounding);
    });
    std::string letters;
    for (const auto& [part, letter] : parts) {
        if (part >= least_component) {
            letters += letter;
        }
    }
    return letters;
}

ScaleBar scale_bar(const Camera& camera, const Subject& subject, Size size, double most_px) {
    const double aspect = static_cast<double>(size.width) / size.height;
    const CameraMatrices m = camera_matrices(camera, subject, aspect);
    const double distance_mm = -(m.patient_to_eye * glm::dvec4(subject.center_mm, 1)).z;
    const double px_per_mm = m.projection[0][0] * size.width / 2 / distance_mm;
    const double most_mm = most_px / px_per_mm;
    double length_mm = std::pow(10.0, std::floor(std::log10(most_mm)));
    for (const double factor : {5.0, 2.0}) {
        if (length_mm * factor <= most_mm) {
            length_mm *= factor;
            break;
        }
    }
    return {length_mm, length_mm * px_per_mm};
}

std::vector<LegendLine> legend_of(std::span<const Surface> surfaces) {
    std::vector<LegendLine> legend;
    for (const Surface& surface : surfaces) {
        if (!surface.visible) {
            continue;
        }
        const Color& c = surface.color;
        legend.push_back(
            {{c.r, c.g, c.b, 255}, fmt::format("{}  {:.6g}", surface.name, surface.isovalue)});
    }
    return legend;
}

std::vector<PictureMark> overlay_marks(const Overlay& overlay) {
    std::vector<PictureMark> marks;
    const int side_px = std::min(overlay.size.width, overlay.size.height);
    if (side_px < smallest_overlay_px) {
        return marks;
    }
    const Measures m = measures_of(overlay);
    if (overlay.directions && side_px >= smallest_legend_px) {
        add_directions(overlay, m, marks);
    }
    if (overlay.letters) {
        add_letters(overlay, m, marks);
    }
    add_alert(overlay, m, marks);
    if (overlay.scale) {
        add_scale(overlay, m, marks);
    }
    if (side_px >= smallest_legend_px) {
        add_legend(overlay, m, marks);
    }
    return marks;
}

std::vector<PictureMark> overlay_marks(const Scene& scene, const Subject& subject,
                                       const Caption& caption) {
    const Color& c = scene.background;
    return overlay_marks({scene.camera,
                          subject,
                          scene.size,
                          {c.r, c.g, c.b, 255},
                          caption,
                          legend_of(scene.surfaces),
                          true,
                          true,
                          true});
}

}  // namespace pxpl5::host
