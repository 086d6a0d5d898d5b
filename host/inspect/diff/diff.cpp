// The comparison of executors, and the answer of both comparisons.
#include "host/inspect/diff/diff.hpp"

#include <fmt/format.h>

#include <cassert>

#include "host/base/error.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

void add_primitive(Answer& answer, const RecordedFrame& frame, const RecordedRegion& region,
                   Address address) {
    const std::vector<Primitive> primitives = primitives_of(frame, region);
    const Primitive* primitive = primitive_at(primitives, address);
    if (primitive == nullptr) {
        return;
    }
    const renderer::Segment& segment = region.plan.parts[address.part].segment;
    const std::string provenance = provenance_text(*primitive, segment.slab);
    answer
        .line(fmt::format("  primitive    {} of the region: surface {}, slab {}, gp-{}{}{}",
                          primitive->number, segment.surface, segment.slab, segment.gp,
                          provenance.empty() ? "" : ", ", provenance))
        .data("primitive", primitive->number)
        .data("surface", segment.surface)
        .data("slab", segment.slab)
        .data("gp", segment.gp)
        .data_if("provenance", provenance);
}

void add_pixel(Answer& answer, const RecordedRegion& region, const Divergence& d,
               const DiffOptions& options) {
    const int x = region.place.x0_px + d.bit.x, y = region.place.y0_px + d.bit.y;
    const std::string first = fmt::format("0x{:x}", d.first),
                      second = fmt::format("0x{:x}", d.second);
    answer
        .line(fmt::format("  pixel        ({}, {}) of the picture, ({}, {}) of the region", x, y,
                          d.bit.x, d.bit.y))
        .line("  field        " + to_text(d.bit))
        .line(fmt::format("  value        {} has {}, {} has {}", options.trusted.name, first,
                          options.other.name, second))
        .data("x", x)
        .data("y", y)
        .data("field", to_text(d.bit))
        .data("bit", d.bit.bit)
        .data(options.trusted.name, first)
        .data(options.other.name, second);
}

}  // namespace

NamedExecutor named(ExecutorKind kind) {
    return {std::string(name_of(kind)), [kind] { return make_executor(kind); },
            kind == ExecutorKind::reference};
}

std::string instruction_text(renderer::Words words, std::size_t word) {
    if (word >= words.size()) {
        return "the end of the stream";
    }
    return isa::disassemble(*isa::decode(words[word]), coefficients_behind(words, word));
}

std::string provenance_text(const Primitive& primitive, std::uint32_t slab) {
    if (!primitive.origin) {
        return "";
    }
    const bus::schema::Origin& o = *primitive.origin;
    return fmt::format("cell ({}, {}, {}), case 0x{:02x}, triangle {}{}", o.i(), o.j(), slab,
                       o.inside(), o.triangle(),
                       o.piece() == 0 ? "" : fmt::format(", piece {}", o.piece()));
}

Difference describe(const RecordedFrame& frame, const RecordedRegion& region,
                    const Divergence& divergence, const DiffOptions& options) {
    const std::string address = to_text(region.plan, divergence.address);
    const std::string instruction = instruction_text(
        region.plan.parts[divergence.address.part].segment.words, divergence.address.word);
    Difference difference{"instruction", {}, frame.number, region.place.number};
    difference.answer
        .line(fmt::format("frame {}, {}: {} and {} differ", frame.number,
                          region_name(frame, region.place.number), options.trusted.name,
                          options.other.name))
        .line(divergence.instructions == 1
                  ? fmt::format("  instruction  {}: {}", address, instruction)
                  : fmt::format("  instructions {} from {}, only if they run together: {} ...",
                                divergence.instructions, address, instruction))
        .data("level", difference.level)
        .data("frame", frame.number)
        .data("region", region.place.number)
        .data("address", address)
        .data("instruction", instruction)
        .data("instructions", divergence.instructions);
    add_primitive(difference.answer, frame, region, divergence.address);
    add_pixel(difference.answer, region, divergence, options);
    return difference;
}

DiffReport diff_executors(const RecordedRun& run, const DiffOptions& options) {
    DiffReport report;
    for (const std::uint32_t number : run.frames()) {
        if (!options.selection.has_frame(number)) {
            continue;
        }
        const RecordedFrame frame = run.frame(number);
        for (const std::string& reason : frame.missing) {
            report.notes.push_back(fmt::format("frame {} is not complete: {}", number, reason));
        }
        ++report.frames;
        for (const RecordedRegion* region : selected_regions(frame, options.selection)) {
            ++report.regions;
            if (const auto divergence =
                    first_divergence(region->plan, options.trusted.make, options.other.make)) {
                report.difference = describe(frame, *region, *divergence, options);
                return report;
            }
        }
    }
    if (report.regions == 0) {
        throw RequestError(ExitCode::bad_data, "no selected region of this run can be executed");
    }
    return report;
}

Answer answer_of(const DiffReport& report) {
    Answer answer;
    answer.data("same", !report.difference.has_value())
        .data("frames", report.frames)
        .data("regions", report.regions);
    if (report.difference) {
        answer.object("difference", report.difference->answer)
            .data("text", report.difference->answer.reply().text);
    } else {
        answer.line(fmt::format("no difference: {}, {} compared", counted(report.frames, "frame"),
                                counted(report.regions, "region")));
    }
    return answer.sentences("notes", "note", "note: ", report.notes);
}

}  // namespace pxpl5::host::inspect
