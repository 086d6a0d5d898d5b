// What both comparisons share, and the comparison of executors.
#include "host/inspect/diff/diff.hpp"

#include <fmt/format.h>

#include <cassert>

#include "host/base/error.hpp"
#include "host/inspect/record/recorded_results.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

/// The instruction at an address, disassembled.
std::string instruction_text(const renderer::RegionPlan& plan, Address address) {
    const renderer::Words words = plan.parts[address.part].segment.words.subspan(address.word);
    const std::size_t count = isa::instruction_words(words[0]);
    std::string text = isa::disassemble(words.first(count));
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
        text.pop_back();
    }
    return text.substr(text.find_first_not_of(' '));
}

std::uint32_t slab_of(const RecordedRegion& region, Address address) {
    return region.plan.parts[address.part].segment.slab;
}

void add_primitive(Difference& difference, const RecordedFrame& frame, const RecordedRegion& region,
                   Address address) {
    const std::vector<Primitive> primitives = primitives_of(frame, region);
    const Primitive* primitive = primitive_at(primitives, address);
    if (primitive == nullptr) {
        return;
    }
    const renderer::Segment& segment = region.plan.parts[address.part].segment;
    const std::string origin = origin_text(*primitive, slab_of(region, address));
    difference.text += fmt::format(
        "\n  primitive    {} of the region: surface {}, slab {}, gp-{}{}", primitive->number,
        segment.surface, segment.slab, segment.gp, origin.empty() ? "" : ", " + origin);
    difference.fields.push_back({"primitive", static_cast<std::int64_t>(primitive->number)});
    difference.fields.push_back({"surface", std::int64_t{segment.surface}});
    difference.fields.push_back({"slab", std::int64_t{segment.slab}});
    difference.fields.push_back({"gp", std::int64_t{segment.gp}});
    if (!origin.empty()) {
        difference.fields.push_back({"origin", origin});
    }
}

void add_pixel(Difference& difference, const RecordedRegion& region, const Divergence& d,
               const DiffOptions& options) {
    const int x = region.place.x0_px + d.bit.x, y = region.place.y0_px + d.bit.y;
    difference.text += fmt::format(
        "\n  pixel        ({}, {}) of the picture, ({}, {}) of the region"
        "\n  field        {}"
        "\n  value        {} has 0x{:x}, {} has 0x{:x}",
        x, y, d.bit.x, d.bit.y, to_text(d.bit), options.trusted.name, d.first, options.other.name,
        d.second);
    for (auto& field : Fields{{"x", std::int64_t{x}},
                              {"y", std::int64_t{y}},
                              {"field", to_text(d.bit)},
                              {"bit", std::int64_t{d.bit.bit}},
                              {options.trusted.name, fmt::format("0x{:x}", d.first)},
                              {options.other.name, fmt::format("0x{:x}", d.second)}}) {
        difference.fields.push_back(field);
    }
}

}  // namespace

NamedExecutor named(ExecutorKind kind) {
    return {std::string(name_of(kind)), [kind] { return make_executor(kind); },
            kind == ExecutorKind::reference};
}

std::string origin_text(const Primitive& primitive, std::uint32_t slab) {
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
    const std::string instruction = instruction_text(region.plan, divergence.address);
    Difference difference;
    difference.level = "instruction";
    difference.frame = frame.number;
    difference.region = region.place.number;
    difference.text = fmt::format("frame {}, {}: {} and {} differ", frame.number,
                                  region_name(frame, region.place.number), options.trusted.name,
                                  options.other.name);
    difference.text += divergence.instructions == 1
                           ? fmt::format("\n  instruction  {}: {}", address, instruction)
                           : fmt::format(
                                 "\n  instructions {} from {} on, only if they run "
                                 "together: {} ...",
                                 divergence.instructions, address, instruction);
    difference.fields = {{"level", difference.level},
                         {"frame", std::int64_t{frame.number}},
                         {"region", std::int64_t{region.place.number}},
                         {"address", address},
                         {"instruction", instruction},
                         {"instructions", static_cast<std::int64_t>(divergence.instructions)}};
    add_primitive(difference, frame, region, divergence.address);
    add_pixel(difference, region, divergence, options);
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
            report.notes.push_back(fmt::format("frame {} is not whole: {}", number, reason));
        }
        ++report.frames;
        for (const auto& [region_number, region] : frame.regions) {
            if (!options.selection.has_region(region_number, region.place.column,
                                              region.place.row) ||
                !options.selection.has_renderer(region.renderer)) {
                continue;
            }
            ++report.regions;
            if (const auto divergence =
                    first_divergence(region.plan, options.trusted.make, options.other.make)) {
                report.difference = describe(frame, region, *divergence, options);
                return report;
            }
        }
    }
    if (report.regions == 0) {
        throw RequestError(ExitCode::bad_data, "no selected region of this run can be executed");
    }
    return report;
}

std::string to_text(const DiffReport& report) {
    std::string text;
    if (report.difference) {
        text = report.difference->text;
    } else {
        text = fmt::format("no difference: {} frame{}, {} regions compared", report.frames,
                           report.frames == 1 ? "" : "s", report.regions);
    }
    for (const std::string& note : report.notes) {
        text += "\nnote: " + note;
    }
    return text;
}

Fields to_fields(const DiffReport& report) {
    Fields fields = {{"same", !report.difference.has_value()},
                     {"frames", static_cast<std::int64_t>(report.frames)},
                     {"regions", static_cast<std::int64_t>(report.regions)}};
    if (report.difference) {
        fields.push_back({"difference", report.difference->fields});
        fields.push_back({"text", report.difference->text});
    }
    std::vector<Fields> notes;
    for (const std::string& note : report.notes) {
        notes.push_back({{"note", note}});
    }
    fields.push_back({"notes", notes});
    return fields;
}

}  // namespace pxpl5::host::inspect
