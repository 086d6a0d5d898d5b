#include "host/picture_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <span>

#include "host/command_handlers.hpp"
#include "host/digest.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host {

namespace {

constexpr std::array<std::string_view, 4> scalar_names = {"uint8", "int16", "uint16", "float32"};

glm::dvec3 axis_mm(const Volume& volume, int axis) {
    return glm::dvec3(volume.voxel_to_patient[axis]);
}

constexpr std::array<int, 5> quantile_percent = {5, 25, 50, 75, 95};
constexpr std::size_t max_sampled = 200'000;

template <typename T>
std::vector<double> quantiles_of(std::span<const std::byte> bytes) {
    const std::size_t count = bytes.size() / sizeof(T);
    const std::size_t step = count / max_sampled + 1;
    std::vector<T> sample;
    for (std::size_t i = 0; i < count; i += step) {
        T value;
        std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
        if (value == value) {  // Not a number has no place in an order.
            sample.push_back(value);
        }
    }
    std::sort(sample.begin(), sample.end());
    std::vector<double> values;
    for (const int percent : quantile_percent) {
        if (!sample.empty()) {
            const std::size_t last = sample.size() - 1;
            values.push_back(
                static_cast<double>(sample[last * static_cast<std::size_t>(percent) / 100]));
        }
    }
    return values;
}

/// Values that so many percent of the voxels do not exceed, from every n-th voxel: where isovalues
/// are worth trying.
std::vector<double> quantiles(const Volume& volume) {
    switch (volume.type) {
        case Scalar::uint8:
            return quantiles_of<std::uint8_t>(volume.values);
        case Scalar::int16:
            return quantiles_of<std::int16_t>(volume.values);
        case Scalar::uint16:
            return quantiles_of<std::uint16_t>(volume.values);
        case Scalar::float32:
            return quantiles_of<float>(volume.values);
    }
    return {};
}

}  // namespace

glm::dvec3 spacing_mm(const Volume& volume) {
    return {glm::length(axis_mm(volume, 0)), glm::length(axis_mm(volume, 1)),
            glm::length(axis_mm(volume, 2))};
}

std::string orientation_letters(const Volume& volume) {
    std::string letters;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 direction = axis_mm(volume, axis);
        const glm::dvec3 size = glm::abs(direction);
        const int largest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        letters += direction[largest] > 0 ? "LPS"[largest] : "RAI"[largest];
    }
    return letters;
}

std::string picture_text(const Session& session) {
    const Scene& scene = session.scene;
    std::string text;
    if (const phigs::Content* archive = session.archive()) {
        text = fmt::format("scene {}, {} triangles, {} spheres, {} lines", archive->file,
                           archive->triangles, archive->spheres, archive->lines);
    } else {
        const Volume& volume = session.volume();
        const glm::dvec3 spacing = spacing_mm(volume);
        text = fmt::format("volume {} {}x{}x{} spacing {:.6g}x{:.6g}x{:.6g} mm", volume.name,
                           volume.nx, volume.ny, volume.nz, spacing.x, spacing.y, spacing.z);
    }
    text += fmt::format("; view azimuth {:.6g} elevation {:.6g} zoom {:.6g}",
                        scene.camera.angles.azimuth_deg, scene.camera.angles.elevation_deg,
                        scene.camera.zoom);
    for (const Surface& surface : scene.surfaces) {
        text += fmt::format("; surface {} isovalue {}", surface.name, surface.isovalue);
    }
    return text;
}

std::uint64_t picture_digest(const Picture& picture) {
    Digest digest;
    digest.add(std::as_bytes(std::span(picture.rgba)));
    return digest.value();
}

Reply describe_volume(const Volume& volume) {
    const glm::dvec3 spacing = spacing_mm(volume),
                     extent = spacing * glm::dvec3(volume.nx - 1, volume.ny - 1, volume.nz - 1);
    const glm::dvec3 origin(volume.voxel_to_patient[3]);
    const std::string type(scalar_names[static_cast<std::size_t>(volume.type)]);
    const std::string letters = orientation_letters(volume);
    Reply reply;
    reply.text = fmt::format(
        "{}: {} x {} x {} voxels of {}, spacing {:.4g} x {:.4g} x {:.4g} mm, {:.0f} x {:.0f} x "
        "{:.0f} mm\nvalues {} .. {}; axes point to {}, first voxel at ({:.1f}, {:.1f}, {:.1f}) mm "
        "LPS",
        volume.name, volume.nx, volume.ny, volume.nz, type, spacing.x, spacing.y, spacing.z,
        extent.x, extent.y, extent.z, volume.minimum, volume.maximum, letters, origin.x, origin.y,
        origin.z);
    const std::vector<double> shares = quantiles(volume);
    reply.text += "\nof the voxels";
    for (std::size_t i = 0; i < shares.size(); ++i) {
        reply.text += fmt::format("{} {} % are up to {:.6g}", i == 0 ? "" : ",",
                                  quantile_percent[i], shares[i]);
    }
    std::vector<Fields> notes;
    for (const Finding& finding : volume.findings) {
        reply.text += "\nnote: " + finding.text;
        notes.push_back({{"note", finding.text}});
    }
    std::vector<Fields> surfaces;
    for (const PhantomSurface& surface : suggested_surfaces(volume.name)) {
        reply.text += fmt::format("\nsurface {}: iso={}", surface.name, surface.isovalue);
        surfaces.push_back({{"name", surface.name}, {"isovalue", surface.isovalue}});
    }
    reply.fields = {
        {"name", volume.name},
        {"dims", std::vector<double>{static_cast<double>(volume.nx), static_cast<double>(volume.ny),
                                     static_cast<double>(volume.nz)}},
        {"type", type},
        {"spacing_mm", std::vector<double>{spacing.x, spacing.y, spacing.z}},
        {"origin_mm", std::vector<double>{origin.x, origin.y, origin.z}},
        {"orientation", letters},
        {"minimum", volume.minimum},
        {"maximum", volume.maximum},
        {"quantiles", shares},
        {"notes", notes},
        {"surfaces", surfaces}};
    return reply;
}

Reply describe_archive(const phigs::Content& content) {
    const glm::dvec3 &low = content.low, &high = content.high;
    Reply reply;
    reply.text = fmt::format(
        "{}: {} structures, {} posted; {} polygons ({} triangles), {} spheres, {} lines in {} "
        "colours\nfrom ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) in its own units",
        content.file, content.structures, content.posted, content.polygons, content.triangles,
        content.spheres, content.lines, content.materials.size(), low.x, low.y, low.z, high.x,
        high.y, high.z);
    std::vector<Fields> notes;
    for (const std::string& note : content.notes) {
        reply.text += "\nnote: " + note;
        notes.push_back({{"note", note}});
    }
    const auto number = [](std::size_t value) { return static_cast<std::int64_t>(value); };
    reply.fields = {{"name", content.file},
                    {"structures", number(content.structures)},
                    {"posted", number(content.posted)},
                    {"polygons", number(content.polygons)},
                    {"triangles", number(content.triangles)},
                    {"spheres", number(content.spheres)},
                    {"lines", number(content.lines)},
                    {"colours", number(content.materials.size())},
                    {"low", std::vector<double>{low.x, low.y, low.z}},
                    {"high", std::vector<double>{high.x, high.y, high.z}},
                    {"notes", notes}};
    return reply;
}

}  // namespace pxpl5::host
