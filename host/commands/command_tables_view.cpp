// Rows of commands about the view, the style of pictures, and pixels.
#include <array>

#include "host/commands/command_handlers.hpp"
#include "host/commands/command_tables.hpp"

namespace pxpl5::host {

namespace {

constexpr std::array<std::string_view, 1> planes_off = {"off"};
constexpr Words gaps_off = {"gaps", "off"};

constexpr double min_eyes_mm = 0.001, max_eyes_mm = 100'000;
constexpr std::array<std::string_view, 6> stereo_modes{"off",   "anaglyph", "sbs",
                                                       "cross", "rows",     "headset"};

constexpr Parameter x_word{"X", "X", "pixel from the left of the picture"};
constexpr Parameter y_word{"Y", "Y", "pixel from the top of the picture"};

}  // namespace

std::vector<Command> view_commands() {
    return {
        {{.name = "view",
          .help = "Places the viewer. Azimuth 90 is the patient's left. A named view sets roll and "
                  "pan to 0.",
          .words = {{"VIEW", "VIEW|AZ", "named view, or azimuth in degrees"},
                    {"EL", "EL", "elevation in degrees"}},
          .options = {number_value("zoom", "Z", min_zoom, max_zoom, "magnification"),
                      number_value("roll", "DEG", -max_angle_deg, max_angle_deg,
                                   "counter-clockwise turn of the picture", "degrees"),
                      {"pan", "X,Y", "shift of the picture right and up (mm)"},
                      choice_value("fit", yes_no,
                                   "zoom and pan that show all visible surfaces whole", "no")},
          .forms = "[anterior|posterior|left|right|superior|inferior|AZ EL]",
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_view},
        {{.name = "light",
          .help = "Sets directional light N relative to the viewer; without words, lists the "
                  "lights. An arrangement replaces all: two-point, as at the start, or "
                  "three-point, with a light from behind that shows the edges.",
          .words = {{"N", "N|two-point|three-point|off",
                     "number of the light; an arrangement; off for all"},
                    {"AZ", "AZ|off", "azimuth in degrees, or off"},
                    {"EL", "EL", "elevation in degrees"}},
          .options = {number_value("intensity", "I", 0, 4, "brightness")},
          .forms = "[N AZ EL | N off | two-point | three-point | off]",
          .kind = CommandKind::setting,
          .subject_words = 1,
          .stage = RenderStage::look},
         run_light},
        {{.name = "clip",
          .help = "Cuts the scene; without words, lists the cuts. The letter names the side that "
                  "is kept, from MM or the center on. MM counts towards the letter: 'S 20' keeps "
                  "what lies above z = 20 mm, 'I -20' what lies below. A plane replaces an "
                  "earlier plane with its letter, a box replaces a box. 'flip' keeps the other "
                  "side of a plane.",
          .words = {{"SIDE", "L|R|P|A|S|I|box|off", "side to keep"},
                    {"PLACE", "MM|I,J,K|flip|off", "place, or first voxel of a box"},
                    {"LAST", "I,J,K", "last voxel of a box"}},
          .forms = "[L|R|P|A|S|I [MM|flip] | box I,J,K I,J,K | L|R|P|A|S|I|box off | off]",
          .kind = CommandKind::setting,
          .subject_words = 1,
          .stage = RenderStage::scene},
         run_clip},
        {{.name = "planes",
          .help = "Shows slices of the volume beside the surfaces, with their gray values and "
                  "without light; without options, lists the slices. Each of x, y and z is the "
                  "number of a slice across this voxel axis, from 0, or off. Cuts apply to slices, "
                  "too. Where slices of the scan are missing, values are interpolated.",
          .words = {choice_value("OFF", planes_off, "no slices")},
          .options = {{"x", "I|off", "slice across x"},
                      {"y", "I|off", "slice across y"},
                      {"z", "I|off", "slice across z"},
                      number_value("window", "W", 1e-12, 1e12, "width of the gray window"),
                      number_value("level", "L", -1e12, 1e12, "center of the gray window")},
          .forms = "[off]",
          .kind = CommandKind::setting,
          .stage = RenderStage::scene},
         run_planes},
        {{.name = "size",
          .help = "Sets the size of pictures.",
          .words = {{"SIZE", "WIDTHxHEIGHT", "size in pixels"}},
          .required = 1,
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_size},
    };
}

std::vector<Command> style_commands() {
    return {
        {{.name = "material",
          .help = "Sets how surfaces reflect light.",
          .options = {number_value("ambient", "A", 0, 1, "share of ambient light"),
                      number_value("specular", "S", 0, 1, "share of mirrored light"),
                      number_value("power", "P", 1, 128, "sharpness of highlights")},
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_material},
        {{.name = "background",
          .help = "Sets the color behind the surfaces.",
          .words = {{"COLOR", "COLOR", "#rrggbb, r,g,b or a name", ValueType::color}},
          .required = 1,
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_background},
        {{.name = "tint",
          .help = "Tints surfaces where slices are missing.",
          .words = {choice_value("WHERE", gaps_off, "")},
          .required = 1,
          .options = {{"color", "C", "#rrggbb, r,g,b or a name", ValueType::color}},
          .kind = CommandKind::setting,
          .stage = RenderStage::scene},
         run_tint},
    };
}

std::vector<Command> drawing_commands() {
    return {
        {{.name = "antialias",
          .help = "Sets the number of samples per pixel. Edges are smooth with 4 or 16 samples.",
          .words = {{"SAMPLES", "1|4|16", ""}},
          .required = 1,
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_antialias},
        {{.name = "detail",
          .help = "Draws surfaces with fewer triangles; without a word, prints the choice. N "
                  "clusters vertices in cells of 2, 4 or 8 voxels a side, in all pictures. 'auto' "
                  "does so in the viewer's moving pictures if they have more than 2 million "
                  "triangles; resting pictures and all files are then exact. Several GPs need sets "
                  "of 16 slices: start pxpl5 with --set gp.slabs_per_set=16 for volumes within "
                  "the paper's limits.",
          .words = {{"DETAIL", "exact|auto|1|2|3", ""}},
          .forms = "[exact|auto|1|2|3]",
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_detail},
        {{.name = "stereo",
          .help = "Draws each picture for both eyes; without a word, prints the choice. 'anaglyph' "
                  "is for red and cyan glasses, 'sbs' has the left eye's picture at the left, "
                  "'cross' at the right, 'rows' is for 3-D monitors with alternate rows. "
                  "'headset' says how to look with a headset, and changes nothing. 'size' is that "
                  "of one eye's picture. Pixels of pick, measure and why are those of the "
                  "whole picture; of an anaglyph they mean the left eye.",
          .words = {choice_value("MODE", stereo_modes, "")},
          .options = {number_value("separation", "MM", min_eyes_mm, max_eyes_mm,
                                   "distance between the eyes; 0.035 of the camera's distance, "
                                   "divided by the zoom, by default",
                                   "mm"),
                      number_value("convergence", "MM", min_eyes_mm, max_eyes_mm,
                                   "distance from the eyes to what appears at the screen; the "
                                   "center of the volume by default",
                                   "mm")},
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_stereo},
        {{.name = "overlay",
          .help = "Shows or hides side letters, scale bar and legend in written pictures.",
          .words = {choice_value("SWITCH", on_off, "")},
          .required = 1,
          .kind = CommandKind::setting,
          .stage = RenderStage::look},
         run_overlay},
    };
}

std::vector<Command> pixel_commands() {
    return {
        {{.name = "pick",
          .help = "Prints the surface points at a pixel. Chooses the nearest point of an opaque "
                  "surface, else the nearest point, and prints its voxel. set= makes the value "
                  "there the isovalue of a surface. part=yes adds the component with its volume.",
          .words = {x_word, y_word},
          .required = 2,
          .options = {{"surface", "NAME", "surface to choose"},
                      {"set", "NAME", "surface to set"},
                      choice_value("part", yes_no, "whether to measure the component there",
                                   "no")}},
         run_pick},
        {{.name = "measure",
          .help = "Prints the straight-line distance between two ends. An end is the surface point "
                  "at pixel X Y, chosen as pick chooses it, or the place X,Y,Z in mm LPS.",
          .words = {{"X1", "X1", ""}, {"Y1", "Y1", ""}, {"X2", "X2", ""}, {"Y2", "Y2", ""}},
          .required = 2,
          .options = {{"from", "NAME", "surface of the first point"},
                      {"to", "NAME", "surface of the second point"}},
          .forms = "X,Y,Z|X Y X,Y,Z|X Y"},
         run_measure},
        {{.name = "why",
          .help =
              "Explains the color of a pixel down to the voxels. Draws the scene once, with one "
              "sample at the pixel's center, and executes the region of the pixel again. Pixels "
              "of the screen door show one surface of several; pick lists them all.",
          .words = {x_word, y_word},
          .required = 2},
         run_why},
    };
}

}  // namespace pxpl5::host
