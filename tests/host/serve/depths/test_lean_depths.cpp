// Tests the depths that go to a page.
#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host/serve/depths/lean_packing.hpp"
#include "isa/contract/depth.hpp"
#include "tests/host/serve/depths/depth_pictures.hpp"
#include "tests/random_seed.hpp"

namespace pxpl5::host::serve {
namespace {

using test::DepthPicture;
using Depths = std::vector<std::uint32_t>;

constexpr std::uint32_t last_depth = isa::region::z_far - isa::region::z_margin;

std::uint32_t word_of(std::uint32_t depth, std::uint32_t surface = 1) {
    return depth << 8U | surface;
}

constexpr std::uint32_t near_depth = last_depth / 4, far_depth = last_depth / 2;

/// The left half is near, the right half far.
Depths near_at_left(std::size_t width, std::size_t height) {
    Depths depths;
    for (std::size_t i = 0; i < width * height; ++i) {
        depths.push_back(word_of(i % width < width / 2 ? near_depth : far_depth));
    }
    return depths;
}

LeanDepths lean_of(const DepthPicture& picture) {
    return lean_depths(picture.width, picture.height, picture.depths);
}

std::vector<std::uint8_t> inflated(const std::string& bytes, std::size_t size) {
    std::vector<std::uint8_t> plain(size + 1);
    z_stream stream{};
    REQUIRE(inflateInit2(&stream, -15) == Z_OK);
    std::string input = bytes;
    stream.next_in = reinterpret_cast<Bytef*>(input.data());
    stream.avail_in = static_cast<uInt>(input.size());
    stream.next_out = plain.data();
    stream.avail_out = static_cast<uInt>(plain.size());
    CHECK(inflate(&stream, Z_FINISH) == Z_STREAM_END);
    plain.resize(stream.total_out);
    inflateEnd(&stream);
    return plain;
}

bool is_covered(const DepthPicture& picture, int x, int y) {
    return x >= 0 && y >= 0 && x < picture.width && y < picture.height &&
           (picture.at(x, y) & 0xffU) != 0;
}

/// Whether a cell, counted from 0, has a covered pixel.
bool is_cell_covered(const DepthPicture& picture, int column, int row) {
    for (int y = 4 * row; y < 4 * row + 4; ++y) {
        for (int x = 4 * column; x < 4 * column + 4; ++x) {
            if (is_covered(picture, x, y)) {
                return true;
            }
        }
    }
    return false;
}

}  // namespace

TEST_CASE("the mask has a bit for each pixel that shows a surface") {
    for (const DepthPicture& picture :
         test::depth_pictures(pxpl5::test::seed_or<std::uint64_t>(71))) {
        CAPTURE(picture.name);
        const LeanDepths lean = lean_of(picture);
        REQUIRE(lean.mask.size() ==
                mask_row_bytes(picture.width) * static_cast<std::size_t>(picture.height));
        int wrong = 0;
        for (int y = 0; y < picture.height; ++y) {
            for (int x = 0; x < 8 * static_cast<int>(mask_row_bytes(picture.width)); ++x) {
                const std::size_t at = static_cast<std::size_t>(y) * mask_row_bytes(picture.width) +
                                       static_cast<std::size_t>(x / 8);
                wrong += (lean.mask[at] >> (x % 8) & 1) != int{is_covered(picture, x, y)} ? 1 : 0;
            }
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a corner has a depth where a cell around it shows a surface, and nowhere else") {
    for (const DepthPicture& picture :
         test::depth_pictures(pxpl5::test::seed_or<std::uint64_t>(72))) {
        CAPTURE(picture.name);
        const LeanDepths lean = lean_of(picture);
        REQUIRE(lean.columns == (picture.width + 3) / 4 + 1);
        REQUIRE(lean.rows == (picture.height + 3) / 4 + 1);
        REQUIRE(lean.corners.size() == static_cast<std::size_t>(lean.columns * lean.rows));
        int wrong = 0;
        for (int row = 0; row < lean.rows; ++row) {
            for (int column = 0; column < lean.columns; ++column) {
                const bool is_used = is_cell_covered(picture, column - 1, row - 1) ||
                                     is_cell_covered(picture, column, row - 1) ||
                                     is_cell_covered(picture, column - 1, row) ||
                                     is_cell_covered(picture, column, row);
                const int corner =
                    lean.corners[static_cast<std::size_t>(row * lean.columns + column)];
                wrong += (corner != 0) != is_used || corner > max_lean ? 1 : 0;
            }
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("depths are linear in z after the division by w, 12 bits from near to far") {
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const auto depth =
            static_cast<std::uint32_t>(isa::region::z_margin + share * isa::depth_span);
        const LeanDepths lean = lean_depths(4, 4, Depths(16, word_of(depth)));
        CHECK(lean.corners.size() == 4);
        for (const std::uint16_t corner : lean.corners) {
            CHECK((corner - 0.5) / max_lean == doctest::Approx(share).epsilon(0.001));
        }
    }
    CHECK(lean_depths(1, 1, Depths{word_of(0)}).corners.front() == 1);
    CHECK(lean_depths(1, 1, Depths{word_of(last_depth)}).corners.front() == max_lean);
}

TEST_CASE("a corner takes the pixels that touch it before the cells around it") {
    Depths depths(8 * 8, 0);
    depths[3 * 8 + 3] = word_of(far_depth);  // Touches the corner in the middle.
    depths[0] = word_of(near_depth);         // Lies in the same cell.
    const LeanDepths lean = lean_depths(8, 8, depths);
    REQUIRE(lean.columns == 3);
    const double middle = (lean.corners[4] - 0.5) / max_lean;
    CHECK(middle == doctest::Approx(0.5).epsilon(0.001));
    const double left = (lean.corners[3] - 0.5) / max_lean;  // No pixel touches this corner.
    CHECK(left == doctest::Approx(0.25).epsilon(0.001));
}

TEST_CASE("a cell with two surfaces is a seam, each with its pixels and its depth") {
    const LeanDepths lean = lean_depths(12, 12, near_at_left(12, 12));
    REQUIRE(lean.seams.size() == 3);  // The middle column of cells.
    for (std::uint32_t row = 0; row < 3; ++row) {
        const Seam& seam = lean.seams[row];
        CHECK(seam.cell == 3 * row + 1);
        CHECK(seam.near_pixels == 0x3333);  // The left two of each four pixels.
        for (std::size_t corner = 0; corner < 4; ++corner) {
            CHECK(seam.near[corner] == lean_of(near_depth));
            CHECK(seam.far[corner] == lean_of(far_depth));
        }
    }
}

TEST_CASE("the far cell beside an edge has corners of its own") {
    const LeanDepths lean = lean_depths(8, 4, near_at_left(8, 4));
    CHECK(lean.corners[1] == lean_of(near_depth));  // Both surfaces touch this corner.
    REQUIRE(lean.seams.size() == 1);
    CHECK(lean.seams[0].cell == 1);
    CHECK(lean.seams[0].near_pixels == 0);
    CHECK(lean.seams[0].near == lean.corners_of(1));
    for (const std::uint16_t depth : lean.seams[0].far) {
        CHECK(depth == lean_of(far_depth));
    }
}

TEST_CASE("a steep surface has no seams, nor have two surfaces that nearly touch") {
    Depths steep, step;
    for (std::uint32_t i = 0; i < 16 * 16; ++i) {
        steep.push_back(word_of(4'000'000 + 300'000 * (i % 16)));  // 290 steps of depth per cell.
        step.push_back(word_of(i % 16 < 6 ? 8'000'000 : 8'000'000 + 45 * 4096));
    }
    CHECK(lean_depths(16, 16, steep).seams.empty());
    CHECK(lean_depths(16, 16, step).seams.empty());
}

TEST_CASE("another number of depths than of pixels is refused") {
    CHECK_THROWS_WITH(lean_depths(3, 2, Depths(5)),
                      "lean depths: 5 depths, but a picture of 3 x 2 pixels has 6. Pass the depths "
                      "of one view");
}

TEST_CASE("depths of several pictures are packed one by one, each after its length") {
    Depths both(16 * 8, word_of(last_depth / 4));
    const std::string upper = packed(lean_depths(16, 8, both));
    both.resize(2 * both.size(), 0);
    const std::string lower = packed(lean_depths(16, 8, Depths(16 * 8, 0)));
    const auto length = [](const std::string& bytes) {
        return std::string{static_cast<char>(bytes.size() & 0xffU),
                           static_cast<char>(bytes.size() >> 8U), '\0', '\0'};
    };
    CHECK(packed_stack(16, 8, 2, both) == length(upper) + upper + length(lower) + lower);
    CHECK_THROWS_WITH(packed_stack(16, 9, 2, both),
                      doctest::Contains("a picture of 16 x 9 pixels has 144"));
}

TEST_CASE("an even surface is packed as zeros behind its first corner") {
    const LeanDepths lean = lean_depths(16, 8, Depths(16 * 8, word_of(last_depth / 4)));
    const std::size_t count = lean.corners.size();
    const std::size_t size = lean.mask.size() + 2 * count + 1;  // The last byte: no seams.
    const std::vector<std::uint8_t> plain = inflated(packed(lean), size);
    REQUIRE(plain.size() == size);
    CHECK(plain.back() == 0);
    CHECK(plain[0] == 0xff);
    CHECK(std::all_of(plain.begin() + 2, plain.begin() + 16, [](int byte) { return byte == 0; }));
    // 1 is predicted for the first corner; a difference d is 2 d.
    const int folded = plain[16] | plain[16 + count] << 8;
    CHECK(folded == 2 * (lean.corners[0] - 1));
    CHECK(std::all_of(plain.begin() + 17, plain.begin() + 16 + static_cast<int>(count),
                      [](int byte) { return byte == 0; }));
}

}  // namespace pxpl5::host::serve
