#include "host/inspect/record/message_text.hpp"

#include <fmt/format.h>

#include "host/base/answer.hpp"
#include "ringbus/rules/slice_planes.hpp"
#include "ringbus/trace/trace_info.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;

template <typename Vector>
std::size_t count_of(const Vector* vector) {
    return vector == nullptr ? 0 : vector->size();
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
    return fmt::format("{}, recording {}", counted(m.nodes()->size(), "node"),
                       enum_name(m.recording()));
}
std::string text(const schema::Shutdown& m) {
    return m.reason() == nullptr ? "" : m.reason()->str();
}
std::string text(const schema::Credit& m) {
    return fmt::format("{}, {}", counted(m.messages(), "message"), counted(m.bytes(), "byte"));
}
std::string text(const schema::Fault& m) {
    return fmt::format("{}: {}", schema::EnumNameFaultCode(m.code()), m.reason()->c_str());
}
std::string text(const schema::ImportVolume& m) {
    return m.path()->str();
}
/// "/scans/ct/1.dcm and 111 more places".
std::string text(const flatbuffers::Vector<flatbuffers::Offset<schema::SlicesFile>>& files) {
    const std::string first = files.Get(0)->path()->str();
    return files.size() == 1
               ? first
               : fmt::format("{} and {}", first, counted(files.size() - 1, "more place"));
}
std::string text(const schema::VolumeHeader& m) {
    return fmt::format("volume {} '{}': {}x{}x{} {}, values {} .. {}, digest {:016x}{}", m.volume(),
                       m.name()->c_str(), m.nx(), m.ny(), m.nz(), enum_name(m.type()), m.minimum(),
                       m.maximum(), m.digest(),
                       m.stored() == nullptr ? "" : "; GPs read " + text(*m.stored()->files()));
}
std::string text(const schema::Slices& m) {
    return fmt::format("volume {}, slices {} .. {}", m.volume(), m.first_slice(),
                       m.first_slice() + m.slice_count() - 1);
}
std::string text(const schema::VolumeEnd& m) {
    return fmt::format("volume {}", m.volume());
}
std::string text(const schema::VolumeReady& m) {
    return fmt::format("volume {}: {}, {} in use, {} us", m.volume(), counted(m.slabs(), "slab"),
                       counted(m.memory_bytes(), "byte"), grouped(m.elapsed_us()));
}
std::string text(const schema::ExportPicture& m) {
    return fmt::format("{} x {} to {}", m.width(), m.height(), m.path()->c_str());
}
std::string text(const schema::IoDone& m) {
    return m.ok() ? "ok" : "failed" + if_any(": ", m.error());
}
std::string text(const schema::SetSurface& m) {
    return fmt::format("surface {} revision {}: isovalue {}, table {}", m.surface(), m.revision(),
                       m.isovalue(), enum_name(m.table()));
}
std::string text(const schema::RemoveSurface& m) {
    return fmt::format("surface {}", m.surface());
}
std::string text(const schema::SurfaceBuilt& m) {
    std::uint64_t triangles = 0;
    for (const schema::SlabCounts* slab : *m.slabs()) {
        triangles += slab->triangles();
    }
    return fmt::format(
        "surface {} revision {}: {} in {}, {} us{}", m.surface(), m.revision(),
        counted(triangles, "triangle"), counted(m.slabs()->size(), "slab"), grouped(m.elapsed_us()),
        m.left_out() == 0 ? ""
                          : fmt::format("; {} left out of memory", counted(m.left_out(), "slab")));
}
std::string detail_text(int detail) {
    return detail == 0 ? "" : fmt::format(", detail {}", detail);
}
std::string text(const schema::FetchMesh& m) {
    return fmt::format("surface {}{}", m.surface(), detail_text(m.detail()));
}
std::string text(const schema::MeshPart& m) {
    return fmt::format("surface {} revision {}{}: {}", m.surface(), m.revision(),
                       detail_text(m.detail()),
                       counted(m.slabs()->size(), m.detail() == 0 ? "slab" : "block"));
}
std::string text(const schema::DrawFrame& m) {
    const std::size_t planes = bus::plane_count(m);
    return fmt::format("frame {}: {} x {}, {}, {}{}, {}{}", m.frame(), m.width(), m.height(),
                       counted(m.views()->size(), "view"), counted(bus::first_plane(m), "surface"),
                       planes == 0 ? "" : ", " + counted(planes, "slice plane"),
                       counted(m.lights()->size(), "light"),
                       m.samples() == 1
                           ? std::string()
                           : fmt::format(", sample {} of {}", m.sample() + 1, m.samples()));
}
std::string text(const schema::BeginFrame& m) {
    return fmt::format("{}; {} assigned", text(*m.draw()),
                       counted(m.assignment()->size(), "region"));
}
std::string text(const schema::RegionPrograms& m) {
    std::size_t words = 0, segments = 0;
    for (const schema::RegionProgram* region : *m.regions()) {
        words += region->words()->size();
        segments += region->segments()->size();
    }
    return fmt::format("frame {}, gp-{}: {}, {}, {}", m.frame(), m.gp(),
                       counted(m.regions()->size(), "region"), counted(segments, "segment"),
                       counted(words, "word"));
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
                       counted(m.tiles()->size(), "region"), regions.empty() ? "" : ":", regions,
                       counted(instructions, "instruction"), counted(cycles, "cycle"));
}
std::string text(const schema::FrameDone& m) {
    return fmt::format("frame {}: {} x {}, {}, {}", m.frame(), m.width(), m.height() * m.views(),
                       counted(m.instructions(), "instruction"),
                       count_of(m.pixels()) == 0 ? "without pixels" : "with pixels");
}
std::string text(const schema::TraceSaved& m) {
    return fmt::format("{}, {}{}", counted(m.messages(), "message"), counted(m.bytes(), "byte"),
                       if_any("; ", m.error()));
}
std::string text(const schema::SceneBegin& m) {
    return fmt::format("scene {}: {}", m.scene(), counted(m.surfaces()->size(), "surface"));
}
std::string text(const schema::ScenePart& m) {
    return fmt::format("scene {}, surface {} slab {}: {}, {}, {}", m.scene(), m.surface(), m.slab(),
                       counted(m.indices()->size() / 3, "triangle"),
                       counted(m.spheres()->size(), "sphere"), counted(m.lines()->size(), "line"));
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
                       counted(primitives, "primitive"), counted(m.drawn()->size(), "slab"),
                       counted(m.parts()->size(), "part"));
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

std::string describe(const bus::Message& message) {
    using namespace schema;
    return text_of_any<Hello, Topology, Shutdown, Credit, Fault, ImportVolume, VolumeHeader, Slices,
                       VolumeEnd, VolumeReady, ExportPicture, IoDone, SetSurface, RemoveSurface,
                       SurfaceBuilt, FetchMesh, MeshPart, DrawFrame, BeginFrame, RegionPrograms,
                       RegionPixels, FrameDone, TraceSaved, SceneBegin, ScenePart, SceneEnd,
                       FrameCounts>(message);
}

}  // namespace pxpl5::host::inspect
