#include "renderer_firmware/igc/region_program.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include "isa/contract/sample_sums.hpp"
#include "isa/contract/screen_door.hpp"
#include "isa/program.hpp"
#include "renderer_firmware/igc/shading_facts.hpp"
#include "renderer_firmware/igc/tone_curve.hpp"
#include "renderer_firmware/programs/texts.hpp"

namespace pxpl5::renderer {
namespace {

constexpr double diffuse_one = 8192;     ///< 1.0 of a light in its dot product.
constexpr double dot_one = 32768;        ///< Unit length in the dot product of a highlight.
constexpr double cosine_one = 65536;     ///< 1.0 in `cosine`.
constexpr double gloss_weight_one = 16;  ///< Weight per step of color; see gloss.pxasm.
constexpr double dimmest_step = 0.125;   ///< Highlights below this fraction of a step are dropped.

/// The average loss by truncation of a cosine near 1, over the whole power: half a bit each for the
/// cosine and the products, one bit for the inverse.
constexpr double mean_loss = 2 / cosine_one;

/// Returns the words of a text with its coefficients. Throws like isa::Program::bind().
template <std::size_t words, std::size_t open>
std::vector<std::uint32_t> bound(const programs::Text<words, open>& text,
                                 const isa::Parameters& values = {}) {
    isa::Program program;
    // Not by assign(), of which g++ 12 warns without a reason.
    program.words = std::vector<std::uint32_t>(text.words.begin(), text.words.end());
    for (const programs::Open& coefficient : text.open) {
        program.patches.push_back({std::string(coefficient.name), coefficient.word});
    }
    return program.bind(values);
}

std::int64_t packed(Rgb c) {
    return c.r | c.g << 8 | c.b << 16;
}

/// 11 bits apart; see color_first.pxasm.
std::int64_t spread(Rgb c) {
    return c.r | c.g << 11 | c.b << 22;
}

/// Writes the end-of-region program of one shading, text by text.
class Writer {
  public:
    explicit Writer(const Shading& shading) : shading_(shading) {}

    std::vector<std::uint32_t> end_of_region() {
        add(programs::cover);
        add(programs::skip_empty, {{"readout", 0}});
        const std::size_t skip = words_.size() - 1;
        light();
        const bool limited = limit_light();
        if (rims() || limited) {
            add(programs::enable_covered);
        }
        colors();
        add(programs::finish);
        grays();
        words_[skip] = static_cast<std::uint32_t>(words_.size());
        if (shading_.pass.samples > 1) {
            shading_.pass.samples == few_samples ? sum_4() : sum_16();
        }
        if (shading_.pass.is_last()) {
            add(programs::readout);
        }
        return std::move(words_);
    }

  private:
    template <typename Text>
    void add(const Text& text, const isa::Parameters& values = {}) {
        const std::vector<std::uint32_t> more = bound(text, values);
        words_.insert(words_.end(), more.begin(), more.end());
    }

    void sum_4() {
        sum(programs::sum_fetch_4, programs::sum_spread_4, programs::sum_add_4,
            programs::sum_keep_4, programs::sum_mean_4);
    }
    void sum_16() {
        sum(programs::sum_fetch_16, programs::sum_spread_16, programs::sum_add_16,
            programs::sum_keep_16, programs::sum_mean_16);
    }
    void sum(const auto& fetch, const auto& spread, const auto& add_up, const auto& keep,
             const auto& mean) {
        const bool is_first = shading_.pass.sample == 0;
        if (!is_first) {
            add(fetch);
        }
        add(spread);
        if (!is_first) {
            add(add_up);
        }
        shading_.pass.is_last() ? add(mean) : add(keep);
    }

    void light() {
        add(programs::ambient, {{"ambient", std::lround(shading_.ambient * light_field::one +
                                                        light_field::half_step)}});
        const bool any =
            std::ranges::any_of(shading_.lights, [](const Light& l) { return l.intensity > 0; });
        if (any || has_rims()) {
            add(programs::normal);
            add(programs::length);
            add(programs::inverse);
        } else {
            add(programs::unlit);
            if (shading_.planes > 0) {
                add(programs::normal);
            }
        }
        for (const Light& lamp : shading_.lights) {
            if (lamp.intensity > 0) {
                this->lamp(lamp);
            }
        }
        if (has_rims()) {
            view();
        }
    }

    bool has_rims() const {
        return std::ranges::any_of(shading_.rims, [](float rim) { return rim > 0; });
    }

    /// The cosine between normal and view. 1.0 does not fit the constant, which is signed.
    void view() {
        dot({0, 0, 1}, dot_one - 1);
        add(programs::scale);
        add(programs::rim_view);
    }

    void lamp(const Light& lamp) {
        const Light::Direction& d = lamp.direction;
        const Vector l = *normalized({d.x, d.y, d.z});
        if (dot(l, diffuse_one * lamp.intensity)) {
            add(programs::scale);
            add(programs::diffuse);
        }
        // A light exactly behind has no half vector, and lights no visible pixel.
        const std::optional<Vector> half = normalized({l.x, l.y, l.z + 1});
        if (half && shading_.specular > 0) {
            highlight(*half, double{lamp.intensity} * shading_.specular);
        }
    }

    /// Writes T = normal . (scale * v), in 32 bits. Returns false if T is 0 for every normal.
    bool dot(Vector v, double scale) {
        const std::int64_t x = std::lround(v.x * scale), y = std::lround(v.y * scale),
                           z = std::lround(v.z * scale);
        if (x != 0) {
            add(programs::dot_first_x, {{"k", x}});
        }
        if (y != 0) {
            x == 0 ? add(programs::dot_first_y, {{"k", y}}) : add(programs::dot_next_y, {{"k", y}});
        }
        if (z != 0) {
            x == 0 && y == 0 ? add(programs::dot_first_z, {{"k", z}})
                             : add(programs::dot_next_z, {{"k", z}});
        }
        return x != 0 || y != 0 || z != 0;
    }

    /// Divides the half vector by the power-th root of 2. Then no product overflows, and the power
    /// is below one half, which gloss.pxasm requires. The weight compensates.
    void highlight(Vector half, double weight) {
        const double power = shading_.specular_power;
        const double shortened = std::pow(0.5, 1 / power) * (1 - 1 / cosine_one);
        const double steps = 255 * weight;
        const double weight_word =
            steps * gloss_weight_one / std::pow(shortened - mean_loss, power);
        const double least = std::pow(std::min(1.0, dimmest_step / steps), 1 / power) * shortened;
        dot(half, dot_one * shortened);
        add(programs::scale);
        add(programs::visible, {{"least", std::lround(least * cosine_one)}});
        raise(shading_.specular_power);
        add(programs::gloss, {{"weight", std::lround(weight_word)}});
    }

    /// Raises the cosine to `power`, from the top bit of the power down: squares, and multiplies
    /// where a bit is set.
    void raise(std::uint32_t power) {
        if (!std::has_single_bit(power)) {
            add(programs::keep_base);
        }
        std::uint32_t bit = std::bit_floor(power);
        while ((bit >>= 1U) != 0) {
            add(programs::square);
            if ((power & bit) != 0) {
                add(programs::times_base);
            }
        }
    }

    void colors() {
        const std::vector<Rgb>& surfaces = shading_.surfaces;
        add(programs::color_first, {{"color", spread(surfaces.empty() ? Rgb{} : surfaces[0])}});
        const std::size_t lit = surfaces.size() - shading_.planes;
        for (std::size_t i = 1; i < lit; ++i) {
            add(programs::color_next, {{"surface_number", static_cast<std::int64_t>(i + 1)},
                                       {"color", spread(surfaces[i])}});
        }
        if (lit > 1) {
            add(programs::enable_covered);
        }
    }

    void grays() {
        const std::size_t count = shading_.surfaces.size();
        for (std::size_t i = count - shading_.planes; i < count; ++i) {
            add(programs::gray, {{"surface_number", static_cast<std::int64_t>(i + 1)}});
        }
        if (shading_.planes > 0) {
            add(programs::enable_covered);
        }
    }

    /// Bends the light of the surfaces that the lights could overexpose. Returns whether any is.
    bool limit_light() {
        const double brightest = brightest_light(shading_);
        bool limited = false;
        for (std::size_t i = 0; i + shading_.planes < shading_.surfaces.size(); ++i) {
            if (const auto curve = tone_curve(brightest, brightest_channel(i))) {
                bend_light(static_cast<std::int64_t>(i + 1), *curve);
                limited = true;
            }
        }
        return limited;
    }

    int brightest_channel(std::size_t surface) const {
        const Rgb color = shading_.surfaces[surface];
        return std::max({color.r, color.g, color.b});
    }

    void bend_light(std::int64_t surface, const ToneCurve& curve) {
        if (curve.cut) {
            add(programs::limit_light, {{"surface_number", surface}, {"limit", *curve.cut}});
        }
        add(programs::bend_light, {{"surface_number", surface},
                                   {"knee", curve.knee},
                                   {"minus_knee", -curve.knee},
                                   {"bend", curve.bend}});
        add(programs::limit_light, {{"surface_number", surface}, {"limit", curve.limit}});
    }

    /// Adds light at the edges of the surfaces that have a rim. Returns whether any has.
    bool rims() {
        const double brightest = brightest_light(shading_);
        for (std::size_t i = 0; i < shading_.rims.size(); ++i) {
            const double light = 2.0 * shading_.rims[i];
            const auto surface = static_cast<std::int64_t>(i + 1);
            if (light == 0) {
                continue;
            }
            add(programs::rim, {{"surface_number", surface},
                                {"rim_light", std::lround(light * light_field::one)}});
            const int channel = brightest_channel(i);
            if (light_field::is_above_limit(brightest + light, channel)) {
                add(programs::limit_light,
                    {{"surface_number", surface}, {"limit", light_field::limit(channel)}});
            }
        }
        return has_rims();
    }

    const Shading& shading_;
    std::vector<std::uint32_t> words_;
};

/// u or v of a screen's rank: a linear form in x and y.
struct PlaceForm {
    std::int64_t x, y, one;
};

/// The patterns are: Bayer's; rows; columns, moved so that rows and columns together leave some of
/// the pixels that Bayer's pattern leaves. Further patterns are these, moved by a pixel. Any two of
/// the three at 8/16 leave every other pixel of every other row. Among all patterns of 4 x 4 pixels
/// that leave half of a checkerboard, only rows and columns leave it without stripes.
///
/// Each pass moves all patterns together, as if the picture were elsewhere: 4 passes over 2 x 2
/// pixels, 16 passes over 4 x 4. So the mean of the passes shows no pattern, and each pixel shows
/// through two surfaces what otherwise 4 x 4 pixels show together.
std::vector<std::uint32_t> shut(const Screen& screen, std::uint32_t sample) {
    const std::int64_t dx = (sample & 1) + (sample >> 2 & 1) * 2;
    const std::int64_t dy = (sample >> 1 & 1) + (sample >> 3 & 1) * 2;
    constexpr std::uint32_t kinds = 3;
    constexpr PlaceForm u[kinds] = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    constexpr PlaceForm v[kinds] = {{0, 1, 0}, {0, 1, 0}, {1, 0, 1}};
    const std::uint32_t kind = screen.pattern % kinds, moved = screen.pattern / kinds;
    const auto at_origin = [&](const PlaceForm& form, std::uint32_t moved_by) {
        return form.one + moved_by + form.x * dx + form.y * dy;
    };
    const isa::Parameters forms = {
        {"u_x", u[kind].x}, {"u_y", u[kind].y}, {"u_1", at_origin(u[kind], moved & 1)},
        {"v_x", v[kind].x}, {"v_y", v[kind].y}, {"v_1", at_origin(v[kind], moved >> 1 & 1)}};
    std::vector<std::uint32_t> words =
        kind == 0 ? bound(programs::rank_bayer, forms) : bound(programs::rank_lines, forms);
    const std::vector<std::uint32_t> rest =
        bound(programs::shut_door, {{"opacity", screen.opacity}});
    words.insert(words.end(), rest.begin(), rest.end());
    return words;
}

}  // namespace

std::vector<std::uint32_t> prologue(const Shading& shading) {
    verify(shading);
    return bound(programs::prologue, {{"background", packed(shading.background)}});
}

std::vector<std::uint32_t> end_of_region(const Shading& shading) {
    verify(shading);
    return Writer(shading).end_of_region();
}

std::vector<std::uint32_t> at_slot(std::vector<std::uint32_t> end_of_region, std::uint32_t samples,
                                   std::size_t slot) {
    assert(slot < isa::max_summed_regions(samples));
    const auto first_block = static_cast<std::uint32_t>(slot) * isa::sum_blocks(samples);
    for (std::size_t at = 0; at < end_of_region.size();) {
        isa::Instruction in = *isa::decode(end_of_region[at]);
        const std::size_t next = at + isa::instruction_words(end_of_region[at]);
        if (in.op == isa::Op::bs_read || in.op == isa::Op::bs_write) {
            in.operands.b += first_block;
            end_of_region[at] = isa::encode(in);
        }
        at = next;
    }
    return end_of_region;
}

std::vector<DoorPrograms> doors(const Shading& shading) {
    verify(shading);
    std::vector<DoorPrograms> all;
    for (std::uint32_t s = 0; s < shading.screens.size(); ++s) {
        if (shading.screens[s].opacity < full_opacity) {
            all.push_back(
                {s, shut(shading.screens[s], shading.pass.sample),
                 bound(programs::open_door, {{"background", packed(shading.background)}})});
        }
    }
    return all;
}

std::vector<std::uint32_t> depths() {
    return bound(programs::depths);
}

RegionPrograms region_programs(const Shading& shading, bool wants_depths) {
    return {prologue(shading), end_of_region(shading), doors(shading),
            wants_depths ? depths() : std::vector<std::uint32_t>()};
}

}  // namespace pxpl5::renderer
