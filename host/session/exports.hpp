// Pictures and meshes, written to files by the io process.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/marks.hpp"
#include "host/session/frames.hpp"
#include "host/session/meshes.hpp"
#include "host/surface/export/mesh_smooth.hpp"
#include "host/surface/patient_mesh.hpp"

namespace pxpl5::host {

/// The contents of a picture's file besides its pixels.
struct PictureExtras {
    std::string description;
    std::vector<std::pair<std::string, std::string>> attributes;  ///< Word and value.
    std::vector<PictureMark> marks;                               ///< Drawn over the picture.
    int delay_ms = 40;  ///< Between the pictures of an animation.
};

/// Options of a mesh file.
struct MeshExport {
    std::vector<std::string> surfaces;  ///< By name; empty for all visible ones.
    bool ras = false;                   ///< Axes to the right, anterior, superior instead of LPS.
    /// Share of the triangles that decimation leaves; 0: as few as error_mm allows.
    double keep = 1;
    double error_mm = 0;  ///< Above 0: decimation stops at this distance.
    int smoothing = 0;    ///< Passes of smooth_mesh().
    bool cap = false;     ///< Closes the mesh at the scan's border and clip planes.
    int detail = 0;       ///< 0: exact, else simplified without the options above.
    std::string description;
};

/// A surface of a file, in millimeters.
struct FileSurface {
    std::string name;
    WeldedFile file;
    std::int64_t vertices = 0;            ///< In the file, which may have several at one place.
    std::optional<double> moved_mm = {};  ///< Largest move by decimation; nothing if keep is 1.
    std::int64_t components_before = 0;   ///< Before decimation; 0 if keep is 1.
    std::optional<Smoothing> smoothing = {};
    /// If the surface is simplified: no point is farther from the exact surface.
    std::optional<double> within_mm = {};
};

struct MeshExportReport {
    std::int64_t triangles = 0;         ///< In the file.
    std::string text;                   ///< The writer's message.
    std::vector<FileSurface> surfaces;  ///< Contents of the file, in LPS.
    std::vector<std::string> empty;     ///< Surfaces without triangles, not in the file.
};

class Exports {
  public:
    Exports(IoRequests& io, const Scene& scene, Meshes& meshes)
        : io_(io), scene_(scene), meshes_(meshes) {}

    /// Writes pictures of one size, several as one animation. Throws RequestError.
    void pictures(std::span<const Picture> pictures, const std::string& path,
                  const PictureExtras& extras);
    /// Writes the drawn components of surfaces, cut by the clip planes. Throws RequestError.
    MeshExportReport mesh(const std::string& path, const MeshExport& wish);
    /// All triangles of a mesh file, along the file's axes. Throws RequestError.
    WeldedFile read_mesh(const std::string& path);

  private:
    struct ReadyMesh {
        SimplifiedMesh simplified;
        std::optional<Smoothing> smoothing;
    };
    /// The drawn part of the surface, smoothed, cut and closed, in millimeters.
    ReadyMesh ready_for_file(const Surface& surface, const MeshExport& wish);

    IoRequests& io_;
    const Scene& scene_;
    Meshes& meshes_;
};

}  // namespace pxpl5::host
