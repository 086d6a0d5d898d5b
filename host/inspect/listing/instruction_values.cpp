#include "host/inspect/listing/instruction_values.hpp"

#include <fmt/format.h>

namespace pxpl5::host::inspect {

namespace {

namespace region = isa::region;

struct LayoutField {
    region::Field field;
    std::string_view name;
    bool is_signed = false;
};
constexpr LayoutField named_fields[] = {
    {region::surface, "surface"},         {region::z, "z"},
    {region::normal_x, "normal_x", true}, {region::normal_y, "normal_y", true},
    {region::normal_z, "normal_z", true}, {region::rgb, "rgb"},
};

constexpr std::uint32_t value_bits = 64;

/// The layout's field that lies there; null if none does.
const LayoutField* named_at(std::uint32_t address, std::uint32_t width) {
    for (const LayoutField& named : named_fields) {
        if (named.field.address == address && named.field.width == width) {
            return &named;
        }
    }
    return nullptr;
}

constexpr std::size_t plane_words = 3;  ///< Coefficients of the least form that a tree computes.

}  // namespace

std::string field_name(std::uint32_t address, std::uint32_t width) {
    const LayoutField* named = named_at(address, width);
    return named == nullptr ? fmt::format("m{}:{}", address, width) : std::string(named->name);
}

std::optional<region::Field> field_named(std::string_view name) {
    for (const LayoutField& named : named_fields) {
        if (named.name == name) {
            return named.field;
        }
    }
    return std::nullopt;
}

std::int64_t form_of(isa::Coefficients coefficients, RegionPixel pixel) {
    const auto k = [&](std::size_t i) {
        return i < coefficients.size() ? static_cast<std::int64_t>(coefficients[i]) : 0;
    };
    const std::int64_t x = pixel.x, y = pixel.y;
    return k(0) * x + k(1) * y + k(2) + k(3) * x * x + k(4) * x * y + k(5) * y * y;
}

InstructionValues::InstructionValues(isa::Instruction in, isa::Coefficients coefficients,
                                     RegionPixel pixel, const isa::Executor& executor)
    : in_(in),
      row_(isa::info(in.op)),
      pixel_(pixel),
      width_(row_.at_a(in.operands)),
      enabled_(executor.enabled(pixel.x, pixel.y)) {
    field_ = read(executor);
    if (coefficients.size() >= plane_words) {
        form_ = form_of(coefficients, pixel);
    }
}

std::uint64_t InstructionValues::read(const isa::Executor& executor) const {
    return width_ == 0 ? 0 : executor.field(pixel_.x, pixel_.y, in_.operands.a, width_);
}

/// The field's value as a number: signed if the layout says so.
std::string InstructionValues::number(std::uint64_t value) const {
    const LayoutField* named = named_at(in_.operands.a, width_);
    if (named == nullptr || !named->is_signed) {
        return std::to_string(value);
    }
    const std::uint32_t spare = value_bits - width_;
    return std::to_string(static_cast<std::int64_t>(value << spare) >> spare);
}

/// "Q = 55", or "T = 7, z = 12", what a test compares.
std::string InstructionValues::operand_text() const {
    std::string text = form_ ? fmt::format("Q = {}", *form_) : "";
    if (width_ != 0) {
        if (form_) {  // T is what is left of Q without its fraction, in as many bits as the field.
            const auto t = static_cast<std::uint64_t>(*form_ >> in_.operands.b);
            text = fmt::format("T = {}, ", t << (value_bits - width_) >> (value_bits - width_));
        }
        text += fmt::format("{} = {}", field_name(in_.operands.a, width_), number(field_));
    }
    return text;
}

std::string InstructionValues::text(const isa::Executor& executor) const {
    const bool acts = enabled_ || (row_.effects & isa::all) != 0;
    if ((row_.effects & isa::mem) != 0) {
        const std::string name = field_name(in_.operands.a, width_);
        return acts ? fmt::format("{} {} -> {}", name, number(field_), number(read(executor)))
                    : fmt::format("{} {} (pixel disabled)", name, number(field_));
    }
    if ((row_.effects & isa::enable) != 0) {
        const bool enabled = executor.enabled(pixel_.x, pixel_.y);
        const std::string operands = operand_text();
        return fmt::format("{}{}{}", operands, operands.empty() ? "" : ", ",
                           enabled == enabled_ ? (enabled ? "stays enabled" : "stays disabled")
                                               : (enabled ? "is enabled" : "is disabled"));
    }
    return operand_text();
}

}  // namespace pxpl5::host::inspect
