#include "host/inspect/instruction_values.hpp"

#include <fmt/format.h>

namespace pxpl5::host::inspect {

namespace {

namespace region = isa::region;

struct NamedField {
    region::Field field;
    const char* name;
};
constexpr NamedField named_fields[] = {
    {region::surface, "surface"},   {region::z, "z"},
    {region::normal_x, "normal_x"}, {region::normal_y, "normal_y"},
    {region::normal_z, "normal_z"}, {region::rgb, "rgb"},
};

constexpr std::size_t plane_words = 3;  ///< Coefficients of the least form that a tree computes.

}  // namespace

std::string field_name(std::uint32_t address, std::uint32_t width) {
    for (const NamedField& named : named_fields) {
        if (named.field.address == address && named.field.width == width) {
            return named.name;
        }
    }
    return fmt::format("m{}:{}", address, width);
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

/// "Q = 55, z = 12", what a test compares.
std::string InstructionValues::operand_text() const {
    std::string text = form_ ? fmt::format("Q = {}", *form_) : "";
    if (width_ != 0) {
        text += fmt::format("{}{} = {}", text.empty() ? "" : ", ",
                            field_name(in_.operands.a, width_), field_);
    }
    return text;
}

std::string InstructionValues::text(const isa::Executor& executor) const {
    const bool acts = enabled_ || (row_.effects & isa::all) != 0;
    if ((row_.effects & isa::mem) != 0) {
        const std::string name = field_name(in_.operands.a, width_);
        return acts ? fmt::format("{} {} -> {}", name, field_, read(executor))
                    : fmt::format("{} {} (pixel disabled)", name, field_);
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
