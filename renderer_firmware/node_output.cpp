#include "renderer_firmware/node_output.hpp"

#include "isa/contract/region_layout.hpp"

namespace pxpl5::renderer {

namespace {

namespace schema = bus::schema;

/// Bytes of a body besides its pixels and tiles.
constexpr std::size_t body_margin_bytes = 1024;

/// Returns the size of the body that sends `regions` to the frame buffer.
std::size_t body_bytes(const OutputRegions& regions) {
    const std::size_t words = region_pixels * (regions.with_pixels + regions.with_depths);
    return words * sizeof(std::uint32_t) + regions.all * sizeof(schema::RegionTile) +
           body_margin_bytes;
}

}  // namespace

RegionOutput::RegionOutput(const OutputRegions& regions, flatbuffers::Allocator* memory)
    : body_(body_bytes(regions), memory), pixels_(room_for(regions.with_pixels)) {
    if (regions.reads_depths) {
        depths_ = room_for(regions.with_depths);
    }
}

RegionOutput::Words RegionOutput::room_for(std::size_t regions) {
    std::uint32_t* first = nullptr;
    const std::size_t count = regions * region_pixels;
    const auto offset = body_.CreateUninitializedVector<std::uint32_t>(count, &first);
    return {offset, {first, count}};
}

std::span<std::uint32_t> RegionOutput::next_of(const Words& words, std::size_t regions) {
    return words.words.empty() ? std::span<std::uint32_t>()
                               : words.words.subspan(regions * region_pixels, region_pixels);
}

bus::Payload RegionOutput::finish(std::uint32_t frame, std::uint32_t renderer, double moved_mm) {
    const auto tiles = body_.CreateVectorOfStructs(tiles_);
    return bus::finish(
        body_, schema::CreateRegionPixels(body_, frame, static_cast<std::uint16_t>(renderer), tiles,
                                          pixels_.offset, depths_.offset, moved_mm));
}

}  // namespace pxpl5::renderer
