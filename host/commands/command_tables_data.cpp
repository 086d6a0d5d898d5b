// Rows of commands about volumes, surfaces and meshes.
#include <array>

#include "generated/vocabulary.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/command_tables.hpp"
#include "host/commands/load_options.hpp"
#include "host/scene/slab.hpp"
#include "host/surface/atlas/histogram.hpp"

namespace pxpl5::host {

namespace {

constexpr Words part_choices = {"all", "largest"};
constexpr std::array<std::string_view, 1> off_choice = {"off"};
constexpr std::array<std::string_view, 3> axis_choices = {"x", "y", "z"};
constexpr std::array<std::string_view, 5> mesh_suffixes = {".stl", ".ply", ".obj", ".vtp", ".glb"};

constexpr std::array<std::string_view, 6> curve_suffixes = {".csv",  ".png", ".tif",
                                                            ".tiff", ".svg", ".pdf"};

constexpr Parameter surface_word{"NAME", "NAME", "name of a surface"};

constexpr Parameter window_option =
    number_value("window", "W", 1e-12, 1e12, "width of the gray window");
constexpr Parameter level_option =
    number_value("level", "L", -1e12, 1e12, "center of the gray window");

std::vector<Parameter> info_options() {
    std::vector<Parameter> options = load_option_list();
    options.push_back({"digest", "HEX", "refuse a volume whose voxels have another digest"});
    options.push_back(
        {"place", "HEX", "refuse a volume whose number of voxels or place has another digest"});
    return options;
}

}  // namespace

std::vector<Command> volume_commands() {
    return {
        {{.name = "load",
          .help = "Reads a volume or a PPHIGS archive and sends it to the GPs. Crops, smooths and "
                  "resamples the volume, in this order.",
          .words = {{"SOURCE", "FILE|FOLDER|phantom:NAME|SCENE.phigs", "", ValueType::file}},
          .required = 1,
          .options = load_option_list(),
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::load},
         run_load},
        {{.name = "info",
          .help = "Prints the geometry, values and warnings of the loaded volume or of another.",
          .words = {{"VOLUME", "VOLUME", "file, folder or phantom:NAME", ValueType::file}},
          .options = info_options()},
         run_info},
        {{.name = "atlas",
          .help = "Measures the surfaces of many isovalues and finds plateaus; draws a chart into "
                  "FILE.",
          .words = {output_value("FILE", picture_suffixes, "chart to write")},
          .options = {number_value("from", "V", -max_float, max_float, "lowest isovalue"),
                      number_value("to", "V", -max_float, max_float, "highest isovalue"),
                      whole_value("steps", "N", 2, 4096, "number of isovalues", "256")},
          .is_long = true,
          .stage = RenderStage::output},
         run_atlas},
        {{.name = "histogram",
          .help = "Counts the voxels in each range of values.",
          .words = {whole_value("BINS", "BINS", 1, max_histogram_bins, "number of ranges", "256")}},
         run_histogram},
    };
}

std::vector<Command> series_commands() {
    return {
        {{.name = "time",
          .help = "Shows another volume of a time series, with the same surfaces and clip planes; "
                  "without a word, prints which one is shown. next and previous go on at the "
                  "other end.",
          .words = {{"WHICH", "N|next|previous", ""}},
          .options = {number_value("at", "MS", 0, max_frame_ms,
                                   "show the volume nearest to this time after the first", "ms")},
          .forms = "[N|next|previous]",
          .kind = CommandKind::setting},
         run_time},
        {{.name = "curve",
          .help = "Measures all surfaces in each volume of a time series; writes the curves into "
                  "FILE as a table or a chart. The ejection fraction is (largest - least) / "
                  "largest volume.",
          .words = {output_value("FILE", curve_suffixes, "table or chart to write")},
          .options = {first_volume, last_volume},
          .is_long = true,
          .stage = RenderStage::output},
         run_curve},
    };
}

std::vector<Command> slice_commands() {
    return {
        {{.name = "slice",
          .help = "Reports the orientation of a slice perpendicular to a voxel axis; writes it to "
                  "FILE with the contours of visible surfaces.",
          .words = {choice_value("AXIS", axis_choices, "voxel axis"),
                    {"INDEX", "INDEX", "number of the slice, from 0"},
                    output_value("FILE", picture_suffixes, "picture to write")},
          .required = 2,
          .options = {window_option, level_option,
                      number_value("slab", "MM", 0, max_place_mm,
                                   "show a slab of this thickness around the slice; its contours "
                                   "are those of the slice"),
                      choice_value("kind", slab_kinds,
                                   "mean, maximum (MIP) or minimum of the voxels of the slab",
                                   "max")},
          .stage = RenderStage::output},
         run_slice},
        {{.name = "oblique",
          .help = "Reports a slice along any plane; writes it to FILE with the contours of visible "
                  "surfaces. Values are interpolated between voxels.",
          .words =
              {number_value("TILT", "TILT", -max_angle_deg, max_angle_deg,
                            "turn from axial, 0, to coronal, 90: superior comes to the top", "deg"),
               number_value("TURN", "TURN", -max_angle_deg, max_angle_deg,
                            "then turn about the picture's vertical axis; after a tilt of 90, 90 "
                            "is sagittal",
                            "deg"),
               output_value("FILE", picture_suffixes, "picture to write")},
          .required = 2,
          .options = {{"at", "X,Y,Z", "place in the plane, mm LPS; by default the volume's middle"},
                      window_option,
                      level_option},
          .stage = RenderStage::output},
         run_oblique},
    };
}

std::vector<Command> surface_commands() {
    return {
        {{.name = "surface",
          .help = "Adds a surface, or changes its isovalue or its style.",
          .words = {surface_word},
          .required = 1,
          .options = {number_value("iso", "V", -max_float, max_float, "isovalue"),
                      {"preset", "TISSUE", "isovalue and color of a tissue; see 'presets'"},
                      {"color", "C", "#rrggbb, r,g,b or a name", ValueType::color},
                      number_value("opacity", "SHARE", 0.01, 1, "drawn with a stipple mask"),
                      number_value("rim", "LIGHT", 0, 1, "light at the edges, in steps of 1/16"),
                      choice_value("visible", yes_no, "whether the surface is drawn", "yes"),
                      choice_value("table", enum_names<CaseRule>, "marching-cubes table",
                                   enum_names<CaseRule>[0])},
          .kind = CommandKind::setting,
          .subject_words = 1,
          .stage = RenderStage::scene},
         run_surface},
        {{.name = "presets", .help = "Lists the CT tissues for preset=."}, run_presets},
        {{.name = "components",
          .help = "Lists the connected components of a surface, or selects the components to draw "
                  "by one option. A cavity is drawn with the component around it.",
          .words = {surface_word},
          .required = 1,
          .options = {choice_value("show", part_choices, "draw all or the largest component"),
                      number_value("min_mm2", "A", 0, 1e12, "smallest area to draw", "mm²"),
                      number_value("min_ml", "V", 0, 1e9, "smallest volume to draw", "ml"),
                      {"at", "X,Y", "draw the component at a pixel of the picture"},
                      {"at_mm", "X,Y,Z", "draw the component nearest to a point in mm, LPS"},
                      choice_value("cavities", yes_no,
                                   "whether the selected components keep their cavities; 'no' "
                                   "fills them",
                                   "yes")},
          .kind = CommandKind::setting,
          .subject_words = 1,
          .is_long = true,
          .stage = RenderStage::scene},
         run_components},
        {{.name = "remove",
          .help = "Removes a surface.",
          .words = {surface_word},
          .required = 1,
          .kind = CommandKind::action},
         run_remove},
    };
}

std::vector<Command> mesh_commands() {
    return {
        {{.name = "certificate",
          .help = "Reports whether surfaces are closed, manifold and oriented, with measures and "
                  "defects. Also reads mesh files, of other programs too; vertices at one place "
                  "are one vertex there.",
          .words = {{"NAME", "NAME|FILE",
                     "name of a surface, or an STL, PLY, OBJ, VTP or GLB file"}},
          .is_long = true},
         run_certificate},
        {{.name = "compare",
          .help = "Draws only the cells where watertight and lorensen1987 differ, until 'compare "
                  "NAME off'.",
          .words = {surface_word, choice_value("off", off_choice, "ends the comparison")},
          .required = 1,
          .kind = CommandKind::action,
          .is_long = true},
         run_compare},
        {{.name = "export",
          .help = "Writes surfaces as a mesh in millimeters, cut by the clip planes, and the "
                  "certificate of the mesh as FILE.certificate.json beside it.",
          .words = {output_value("FILE", mesh_suffixes, "mesh to write")},
          .required = 1,
          .options = {{"surfaces",
                       "A,B",
                       "surfaces to write",
                       ValueType::text,
                       0,
                       0,
                       {},
                       "all visible surfaces"},
                      choice_value("axes", enum_names<PatientAxes>, "patient axes", "LPS"),
                      number_value("keep", "SHARE", 1e-4, 1,
                                   "share of the triangles to keep; less than 1 decimates"),
                      number_value("error", "MM", 0, max_error_mm,
                                   "decimate so that no vertex is farther from the new surface; "
                                   "without keep=, as far as that allows",
                                   "mm"),
                      whole_value("smoothing", "N", 0, max_smoothing,
                                  "passes that smooth the surface and change its volume little",
                                  "0"),
                      choice_value("cap", yes_no,
                                   "close the mesh at the scan's border and at clip planes", "no"),
                      number_value("detail", "N", 0, max_detail,
                                   "0 exact; 1, 2, 3: simplified in cells of 2, 4, 8 voxels a "
                                   "side; excludes keep=, error=, smoothing= and cap=yes")},
          .kind = CommandKind::action,
          .is_long = true,
          .stage = RenderStage::output,
          .files_beside = files_beside_mesh},
         run_export},
    };
}

}  // namespace pxpl5::host
