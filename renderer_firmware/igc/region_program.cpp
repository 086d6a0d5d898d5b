#include "renderer_firmware/igc/region_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "isa/assemble.hpp"
#include "isa/executor.hpp"
#include "isa/region_layout.hpp"
#include "isa/screen_door.hpp"

namespace pxpl5::renderer {
namespace {

#include "program_texts.inc"

// Places that registers.pxasm names and that this file computes with.
constexpr std::uint32_t place_x = 64, place_y = 80, place_z = 96;
constexpr std::uint32_t place_t = 128, place_fraction = place_t + 29, place_base = 192;
constexpr std::uint32_t fraction_bits = 16;

constexpr double light_one = 16384;      ///< 1.0 of `light`.
constexpr double light_half_step = 16;   ///< finish.pxasm drops 5 bits of it.
constexpr double diffuse_one = 8192;     ///< 1.0 of a lamp in its dot product.
constexpr double dot_one = 32768;        ///< Unit length in a highlight's dot product.
constexpr double fraction_one = 65536;   ///< 1.0 of `fraction`.
constexpr double gloss_weight_one = 16;  ///< Weight per step of colour; see gloss.pxasm.
constexpr double dimmest_step = 0.125;   ///< A highlight below this part of a step is dropped.

/// What truncation takes from a cosine near 1, on average and over the whole power: half a bit each
/// for the fraction and the products, one for the inverse.
constexpr double mean_loss = 2 / fraction_one;

/// The fields of region_layout.hpp as names for the assembler.
std::string layout_names() {
    using namespace isa::region;
    namespace door = isa::door;
    return fmt::format(
        ".def surface {}\n.def z {}\n.def normal_x {}\n.def normal_y {}\n.def normal_z {}\n.def "
        "rgb "
        "{}\n.def kept_z {}\n.def rank {}\n.def shut {}\n",
        surface.address, z.address, normal_x.address, normal_y.address, normal_z.address,
        rgb.address, door::kept_z.address, door::rank.address, door::shut);
}

isa::Program assembled(std::string_view source, const std::string& names = {}) {
    return isa::assemble(fmt::format("{}{}{}{}", layout_names(), text::registers, names, source));
}

/// A text that works on a place given as .def, assembled for every place that is used.
class Placed {
  public:
    Placed(std::string_view name, std::string_view source, std::span<const std::uint32_t> places) {
        for (const std::uint32_t place : places) {
            programs_[place] = assembled(source, fmt::format(".def {} {}\n", name, place));
        }
    }
    const isa::Program& at(std::uint32_t place) const {
        assert(programs_[place]);
        return *programs_[place];
    }

  private:
    std::array<std::optional<isa::Program>, isa::memory_bits> programs_;
};

constexpr std::array places_n = {place_x, place_y, place_z};

/// Where the power so far may lie: at the fraction or moved down, 16 bits on with each product.
/// From the first 3 a product ends below the base, from the first 6 it ends within the memory.
constexpr std::array<std::uint32_t, 8> places_q = {128, 144, 160, 157, 173, 176, 189, 192};

/// Every text, assembled.
struct Texts {
    isa::Program prologue = assembled(text::prologue), cover = assembled(text::cover),
                 normal = assembled(text::normal), ambient = assembled(text::ambient),
                 unlit = assembled(text::unlit), scale = assembled(text::scale),
                 diffuse = assembled(text::diffuse), visible = assembled(text::visible),
                 keep_base = assembled(text::keep_base),
                 colour_first = assembled(text::colour_first),
                 colour_next = assembled(text::colour_next),
                 enable_covered = assembled(text::enable_covered), finish = assembled(text::finish),
                 readout = assembled(text::readout), rank_bayer = assembled(text::rank_bayer),
                 rank_lines = assembled(text::rank_lines), shut_door = assembled(text::shut_door),
                 open_door = assembled(text::open_door), depths = assembled(text::depths);
    Placed dot_first{"N", text::dot_first, places_n}, dot_next{"N", text::dot_next, places_n};
    Placed move_down{"Q", text::move_down, places_q};
    Placed square{"Q", text::square, std::span(places_q).first(6)};
    Placed times_base{"Q", text::times_base, std::span(places_q).first(3)};
    Placed gloss{"Q", text::gloss, places_q};
};

const Texts& texts() {
    static const Texts assembled_once;
    return assembled_once;
}

struct Vector {
    double x, y, z;
};

std::optional<Vector> normalised(Vector v) {
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    if (!(length > 1e-6) || !std::isfinite(length)) {
        return std::nullopt;
    }
    return Vector{v.x / length, v.y / length, v.z / length};
}

std::int64_t packed(Rgb c) {
    return c.r | c.g << 8 | c.b << 16;
}

/// 4 (value) of each, 11 bits apart; see colour_first.pxasm.
std::int64_t spread(Rgb c) {
    const auto part = [](std::uint8_t value) { return std::int64_t{value} * 4; };
    return part(c.r) | part(c.g) << 11 | part(c.b) << 22;
}

/// Writes the end-of-region program of one shading, text after text.
class Writer {
  public:
    explicit Writer(const Shading& shading) : shading_(shading) {}

    std::vector<std::uint32_t> end_of_region() {
        add(texts().cover, {{"readout", 0}});
        const std::size_t skip = words_.size() - 1;
        light();
        colours();
        add(texts().finish);
        words_[skip] = static_cast<std::uint32_t>(words_.size());
        add(texts().readout);
        return std::move(words_);
    }

  private:
    void add(const isa::Program& program, const isa::Parameters& values = {}) {
        const std::vector<std::uint32_t> bound = program.bind(values);
        words_.insert(words_.end(), bound.begin(), bound.end());
    }

    void light() {
        add(texts().ambient,
            {{"ambient", std::lround(shading_.ambient * light_one + light_half_step)}});
        const bool any =
            std::ranges::any_of(shading_.lights, [](const Light& l) { return l.intensity > 0; });
        add(any ? texts().normal : texts().unlit);
        for (const Light& lamp : shading_.lights) {
            if (lamp.intensity > 0) {
                this->lamp(lamp);
            }
        }
    }

    void lamp(const Light& lamp) {
        const Light::Direction& d = lamp.direction;
        const Vector l = *normalised({d.x, d.y, d.z});
        if (dot(l, diffuse_one * lamp.intensity)) {
            add(texts().scale);
            add(texts().diffuse);
        }
        // A lamp straight behind has no half vector, and lights nothing that is seen.
        const std::optional<Vector> half = normalised({l.x, l.y, l.z + 1});
        if (half && shading_.specular > 0) {
            highlight(*half, double{lamp.intensity} * shading_.specular);
        }
    }

    /// T = normal . (scale * v), in 32 bits; false if that is 0 for every normal.
    bool dot(Vector v, double scale) {
        const std::int64_t k[] = {std::lround(v.x * scale), std::lround(v.y * scale),
                                  std::lround(v.z * scale)};
        bool first = true;
        for (std::size_t i = 0; i < 3; ++i) {
            if (k[i] != 0) {
                add((first ? texts().dot_first : texts().dot_next).at(places_n[i]), {{"k", k[i]}});
                first = false;
            }
        }
        return !first;
    }

    /// The half vector is shortened by the power-th root of 2: no product runs over, the power is
    /// below one half, as gloss.pxasm needs it, and the weight makes up for it.
    void highlight(Vector half, double weight) {
        const double power = shading_.specular_power;
        const double shortened = std::pow(0.5, 1 / power) * (1 - 1 / fraction_one);
        const double steps = 255 * weight;
        const double weight_word =
            steps * gloss_weight_one / std::pow(shortened - mean_loss, power);
        const double least = std::pow(std::min(1.0, dimmest_step / steps), 1 / power) * shortened;
        dot(half, dot_one * shortened);
        add(texts().scale);
        add(texts().visible, {{"least", std::lround(least * fraction_one)}});
        const std::uint32_t place = raise(shading_.specular_power);
        add(texts().gloss.at(place), {{"weight", std::lround(weight_word)}});
    }

    /// Raises the fraction to `power`, from the power's top bit down: square, and multiply where
    /// a bit is set. Returns the place of the result.
    std::uint32_t raise(std::uint32_t power) {
        const bool needs_base = (power & (power - 1)) != 0;
        if (needs_base) {
            add(texts().keep_base);
        }
        const std::uint32_t room_end = needs_base ? place_base : isa::memory_bits;
        std::uint32_t at = place_fraction;
        const auto step = [&](const Placed& product) {
            if (at + 2 * fraction_bits > room_end) {
                add(texts().move_down.at(at));
                at = place_t;
            }
            add(product.at(at));
            at += fraction_bits;
        };
        std::uint32_t bit = std::bit_floor(power);
        while ((bit >>= 1U) != 0) {
            step(texts().square);
            if ((power & bit) != 0) {
                step(texts().times_base);
            }
        }
        return at;
    }

    void colours() {
        const std::vector<Rgb>& surfaces = shading_.surfaces;
        add(texts().colour_first, {{"colour", spread(surfaces.empty() ? Rgb{} : surfaces[0])}});
        for (std::size_t i = 1; i < surfaces.size(); ++i) {
            add(texts().colour_next, {{"surface_number", static_cast<std::int64_t>(i + 1)},
                                      {"colour", spread(surfaces[i])}});
        }
        if (surfaces.size() > 1) {
            add(texts().enable_covered);
        }
    }

    const Shading& shading_;
    std::vector<std::uint32_t> words_;
};

void require(bool holds, const std::string& what) {
    if (!holds) {
        throw std::invalid_argument("shading: " + what);
    }
}

void verify(const Shading& s) {
    require(s.lights.size() <= max_lights,
            fmt::format("{} lights; at most {}", s.lights.size(), max_lights));
    require(s.surfaces.size() <= max_surfaces,
            fmt::format("{} surfaces; at most {}", s.surfaces.size(), max_surfaces));
    require(s.screens.size() <= s.surfaces.size(),
            fmt::format("{} screens of {} surfaces", s.screens.size(), s.surfaces.size()));
    for (const Screen& screen : s.screens) {
        require(screen.opacity >= 1 && screen.opacity <= isa::door::levels,
                fmt::format("opacity {}; must be 1..{}", screen.opacity, isa::door::levels));
    }
    require(s.specular_power >= 1 && s.specular_power <= max_specular_power,
            fmt::format("specular power {}; must be 1..{}", s.specular_power, max_specular_power));
    require(s.specular >= 0 && s.specular <= 1,
            fmt::format("specular {}; must be 0..1", s.specular));
    require(s.ambient >= 0, fmt::format("ambient {}; must not be negative", s.ambient));
    double sum = s.ambient;
    for (const Light& light : s.lights) {
        const Light::Direction& d = light.direction;
        require(light.intensity >= 0,
                fmt::format("a light of intensity {}; must not be negative", light.intensity));
        require(normalised({d.x, d.y, d.z}).has_value(),
                fmt::format("a light's direction ({}, {}, {}) has no length", d.x, d.y, d.z));
        sum += light.intensity;
    }
    require(sum <= max_light_sum,
            fmt::format("ambient and intensities sum up to {}; at most {}", sum, max_light_sum));
}

/// u or v of a screen's rank: a form of the pixel's place.
struct PlaceForm {
    std::int64_t x, y, one;
};

/// Bayer's pattern; rows; columns, moved so that rows and columns together do not hide all that
/// Bayer's leaves. Then they come again, moved by a pixel. What any two of these leave at 8/16 is
/// the lattice of every other pixel of every other row: of all patterns of 4 x 4 pixels that leave
/// a chessboard half, rows and columns alone make no stripes of it.
std::vector<std::uint32_t> shut(const Screen& screen) {
    constexpr std::uint32_t kinds = 3;
    constexpr PlaceForm u[kinds] = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    constexpr PlaceForm v[kinds] = {{0, 1, 0}, {0, 1, 0}, {1, 0, 1}};
    const std::uint32_t kind = screen.pattern % kinds, moved = screen.pattern / kinds;
    const isa::Program& rank = kind == 0 ? texts().rank_bayer : texts().rank_lines;
    std::vector<std::uint32_t> words = rank.bind({{"u_x", u[kind].x},
                                                  {"u_y", u[kind].y},
                                                  {"u_1", u[kind].one + (moved & 1)},
                                                  {"v_x", v[kind].x},
                                                  {"v_y", v[kind].y},
                                                  {"v_1", v[kind].one + (moved >> 1 & 1)}});
    const std::vector<std::uint32_t> rest = texts().shut_door.bind({{"opacity", screen.opacity}});
    words.insert(words.end(), rest.begin(), rest.end());
    return words;
}

}  // namespace

std::vector<std::uint32_t> prologue(const Shading& shading) {
    verify(shading);
    return texts().prologue.bind({{"background", packed(shading.background)}});
}

std::vector<std::uint32_t> end_of_region(const Shading& shading) {
    verify(shading);
    return Writer(shading).end_of_region();
}

std::vector<DoorPrograms> doors(const Shading& shading) {
    verify(shading);
    std::vector<DoorPrograms> all;
    for (std::uint32_t s = 0; s < shading.screens.size(); ++s) {
        if (shading.screens[s].opacity < isa::door::levels) {
            all.push_back({s, shut(shading.screens[s]),
                           texts().open_door.bind({{"background", packed(shading.background)}})});
        }
    }
    return all;
}

std::vector<std::uint32_t> depths() {
    return texts().depths.bind({});
}

RegionPrograms region_programs(const Shading& shading, bool wants_depths) {
    return {prologue(shading), end_of_region(shading), doors(shading),
            wants_depths ? depths() : std::vector<std::uint32_t>()};
}

}  // namespace pxpl5::renderer
