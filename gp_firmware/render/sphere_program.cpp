#include "gp_firmware/render/sphere_program.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "isa/contract/region_layout.hpp"
#include "isa/contract/screen_door.hpp"
#include "isa/instruction.hpp"

namespace pxpl5::gp {

namespace {

namespace region = isa::region;
using isa::Op;

// Scratch: the form, then a product.
constexpr std::uint32_t low_bits = 16, form_bits = 64;
constexpr std::uint32_t at_form = region::scratch, at_product = at_form + form_bits;
constexpr std::uint32_t depth_factor_bits = 25, normal_factor_bits = 17;
static_assert(at_product + 2 * depth_factor_bits <= isa::door::begin);

/// Coefficients of the form stay below 2^coefficient_bits, so that the form stays below 2^63.
constexpr int coefficient_bits = 46;
/// A larger value would let S leave the form's field.
constexpr int max_exponent = 60;

// Fraction bits of the planes of TREE and of a normal's factor.
constexpr std::uint32_t depth_fraction = 8, normal_fraction = 14, factor_fraction = 6;

class Writer {
  public:
    void put(Op op, isa::Operands operands = {}) { words_[count_++] = isa::encode({op, operands}); }
    void put(std::int64_t coefficient) {
        words_[count_++] = static_cast<std::uint32_t>(coefficient);
    }
    void put_word(std::uint32_t word) { words_[count_++] = word; }
    const std::array<std::uint32_t, sphere_word_count>& words() const {
        assert(count_ == words_.size());
        return words_;
    }

  private:
    std::array<std::uint32_t, sphere_word_count> words_{};
    std::size_t count_ = 0;
};

/// Returns the form over the region's own pixels, scaled to integers: A B C D E F.
struct RegionForm {
    std::array<std::int64_t, 6> coefficients{};
    int exponent = 0;
};

RegionForm region_form(const std::array<double, 6>& f, double u, double v) {
    const std::array<double, 6> here = {f[1] + 2 * f[3] * u + f[4] * v,
                                        f[2] + 2 * f[5] * v + f[4] * u,
                                        form_at(f, u, v),
                                        f[3],
                                        f[4],
                                        f[5]};
    double largest = 0;
    for (const double value : here) {
        largest = std::max(largest, std::abs(value));
    }
    RegionForm form;
    form.exponent = std::min(coefficient_bits - (std::ilogb(largest) + 1), max_exponent);
    // Slightly less than 2^e, so that the form's peak stays below 2^e.
    const double scale = std::ldexp(1 - 0x1p-20, form.exponent);
    for (std::size_t k = 0; k < here.size(); ++k) {
        form.coefficients[k] = std::llround(here[k] * scale);
    }
    return form;
}

/// Enables the pixels of the box in the region. Values are -127..127.
void put_box(Writer& out, const PixelBox& box, int x0, int y0) {
    constexpr int last = region_px - 1;
    constexpr std::uint32_t sign_bits = 8;
    const auto side = [&out](int a, int b, int c) {
        out.put(Op::tree_ge_zero, {0, 0, sign_bits});
        out.put(a);
        out.put(b);
        out.put(c);
    };
    side(1, 0, -std::max(box.x0 - x0, 0));
    side(-1, 0, std::min(box.x1 - x0, last));
    side(0, 1, -std::max(box.y0 - y0, 0));
    side(0, -1, std::min(box.y1 - y0, last));
}

void put_form(Writer& out, const RegionForm& form) {
    constexpr std::int64_t low_mask = (std::int64_t{1} << low_bits) - 1;
    out.put(Op::quad_into_mem, {at_form + low_bits, 0, form_bits - low_bits});
    for (const std::int64_t c : form.coefficients) {
        out.put(c >> low_bits);
    }
    out.put(Op::clear_mem, {at_form, 0, low_bits});
    out.put(Op::mem_plus_quad, {at_form, 0, form_bits});
    for (const std::int64_t c : form.coefficients) {
        out.put(c & low_mask);
    }
    out.put(Op::enab_and_not_mem, {at_form + form_bits - 1, 0, 0});
}

/// A product of S and its plane.
struct Term {
    ScreenPlane plane;
    double root = 0;
    std::uint32_t factor_bits, factor_fraction, plane_fraction, plane_bits;
};

/// m[at_product]: plane - root S, with j + factor_fraction bits of fraction.
void put_term(Writer& out, const Term& term, double u, double v, std::uint32_t at_root, int j) {
    const auto shift = static_cast<std::uint32_t>(j) + term.factor_fraction - term.plane_fraction;
    out.put(Op::mul_const, {at_product, at_root, term.factor_bits});
    out.put(-std::llround(std::ldexp(term.root, static_cast<int>(term.factor_fraction))));
    out.put(Op::mem_plus_tree, {at_product + shift, 0, term.plane_bits});
    const auto scaled = [&term](double value) {
        return std::llround(std::ldexp(value, static_cast<int>(term.plane_fraction)));
    };
    // Instructions truncate: the result by 0.5 on average, S by half of its last bit.
    const double rounding = 0.5 - std::ldexp(term.root, -j - 1);
    out.put(scaled(term.plane.a));
    out.put(scaled(term.plane.b));
    out.put(scaled(term.plane.c + term.plane.a * u + term.plane.b * v + rounding));
}

}  // namespace

std::optional<std::array<std::uint32_t, sphere_word_count>> sphere_program(
    const ScreenSphere& sphere, int x0, int y0, std::uint32_t surface_word) {
    const double u = x0 + 0.5 - sphere.x_px, v = y0 + 0.5 - sphere.y_px;
    const RegionForm form = region_form(sphere.form, u, v);
    const int j = std::min(max_root_bits, form.exponent / 2);
    if (j < static_cast<int>(depth_fraction)) {
        return std::nullopt;
    }
    const auto root_bits = static_cast<std::uint32_t>(j);
    const std::uint32_t at_root =
        at_form + static_cast<std::uint32_t>(form.exponent) - 2 * root_bits;

    Writer out;
    out.put(Op::set_enabs);
    put_box(out, sphere.box, x0, y0);
    put_form(out, form);
    out.put(Op::sqrt_mem, {at_root, 0, 2 * root_bits});
    put_term(out,
             {sphere.depth_plane, sphere.depth_root, depth_factor_bits, 0, depth_fraction,
              region::z.width + depth_fraction},
             u, v, at_root, j);
    out.put(Op::mem_lt_mem, {at_product + root_bits, region::z.address, region::z.width});
    out.put(Op::mem_into_mem, {region::z.address, at_product + root_bits, region::z.width});
    const std::array normals = {region::normal_x, region::normal_y, region::normal_z};
    for (std::size_t k = 0; k < normals.size(); ++k) {
        put_term(out,
                 {sphere.normal_plane[k], sphere.normal_root[k], normal_factor_bits,
                  factor_fraction, normal_fraction, normals[k].width + normal_fraction},
                 u, v, at_root, j);
        out.put(Op::mem_into_mem,
                {normals[k].address, at_product + root_bits + factor_fraction, normals[k].width});
    }
    out.put_word(surface_word);
    return out.words();
}

}  // namespace pxpl5::gp
