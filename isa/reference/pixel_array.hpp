// The state of the pixels in the simplest form: one struct per pixel, one bool per bit.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "isa/executor.hpp"

namespace pxpl5::isa::reference {

/// A rectangle of a region, in pixels.
struct Window {
    int x0 = 0, y0 = 0;
    int width = region_px, height = region_px;
    bool contains(int x, int y) const {
        return x >= x0 && x < x0 + width && y >= y0 && y < y0 + height;
    }
};

struct Pixel {
    int x = 0, y = 0;  ///< Position in the region, 0..127.
    bool enable = false;
    bool carry = false;
    std::array<bool, memory_bits> m{};
    std::vector<std::uint32_t> blocks;  ///< Backing store; empty until the first write.
};

/// The pixels of a window, row by row.
struct PixelArray {
    explicit PixelArray(Window w) : window(w), scope(w) {
        assert(w.width > 0 && w.x0 >= 0 && w.x0 + w.width <= region_px);
        assert(w.height > 0 && w.y0 >= 0 && w.y0 + w.height <= region_px);
        pixels.resize(static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height));
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            pixels[i].x = w.x0 + static_cast<int>(i) % w.width;
            pixels[i].y = w.y0 + static_cast<int>(i) / w.width;
        }
    }

    /// Returns the pixel (x, y), which must be in the window.
    Pixel& at(int x, int y) {
        assert(window.contains(x, y));
        return pixels[static_cast<std::size_t>((y - window.y0) * window.width + x - window.x0)];
    }
    const Pixel& at(int x, int y) const { return const_cast<PixelArray*>(this)->at(x, y); }

    Window window;
    Window scope;  ///< The pixels that instructions act on; a part of the window, or empty.
    std::vector<Pixel> pixels;
    std::function<void(std::span<const std::uint32_t>)>
        readout;  ///< Receives the pixels of PIXELSTOFB.
};

}  // namespace pxpl5::isa::reference
