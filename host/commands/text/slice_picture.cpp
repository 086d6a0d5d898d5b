#include "host/commands/text/slice_picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "host/base/error.hpp"
#include "host/chart/chart.hpp"
#include "host/commands/text/volume_text.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uint32_t opaque_black = 0xFF00'0000U;
constexpr float letter_px = 18, title_px = 12, halo_px = 2, margin_px = 8, contour_px = 1.5F,
                line_step = 1.35F;
constexpr MarkColor ink{240, 240, 236, 255};

/// Between a slice's voxels and a picture's pixels. Half a voxel lies beyond the outermost ones'
/// middles.
struct Scale {
    const SliceFrame& frame;
    double px_per_mm;

    static double length_mm(const SliceSide& side) {
        return side.place_mm(side.count - 1) + side.spacing_mm;
    }
    int length_px(const SliceSide& side) const {
        return std::max(1, static_cast<int>(std::lround(length_mm(side) * px_per_mm)));
    }
    /// Voxel, counted along the side, at a place in the picture; held at the outermost ones.
    double number_at(const SliceSide& side, double at_px) const {
        const double number = side.number_at(at_px / px_per_mm - side.spacing_mm / 2);
        return std::clamp(number, 0.0, side.count - 1.0);
    }
    float at_px(const SliceSide& side, float at_slice_px) const {
        const double mm = side.place_mm(at_slice_px) + side.spacing_mm / 2;
        return static_cast<float>(mm * px_per_mm);
    }
};

Scale scale_of(const SliceFrame& frame, Size size) {
    return {frame, std::min(size.width / Scale::length_mm(frame.across),
                            size.height / Scale::length_mm(frame.down))};
}

double value_at(const SliceFrame& frame, const std::vector<double>& numbers, double x, double y) {
    const auto width = static_cast<std::size_t>(frame.across.count);
    const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y);
    const std::size_t right = x0 + 1 < width ? 1 : 0;
    const std::size_t below = y0 + 1 < static_cast<std::size_t>(frame.down.count) ? width : 0;
    const double* v = numbers.data() + y0 * width + x0;
    const double fx = x - static_cast<double>(x0), fy = y - static_cast<double>(y0);
    const double value = (v[0] * (1 - fx) + v[right] * fx) * (1 - fy) +
                         (v[below] * (1 - fx) + v[below + right] * fx) * fy;
    // Beside a pixel without a value, for example at the border of an oblique slice.
    return std::isnan(value) ? v[(fx < 0.5 ? 0 : right) + (fy < 0.5 ? 0 : below)] : value;
}

std::uint32_t gray_of(double value, const GrayWindow& window) {
    const double share = (value - window.level) / window.width + 0.5;
    if (!(share > 0)) {
        return opaque_black;  // Also what is no number.
    }
    const auto gray = static_cast<std::uint32_t>(std::lround(std::min(share, 1.0) * 255));
    return opaque_black | gray << 16 | gray << 8 | gray;
}

/// The title in lines that fit into the picture.
std::vector<std::string> title_lines(const std::string& title, double room_px) {
    std::vector<std::string> lines;
    std::istringstream words(title);
    for (std::string word; words >> word;) {
        if (lines.empty() || text_width(lines.back() + " " + word, title_px) > room_px) {
            lines.push_back(word);
        } else {
            lines.back() += " " + word;
        }
    }
    return lines;
}

void add_letters(const SliceFrame& frame, const Picture& picture, const Caption& caption,
                 std::vector<PictureMark>& marks) {
    const auto width = static_cast<float>(picture.width);
    const auto height = static_cast<float>(picture.height);
    const auto add = [&](glm::vec2 at, const std::string& text, float x, float y, float size) {
        if (!text.empty()) {
            marks.push_back(text_mark(at, text, ink, {size, x, y, halo_px}));
        }
    };
    add({margin_px, height / 2}, frame.across.begin, 0, 0.5F, letter_px);
    add({width - margin_px, height / 2}, frame.across.end, 1, 0.5F, letter_px);
    add({width / 2, margin_px}, frame.down.begin, 0.5F, 0, letter_px);
    const std::vector<std::string> lines = title_lines(caption.title, width - 2 * margin_px);
    float bottom = height - margin_px / 2;
    for (std::size_t line = lines.size(); line-- > 0; bottom -= title_px * line_step) {
        add({margin_px, bottom}, lines[line], 0, 1, title_px);
    }
    const float more =
        title_px * line_step * static_cast<float>(std::max<std::size_t>(lines.size(), 1) - 1);
    add({width / 2, height - margin_px - title_px - more}, frame.down.end, 0.5F, 1, letter_px);
    // Left of the letter at the top, or, where that is too narrow, below the letter.
    const bool is_narrow = picture.width < smallest_legend_px;
    const float room = is_narrow ? width - 2 * margin_px : width / 2 - 2 * margin_px - letter_px;
    const float top = margin_px + (is_narrow ? letter_px * 1.2F : 0);
    for (PictureMark& mark :
         warning_marks(caption.warning, {{margin_px, top}, room, title_px, halo_px, false})) {
        marks.push_back(std::move(mark));
    }
}

bool has_contours(const Surface& surface) {
    return surface.visible && surface.compared_with.empty();
}

}  // namespace

std::vector<SurfaceContour> contours_of(const Scene& scene, const Slice& slice) {
    const std::vector<double> numbers = numbers_of(slice);
    std::vector<SurfaceContour> contours;
    for (const Surface& surface : scene.surfaces) {
        if (has_contours(surface)) {
            contours.push_back({&surface, slice_contour(slice.frame, numbers, surface.isovalue,
                                                        saddle_rule(surface.table))});
        }
    }
    return contours;
}

std::vector<SurfaceContour> contours_of(const Scene& scene, const ObliquePlane& plane,
                                        const std::vector<float>& values) {
    std::vector<SurfaceContour> contours;
    for (const Surface& surface : scene.surfaces) {
        if (has_contours(surface)) {
            contours.push_back({&surface, oblique_contour(plane, values, surface.isovalue)});
        }
    }
    return contours;
}

std::vector<std::string> hidden_in_3d(const Scene& scene,
                                      const std::vector<SurfaceContour>& contours) {
    std::vector<std::string> settings;
    if (std::ranges::all_of(contours, [](const auto& each) { return each.pieces.empty(); })) {
        return settings;
    }
    for (const SceneClip& clip : scene.clips) {
        // The six planes of a box are one setting.
        if (std::string words = "clip " + clip.words; std::ranges::count(settings, words) == 0) {
            settings.push_back(std::move(words));
        }
    }
    for (const SurfaceContour& contour : contours) {
        const Surface& surface = *contour.surface;
        if (!contour.pieces.empty() && surface.components.kind != ComponentFilter::Kind::all) {
            settings.push_back("components of " + surface.name);
        }
    }
    return settings;
}

SlicePicture slice_picture(const Slice& slice, const std::vector<SurfaceContour>& contours,
                           const GrayWindow& window, Size size, const Caption& caption) {
    const SliceSide &across = slice.frame.across, &down = slice.frame.down;
    const Scale scale = scale_of(slice.frame, size);
    SlicePicture out{{scale.length_px(across), scale.length_px(down), {}}, {}};
    std::vector<std::uint32_t> pixels;
    const std::vector<double> numbers = numbers_of(slice);
    for (int y = 0; y < out.picture.height; ++y) {
        const double row = scale.number_at(down, y + 0.5);
        for (int x = 0; x < out.picture.width; ++x) {
            const double column = scale.number_at(across, x + 0.5);
            pixels.push_back(gray_of(value_at(slice.frame, numbers, column, row), window));
        }
    }
    out.picture.rgba = std::move(pixels);
    std::size_t count = 0;
    for (const SurfaceContour& contour : contours) {
        count += contour.pieces.size();
        if (count > max_contour_marks) {
            throw RequestError(ExitCode::failed,
                               fmt::format("the contours have {} pieces up to surface {}, {} are "
                                           "the most that are drawn: hide surfaces that are noise",
                                           count, contour.surface->name, max_contour_marks));
        }
        const auto at = [&](glm::vec2 p) {
            return glm::vec2(scale.at_px(across, p.x), scale.at_px(down, p.y));
        };
        const Color& c = contour.surface->color;
        for (const ContourPiece& piece : contour.pieces) {
            out.marks.push_back(
                line_mark({at(piece.from), at(piece.to)}, {c.r, c.g, c.b, 255}, contour_px));
        }
    }
    add_letters(slice.frame, out.picture, caption, out.marks);
    return out;
}

}  // namespace pxpl5::host
