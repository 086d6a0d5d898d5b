// The results that the paper states, and the volumes that stand for its own.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace pxpl5::host::timing {

/// Values of a surface in a caption of the paper.
/// Source  Yoo & Chen, figures 3 to 7: 36 GPs, 16 Renderers.
struct PaperResult {
    std::int64_t triangles = 0;
    double built_ms = 0;  ///< From the isovalue to the surface.
    double frames_per_s = 0;
};

/// A surface that stands for one of the paper's: about as many voxels and triangles.
struct PaperRow {
    std::string_view volume;   ///< "phantom:pelvis", or a file's path in a data folder.
    std::string_view surface;  ///< Phantoms: name of the suggested surface.
    double isovalue = 0;       ///< Files only; a phantom suggests a value.
    PaperResult paper;
    double azimuth_deg = 0, elevation_deg = 0;  ///< Ours: the paper's views are not stated.
    bool held_back = false;                     ///< Not used to fit the machine's parameters.
};

/// Every picture of the model is of this size: the machine's whole screen. The paper states none.
inline constexpr std::uint32_t paper_width = 1280, paper_height = 1024;

/// The five results, on phantoms.
std::span<const PaperRow> paper_rows();

/// The five results, on measured volumes with loads like the paper's; all held back.
std::span<const PaperRow> data_rows();

}  // namespace pxpl5::host::timing
