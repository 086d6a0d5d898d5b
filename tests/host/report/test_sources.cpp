#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/report/sources.hpp"
#include "tests/ringbus/scratch_folder.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::report;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> names_of(const std::vector<Source>& sources) {
    std::vector<std::string> names;
    for (const Source& source : sources) {
        names.push_back(source.name);
    }
    return names;
}

RequestError refusal(const std::string& folder, const std::vector<std::string>& names) {
    try {
        sources_of(folder, names);
    } catch (const RequestError& error) {
        return error;
    }
    return {ExitCode::ok, "not refused"};
}

}  // namespace

TEST_SUITE("host/report/sources") {
    TEST_CASE("without a folder the rows are those of the phantoms") {
        const std::vector<Source> sources = sources_of("", {});
        CHECK(names_of(sources) == std::vector<std::string>{"pelvis/skin", "pelvis/muscle",
                                                            "pelvis/bone", "fetus/face",
                                                            "head/skin"});
        CHECK(sources[3].volume == "phantom:fetus");
        CHECK(sources[3].row.paper.triangles == 70'874);
    }

    TEST_CASE("rows are chosen by name, in the order of the table") {
        const std::vector<std::string> names{"head/skin", "pelvis/muscle"};
        CHECK(names_of(sources_of("", names)) ==
              std::vector<std::string>{"pelvis/muscle", "head/skin"});
    }

    TEST_CASE("a row that is not there is refused with what was probably meant") {
        const RequestError error = refusal("", {"pelvis/skim"});
        CHECK(error.code == ExitCode::usage);
        CHECK(std::string(error.what()) ==
              "no row 'pelvis/skim'; did you mean 'pelvis/skin'?; --data FOLDER adds more");
    }

    TEST_CASE("a folder that is not there, and a file missing in one, are named") {
        const pxpl5::test::ScratchFolder scratch;
        const std::string folder = (scratch / "data").string();
        RequestError error = refusal(folder, {});
        CHECK(error.code == ExitCode::bad_data);
        CHECK(std::string(error.what()) == "--data " + folder + ": there is no such folder");
        fs::create_directories(folder + "/ct");
        std::ofstream(folder + "/ct/knee_128x128x56.nrrd") << "x";
        error = refusal(folder, {});
        CHECK(error.code == ExitCode::bad_data);
        CHECK(std::string(error.what()) ==
              "--data " + folder +
                  ": 'us/spine_phantom_128x64x96.nrrd', which row us-spine/spine needs, is not "
                  "there");
        const std::vector<std::string> names{"ct-knee/bone"};
        const std::vector<Source> sources = sources_of(folder, names);
        REQUIRE(sources.size() == 1);
        CHECK(sources[0].volume == folder + "/ct/knee_128x128x56.nrrd");
        CHECK(sources[0].row.held_back);
    }
}
