#include "host/timing/paper_rows.hpp"

#include <array>

namespace pxpl5::host::timing {

namespace {

constexpr PaperResult skin{41'708, 409, 20}, muscle{110'450, 676, 8}, bone{49'552, 409, 19};
constexpr PaperResult face{70'874, 357, 12}, head{269'720, 591, 3};

constexpr std::array phantom_cases = {
    PaperRow{"phantom:pelvis", "skin", 0, skin, 25, 15, false},
    PaperRow{"phantom:pelvis", "muscle", 0, muscle, 25, 15, false},
    PaperRow{"phantom:pelvis", "bone", 0, bone, 15, 15, true},
    PaperRow{"phantom:fetus", "face", 0, face, 20, 10, true},
    PaperRow{"phantom:head", "skin", 0, head, 35, 10, false},
};

constexpr std::array data_cases = {
    PaperRow{"ct/knee_128x128x56.nrrd", "skin", -519.5, skin, 25, 15, true},
    PaperRow{"ct/knee_128x128x56.nrrd", "muscle", 76.5, muscle, 25, 15, true},
    PaperRow{"ct/knee_128x128x56.nrrd", "bone", 180.5, bone, 15, 15, true},
    PaperRow{"us/spine_phantom_128x64x96.nrrd", "spine", 13.5, face, 20, 10, true},
    PaperRow{"mr/head_96x96x109.mha", "skin", 70.5, head, 35, 10, true},
};

}  // namespace

std::span<const PaperRow> paper_rows() {
    return phantom_cases;
}

std::span<const PaperRow> data_rows() {
    return data_cases;
}

}  // namespace pxpl5::host::timing
