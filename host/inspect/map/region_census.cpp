#include "host/inspect/map/region_census.hpp"

#include <bit>
#include <cstring>

#include "host/inspect/replay/executors.hpp"
#include "isa/contract/region_layout.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace hal = renderer::hal;
namespace layout = isa::region;
using Map = BitMapCounter::Map;

constexpr std::size_t block_words = hal::block_pixels / 64;
static_assert(std::endian::native == std::endian::little, "bit i of a map is bit i of its bytes");

/// Pixel of a bit: row by row.
std::size_t pixel_of(std::size_t index) {
    const hal::Place place = hal::place_of(index);
    return place.y * region_px + place.x;
}

class Census {
  public:
    Census(const RecordedRegion& region, std::span<const Primitive> primitives)
        : region_(region), primitives_(primitives), walk_(region.plan, executor_) {}

    RegionCensus take() {
        prepare(region_, executor_);
        result_.visible.assign(region_pixels, no_primitive);
        executor_.set_readout([this](std::span<const std::uint32_t> pixels) {
            result_.rgb.assign(pixels.begin(), pixels.end());
        });
        while (!walk_.done()) {
            enter_primitive();
            note();
            walk_.step();
        }
        leave_primitive();
        result_.counts = walk_.counts();
        result_.active = counts(active_);
        result_.covered = counts(covered_);
        result_.written = counts(written_);
        return std::move(result_);
    }

  private:
    static PerPixel counts(const BitMapCounter& counter) {
        PerPixel counts(region_pixels);
        for (std::size_t i = 0; i < region_pixels; ++i) {
            counts[pixel_of(i)] = counter.count(i);
        }
        return counts;
    }

    /// Notes where the walk has come: into another primitive, or out of all of them.
    void enter_primitive() {
        const Primitive* now = primitive_at(primitives_, walk_.at());
        if (now != primitive_) {
            leave_primitive();
            primitive_ = now;
            used_ = false;
        }
        if (walk_.is_part_begin() &&
            region_.plan.parts[walk_.at().part].kind == PartKind::end_of_region) {
            keep_fields();
        }
    }

    void leave_primitive() {
        if (primitive_ == nullptr) {
            return;
        }
        for (std::size_t word = 0; word < Map{}.size(); ++word) {
            for (std::uint64_t bits = wrote_[word]; bits != 0; bits &= bits - 1) {
                const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
                result_.visible[pixel_of(word * 64 + bit)] =
                    static_cast<std::uint32_t>(primitive_->number);
            }
            if (wrote_[word] != 0) {
                written_.add(wrote_, word, 1);
                wrote_[word] = 0;
            }
        }
    }

    /// Counts the enables with which the next instruction begins.
    void note() {
        const hal::PixelArray& pixels = executor_.pixels();
        const isa::Instruction in = walk_.next();
        const isa::OpInfo& row = isa::info(in.op);
        const bool uses = primitive_ != nullptr && !used_ && row.at_a(in.operands) != 0;
        const bool writes = primitive_ != nullptr && (row.effects & isa::mem) != 0 &&
                            in.operands.a < isa::region::scratch;  // The rest shows nothing.
        std::memcpy(enable_.data(), pixels.enable.data(), sizeof enable_);
        for (std::size_t block = 0; block < hal::block_count; ++block) {
            if (!pixels.is_occupied(block)) {
                continue;
            }
            const std::size_t word = block * block_words;
            active_.add(enable_, word, block_words);
            if (uses) {
                covered_.add(enable_, word, block_words);
            }
            for (std::size_t k = 0; writes && k < block_words; ++k) {
                wrote_[word + k] |= enable_[word + k];
            }
        }
        if (writes && (row.effects & isa::all) != 0) {
            wrote_.fill(~std::uint64_t{0});
        }
        used_ = used_ || uses;
    }

    void keep_fields() {
        const auto keep = [&](PerPixel& values, std::uint32_t address, std::uint32_t width) {
            values.resize(region_pixels);
            for (std::size_t i = 0; i < region_pixels; ++i) {
                values[pixel_of(i)] =
                    static_cast<std::uint32_t>(hal::field(executor_.pixels(), i, address, width));
            }
        };
        keep(result_.surface, layout::surface.address, layout::surface.width);
        keep(result_.z, layout::z.address, layout::z.width);
        keep(result_.normal, layout::normal_x.address, 3 * layout::normal_x.width);
    }

    const RecordedRegion& region_;
    std::span<const Primitive> primitives_;
    renderer::fast::Fast executor_;
    RegionWalk walk_;
    RegionCensus result_;
    BitMapCounter active_, covered_, written_;
    Map enable_{}, wrote_{};
    const Primitive* primitive_ = nullptr;  ///< Primitive of the current instruction.
    bool used_ = false;                     ///< It has used memory already.
};

}  // namespace

void BitMapCounter::add(const Map& map, std::size_t first, std::size_t count) {
    for (std::size_t word = first; word < first + count; ++word) {
        std::uint64_t carry = map[word];
        for (std::size_t plane = 0; carry != 0 && plane < planes; ++plane) {
            const std::uint64_t old = planes_[plane][word];
            planes_[plane][word] = old ^ carry;
            carry &= old;
        }
    }
}

std::uint32_t BitMapCounter::count(std::size_t index) const {
    std::uint32_t count = 0;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        const std::uint64_t bit = planes_[plane][index / 64] >> index % 64 & 1;
        count |= static_cast<std::uint32_t>(bit) << plane;
    }
    return count;
}

RegionCensus take_census(const RecordedRegion& region, std::span<const Primitive> primitives) {
    return Census(region, primitives).take();
}

}  // namespace pxpl5::host::inspect
