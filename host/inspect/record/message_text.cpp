#include "host/inspect/record/message_text.hpp"

#include <fmt/format.h>

#include "ringbus/trace/trace_info.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;

template <typename Vector>
std::size_t count_of(const Vector* vector) {
    return vector == nullptr ? 0 : vector->size();
}

/// "1 region", "5 regions".
std::string many(std::size_t count, const char* thing) {
    return fmt::format("{} {}{}", grouped(count), thing, count == 1 ? "" : "s");
}

/// "; reason", or nothing.
std::string if_any(const char* before, const flatbuffers::String* text) {
    return text == nullptr || text->size() == 0 ? "" : before + text->str();
}

std::string text(const schema::Hello& m) {
    return fmt::format("{}, process {}, {}", bus::trace::name_of(m.role(), m.index()), m.pid(),
                       m.build()->c_str());
}
std::string text(const schema::Topology& m) {
    return fmt::format("{}, recording {}", many(m.nodes()->size(), "node"),
                       schema::EnumNameRecording(m.recording()));
}
std::string text(const schema::Shutdown& m) {
    return m.reason() == nullptr ? "" : m.reason()->str();
}
std::string text(const schema::Credit& m) {
    return fmt::format("{}, {}", many(m.messages(), "message"), many(m.bytes(), "byte"));
}
std::string text(const schema::Fault& m) {
    return fmt::format("{}: {}", schema::EnumNameFaultCode(m.code()), m.reason()->c_str());
}
std::string text(const schema::ImportVolume& m) {
    return m.path()->str();
}
std::string text(const schema::VolumeHeader& m) {
    return fmt::format("volume {} '{}': {}x{}x{} {}, values {} .. {}, digest {:016x}", m.volume(),
                       m.name()->c_str(), m.nx(), m.ny(), m.nz(),
                       schema::EnumNameScalarType(m.type()), m.minimum(), m.maximum(), m.digest());
}
std::string text(const schema::Slices& m) {
    return fmt::format("volume {}, slices {} .. {}", m.volume(), m.first_slice(),
                       m.first_slice() + m.slice_count() - 1);
}
std::string text(const schema::VolumeEnd& m) {
    return fmt::format("volume {}", m.volume());
}
std::string text(const schema::VolumeReady& m) {
    return fmt::format("volume {}: {}, {} in use, {} us", m.volume(), many(m.slabs(), "slab"),
                       many(m.memory_bytes(), "byte"), grouped(m.elapsed_us()));
}
std::string text(const schema::ExportPicture& m) {
    return fmt::format("{} x {} to {}", m.width(), m.height(), m.path()->c_str());
}
std::string text(const schema::IoDone& m) {
    return m.ok() ? "ok" : "failed" + if_any(": ", m.error());
}
std::string text(const schema::SetSurface& m) {
    return fmt::format("surface {} revision {}: isovalue {}, table {}", m.surface(), m.revision(),
                       m.isovalue(), schema::EnumNameCaseTable(m.table()));
}
std::string text(const schema::RemoveSurface& m) {
    return fmt::format("surface {}", m.surface());
}
std::string text(const schema::SurfaceBuilt& m) {
    std::uint64_t triangles = 0;
    for (const schema::SlabCounts* slab : *m.slabs()) {
        triangles += slab->triangles();
    }
    return fmt::format("surface {} revision {}: {} in {}, {} us", m.surface(), m.revision(),
                       many(triangles, "triangle"), many(m.slabs()->size(), "slab"),
                       grouped(m.elapsed_us()));
}
std::string text(const schema::FetchMesh& m) {
    return fmt::format("surface {}", m.surface());
}
std::string text(const schema::MeshPart& m) {
    return fmt::format("surface {} revision {}: {}", m.surface(), m.revision(),
                       many(m.slabs()->size(), "slab"));
}
std::string text(const schema::DrawFrame& m) {
    return fmt::format("frame {}: {} x {}, {}, {}, {}{}", m.frame(), m.width(), m.height(),
                       many(m.views()->size(), "view"), many(m.surfaces()->size(), "surface"),
                       many(m.lights()->size(), "light"),
                       m.samples() == 1
                           ? std::string()
                           : fmt::format(", sample {} of {}", m.sample() + 1, m.samples()));
}
std::string text(const schema::BeginFrame& m) {
    return fmt::format("{}; {} assigned", text(*m.draw()), many(m.assignment()->size(), "region"));
}
std::string text(const schema::RegionPrograms& m) {
    std::size_t words = 0, segments = 0;
    for (const schema::RegionProgram* region : *m.regions()) {
        words += region->words()->size();
        segments += region->segments()->size();
    }
    return fmt::format("frame {}, gp-{}: {}, {}, {}", m.frame(), m.gp(),
                       many(m.regions()->size(), "region"), many(segments, "segment"),
                       many(words, "word"));
}
std::string text(const schema::RegionPixels& m) {
    std::uint64_t instructions = 0, cycles = 0;
    std::string regions;
    for (const schema::RegionTile* tile : *m.tiles()) {
        instructions += tile->instructions();
        cycles += tile->cycles();
        regions += fmt::format(" {}", tile->region());
    }
    return fmt::format("frame {}, renderer-{}: {}{}{}, {}, {}", m.frame(), m.renderer(),
                       many(m.tiles()->size(), "region"), regions.empty() ? "" : ":", regions,
                       many(instructions, "instruction"), many(cycles, "cycle"));
}
std::string text(const schema::FrameDone& m) {
    return fmt::format("frame {}: {} x {}, {}, {}", m.frame(), m.width(), m.height() * m.views(),
                       many(m.instructions(), "instruction"),
                       count_of(m.pixels()) == 0 ? "without pixels" : "with pixels");
}
std::string text(const schema::TraceSaved& m) {
    return fmt::format("{}, {}{}", many(m.messages(), "message"), many(m.bytes(), "byte"),
                       if_any("; ", m.error()));
}
std::string text(const schema::SceneBegin& m) {
    return fmt::format("scene {}: {}", m.scene(), many(m.surfaces()->size(), "surface"));
}
std::string text(const schema::ScenePart& m) {
    return fmt::format("scene {}, surface {} slab {}: {}, {}, {}", m.scene(), m.surface(), m.slab(),
                       many(m.indices()->size() / 3, "triangle"),
                       many(m.spheres()->size(), "sphere"), many(m.lines()->size(), "line"));
}
std::string text(const schema::SceneEnd& m) {
    return fmt::format("scene {}", m.scene());
}
std::string text(const schema::FrameCounts& m) {
    std::uint64_t primitives = 0;
    for (const schema::DrawnSlab* slab : *m.drawn()) {
        primitives += slab->primitives();
    }
    return fmt::format("frame {}: {} in {}, {} of regions", m.frame(),
                       many(primitives, "primitive"), many(m.drawn()->size(), "slab"),
                       many(m.parts()->size(), "part"));
}

/// The text of the first of these kinds that the message is.
template <typename... Kinds>
std::string text_of_any(const bus::Message& message) {
    std::string found;
    const auto one = [&]<typename Kind>(const Kind* body) {
        if (body != nullptr) {
            found = text(*body);
        }
    };
    (one(message.as<Kinds>()), ...);
    return found;
}

}  // namespace

std::string grouped(std::uint64_t number) {
    std::string text = std::to_string(number);
    for (std::size_t at = text.size(); at > 3;) {
        at -= 3;
        text.insert(at, ",");
    }
    return text;
}

std::string describe(const bus::Message& message) {
    using namespace schema;
    return text_of_any<Hello, Topology, Shutdown, Credit, Fault, ImportVolume, VolumeHeader, Slices,
                       VolumeEnd, VolumeReady, ExportPicture, IoDone, SetSurface, RemoveSurface,
                       SurfaceBuilt, FetchMesh, MeshPart, DrawFrame, BeginFrame, RegionPrograms,
                       RegionPixels, FrameDone, TraceSaved, SceneBegin, ScenePart, SceneEnd,
                       FrameCounts>(message);
}

bool is_of_frame(Body kind) {
    return kind == Body::DrawFrame || kind == Body::BeginFrame || kind == Body::RegionPrograms ||
           kind == Body::RegionPixels || kind == Body::FrameDone || kind == Body::FrameCounts;
}

std::optional<std::uint32_t> frame_of(const bus::Message& message) {
    if (const auto* draw = message.as<schema::DrawFrame>()) {
        return draw->frame();
    }
    if (const auto* begin = message.as<schema::BeginFrame>()) {
        return begin->draw()->frame();
    }
    if (const auto* programs = message.as<schema::RegionPrograms>()) {
        return programs->frame();
    }
    if (const auto* pixels = message.as<schema::RegionPixels>()) {
        return pixels->frame();
    }
    if (const auto* done = message.as<schema::FrameDone>()) {
        return done->frame();
    }
    if (const auto* counts = message.as<schema::FrameCounts>()) {
        return counts->frame();
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
