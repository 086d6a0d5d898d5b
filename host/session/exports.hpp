// Pictures and meshes, written to files by the io process.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/marks.hpp"
#include "host/session/frames.hpp"
#include "host/session/meshes.hpp"

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
    double keep = 1;                    ///< Share of the triangles that decimation leaves.
    std::string description;
};

struct MeshExportReport {
    std::int64_t triangles = 0;  ///< In the file.
    std::string text;            ///< The writer's message.
};

class Exports {
  public:
    Exports(IoRequests& io, const Scene& scene, Meshes& meshes)
        : io_(io), scene_(scene), meshes_(meshes) {}

    /// Writes pictures of one size, several as one animation. Throws RequestError.
    void pictures(std::span<const Picture> pictures, const std::string& path,
                  const PictureExtras& extras);
    /// Writes the drawn components of surfaces. Throws RequestError.
    MeshExportReport mesh(const std::string& path, const MeshExport& wish);

  private:
    IoRequests& io_;
    const Scene& scene_;
    Meshes& meshes_;
};

}  // namespace pxpl5::host
