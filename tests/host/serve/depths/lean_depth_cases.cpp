// Prints lean depths and the bytes that a viewer gets, one JSON object per picture, for the test of
// the page's decoder. Usage: test_lean_depth_cases SEED
#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host/serve/depths/lean_packing.hpp"
#include "tests/host/serve/depths/depth_pictures.hpp"

int main(int count, char** words) {
    using namespace pxpl5::host::serve;
    if (count != 2) {
        fmt::print(stderr, "usage: {} SEED\n", words[0]);
        return 2;
    }
    for (const test::DepthPicture& picture :
         test::depth_pictures(std::strtoull(words[1], nullptr, 0))) {
        const LeanDepths lean = lean_depths(picture.width, picture.height, picture.depths);
        const std::string bytes = packed(lean);
        nlohmann::json seams = nlohmann::json::array();
        for (const Seam& seam : lean.seams) {
            seams.push_back({{"cell", seam.cell},
                             {"near_pixels", seam.near_pixels},
                             {"near", seam.near},
                             {"far", seam.far}});
        }
        const nlohmann::json line = {
            {"name", picture.name},
            {"width", lean.width},
            {"height", lean.height},
            {"columns", lean.columns},
            {"rows", lean.rows},
            {"corners", lean.corners},
            {"mask", lean.mask},
            {"seams", seams},
            {"packed", std::vector<std::uint8_t>(bytes.begin(), bytes.end())}};
        fmt::print("{}\n", line.dump());
    }
    return 0;
}
