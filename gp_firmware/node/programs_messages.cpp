#include "gp_firmware/node/programs_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "gp_firmware/node/messages.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;

// Bytes that a table and a region add to the words, with room for alignment.
constexpr std::size_t message_overhead_bytes = 256, region_overhead_bytes = 64;

/// Returns the maximal size of a Renderer's message.
std::size_t size_bytes(std::span<const RegionProgram> regions,
                       const std::vector<std::size_t>& mine) {
    std::size_t bytes = message_overhead_bytes;
    for (const std::size_t region : mine) {
        bytes += regions[region].word_count() * sizeof(std::uint32_t) + region_overhead_bytes +
                 regions[region].segments.size() * sizeof(schema::Segment) +
                 regions[region].origins.size() * sizeof(schema::Origin);
    }
    return bytes;
}

/// Writes a region's program into a message. `words` receives the place for its words.
flatbuffers::Offset<schema::RegionProgram> to_wire(flatbuffers::FlatBufferBuilder& builder,
                                                   std::size_t region, const RegionProgram& program,
                                                   std::uint32_t*& words) {
    static_assert(FLATBUFFERS_LITTLEENDIAN);
    std::uint8_t* bytes = nullptr;
    const auto words_at =
        builder.CreateUninitializedVector(program.word_count(), sizeof(std::uint32_t), &bytes);
    words = reinterpret_cast<std::uint32_t*>(bytes);
    schema::Segment* segments = nullptr;
    const auto segments_at =
        builder.CreateUninitializedVectorOfStructs(program.segments.size(), &segments);
    std::ranges::transform(program.segments, segments, [](const Segment& s) {
        return schema::Segment(s.surface, s.slab, s.first_word, s.word_count);
    });
    return schema::CreateRegionProgram(
        builder, static_cast<std::uint16_t>(region), segments_at,
        flatbuffers::Offset<flatbuffers::Vector<std::uint32_t>>(words_at),
        program.origins.empty() ? 0 : origins_to_wire(builder, program.origins.values()));
}

}  // namespace

bus::Payload empty_programs_message(std::uint32_t frame, std::uint16_t gp_index,
                                    const DrawCounts& counts) {
    flatbuffers::FlatBufferBuilder builder(message_overhead_bytes);
    const auto none =
        builder.CreateVector(std::vector<flatbuffers::Offset<schema::RegionProgram>>());
    return bus::finish(
        builder, schema::CreateRegionPrograms(builder, frame, gp_index, none, counts.triangles_in,
                                              counts.triangles_out, counts.moved_mm));
}

void ProgramsMessages::begin(const FrameRequest& request, std::uint16_t gp_index,
                             std::size_t renderer_count, const FrameDrawing& drawing) {
    frame_ = request.frame;
    gp_index_ = gp_index;
    next_renderer_ = 0;
    made_ = false;
    regions_of_.resize(renderer_count);
    for (std::vector<std::size_t>& mine : regions_of_) {
        mine.clear();
    }
    const auto regions = drawing.programs().regions();
    for (std::size_t region = 0; region < regions.size(); ++region) {
        if (regions[region].word_count() > 0) {
            regions_of_[request.assignment[region]].push_back(region);
        }
    }
    // Checks all sizes before the first message is sent.
    for (const std::vector<std::size_t>& mine : regions_of_) {
        const std::size_t bytes = size_bytes(regions, mine);
        if (bytes > bus::max_body_bytes) {
            throw bus::NodeFault(
                schema::FaultCode::out_of_memory,
                fmt::format("frame {}: GP {} has {} bytes of programs for one Renderer, a message "
                            "holds {}; more GPs or Renderers share them",
                            request.frame, gp_index, bytes, bus::max_body_bytes));
        }
    }
    empty_ = empty_programs_message(frame_, gp_index, drawing.counts());
}

/// Makes the message of next_renderer_, without its words.
void ProgramsMessages::make(const FrameDrawing& drawing, bus::Outbox& out) {
    const std::vector<std::size_t>& mine = regions_of_[next_renderer_];
    made_ = true;
    rooms_.clear();
    next_room_ = 0;
    if (mine.empty()) {
        payload_ = empty_;
        return;
    }
    const auto regions = drawing.programs().regions();
    // The builder has its final size, so that words never move.
    flatbuffers::FlatBufferBuilder builder(size_bytes(regions, mine), out.body_allocator());
    std::vector<flatbuffers::Offset<schema::RegionProgram>> programs;
    programs.reserve(mine.size());
    for (const std::size_t region : mine) {
        rooms_.push_back({region, nullptr});
        programs.push_back(to_wire(builder, region, regions[region], rooms_.back().words));
    }
    const auto programs_at = builder.CreateVector(programs);
    payload_ = bus::finish(
        builder, schema::CreateRegionPrograms(
                     builder, frame_, gp_index_, programs_at, drawing.counts().triangles_in,
                     drawing.counts().triangles_out, drawing.counts().moved_mm));
    assert(std::as_bytes(payload_.bytes()).data() <=
           static_cast<const void*>(rooms_.front().words));
}

bool ProgramsMessages::send(const FrameDrawing& drawing, std::size_t triangle_count,
                            std::span<const bus::NodeId> renderers, bus::Outbox& out) {
    assert(renderers.size() == regions_of_.size());
    std::size_t written = 0;
    for (; next_renderer_ < renderers.size(); ++next_renderer_) {
        if (!made_) {
            make(drawing, out);
        }
        for (; next_room_ < rooms_.size(); ++next_room_) {
            if (written >= triangle_count) {
                return true;
            }
            const Room& room = rooms_[next_room_];
            write_words(drawing.programs(), room.region, drawing.grid(), room.words);
            written += drawing.programs().regions()[room.region].triangles.size();
        }
        out.send(renderers[next_renderer_], std::exchange(payload_, {}));
        made_ = false;
    }
    return false;
}

}  // namespace pxpl5::gp
