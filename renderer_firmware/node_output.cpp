#include "renderer_firmware/node_output.hpp"

#include "isa/contract/region_layout.hpp"

namespace pxpl5::renderer {

namespace {

namespace schema = bus::schema;

/// Bytes of a body besides its pixels and tiles.
constexpr std::size_t body_margin_bytes = 1024;

/// Returns the size of the body that sends `regions` regions to the frame buffer.
std::size_t body_bytes(std::size_t regions, const OutputContents& contents) {
    const std::size_t words =
        region_pixels * ((contents.pixels ? 1 : 0) + (contents.depths ? 1 : 0));
    return regions * (words * sizeof(std::uint32_t) + sizeof(schema::RegionTile)) +
           body_margin_bytes;
}

}  // namespace

RegionOutput::RegionOutput(std::size_t regions, const OutputContents& contents,
                           flatbuffers::Allocator* memory)
    : body_(body_bytes(regions, contents), memory),
      pixels_(room_for(contents.pixels ? regions : 0)) {
    if (contents.depths) {
        depths_ = room_for(regions);
    }
}

RegionOutput::Words RegionOutput::room_for(std::size_t regions) {
    std::uint32_t* first = nullptr;
    const std::size_t count = regions * region_pixels;
    const auto offset = body_.CreateUninitializedVector<std::uint32_t>(count, &first);
    return {offset, {first, count}};
}

std::span<std::uint32_t> RegionOutput::next_of(const Words& words) const {
    return words.words.empty() ? std::span<std::uint32_t>()
                               : words.words.subspan(tiles_.size() * region_pixels, region_pixels);
}

bus::Payload RegionOutput::finish(std::uint32_t frame, std::uint32_t renderer, double moved_mm) {
    const auto tiles = body_.CreateVectorOfStructs(tiles_);
    return bus::finish(
        body_, schema::CreateRegionPixels(body_, frame, static_cast<std::uint16_t>(renderer), tiles,
                                          pixels_.offset, depths_.offset, moved_mm));
}

}  // namespace pxpl5::renderer
