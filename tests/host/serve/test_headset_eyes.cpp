// Messages of a headset: which eyes are accepted, and what the refusals say.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "host/serve/director/viewer_message.hpp"
#include "tests/host/serve/headset_words.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;
using Json = nlohmann::json;

namespace {

const Subject head{{10, -20, 30}, 120};

Json good() {
    return eyes_message(12, 17, eyes_at(head, 25), 512, 400);
}

/// The error about the message after a change of one value, by its path.
std::string said_of(const std::string& path, const Json& value) {
    Json message = good();
    message[Json::json_pointer("/eyes" + path)] = value;
    try {
        read_viewer_message(message.dump());
    } catch (const MessageError& error) {
        CHECK(error.id == 12);
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("eyes are read with every bit of their matrices") {
    const Eyes eyes = eyes_at(head, 25);
    const ViewerMessage read = read_viewer_message(good().dump());
    CHECK(read.id == 12);
    CHECK(read.is_of_headset);
    REQUIRE(read.eyes);
    CHECK(read.eyes->pose == 17);
    CHECK(read.eyes->size == Size{512, 400});
    CHECK(read.eyes->eyes.left.patient_to_eye == eyes.left.patient_to_eye);
    CHECK(read.eyes->eyes.left.projection == eyes.left.projection);
    CHECK(read.eyes->eyes.right.patient_to_eye == eyes.right.patient_to_eye);
    CHECK(read.eyes->eyes.right.projection == eyes.right.projection);
    const ViewerMessage ends = read_viewer_message(R"({"id":13,"eyes":null})");
    CHECK(ends.is_of_headset);
    CHECK(!ends.eyes);
    CHECK(read_viewer_message(R"({"eyes":null})").id == std::nullopt);
}

TEST_CASE("matrices of 32-bit floats are near enough to rotations") {
    Json message = good();
    for (const char* side : {"left", "right"}) {
        for (const char* key : {"patient_to_eye", "projection"}) {
            for (Json& element : message["eyes"][side][key]) {
                element = static_cast<double>(static_cast<float>(element.get<double>()));
            }
        }
    }
    CHECK(read_viewer_message(message.dump()).eyes);
    CHECK(said_of("/left/patient_to_eye/15", 1 + 1e-7).empty());
    CHECK(said_of("/right/projection/1", -0.0).empty());
}

TEST_CASE("eyes that are not as a headset has them are refused with element and value") {
    const std::vector<std::pair<std::pair<const char*, Json>, const char*>> cases = {
        {{"", 5}, "message: \"eyes\" is of type number, must be an object or null"},
        {{"", Json::array()}, "message: \"eyes\" is of type array, must be an object or null"},
        {{"", Json::object()}, "message: eyes.pose is missing"},
        {{"/pose", 0}, "message: eyes.pose is 0, must be a whole number from 1 to 4294967295"},
        {{"/pose", 1.5}, "message: eyes.pose is 1.5, must be"},
        {{"/pose", -1}, "message: eyes.pose is -1, must be"},
        {{"/pose", 4294967296}, "message: eyes.pose is 4294967296, must be"},
        {{"/pose", "1"}, "message: eyes.pose is string, must be"},
        {{"/size", 5}, "message: eyes.size is number, must be a list of width and height"},
        {{"/size", {512}}, "message: eyes.size is a list of 1, must be a list of width and height"},
        {{"/size/0", 15}, "message: eyes.size[0] is 15, must be a whole number from 16 to 4096"},
        {{"/size/1", 4097}, "message: eyes.size[1] is 4097, must be a whole number from 16"},
        {{"/left", nullptr}, "message: eyes.left.patient_to_eye is missing"},
        {{"/right/projection", {1, 2}},
         "message: eyes.right.projection is a list of 2 elements, must be 16 numbers"},
        {{"/right/projection", "x"}, "message: eyes.right.projection is string, must be 16"},
        {{"/left/projection/3", "x"}, "message: eyes.left.projection[3] is string, must be"},
        {{"/left/patient_to_eye/3", 0.01},
         "message: eyes.left.patient_to_eye[3] is 0.01, must be 0, because patient_to_eye is a"},
        {{"/left/patient_to_eye/15", 2}, "message: eyes.left.patient_to_eye[15] is 2, must be 1"},
        {{"/left/patient_to_eye/12", 2e6},
         "message: eyes.left.patient_to_eye[12] is 2e+06, must be from -1e+06 to 1e+06"},
        {{"/right/projection/4", 0.1},
         "message: eyes.right.projection[4] is 0.1, must be 0, because projection is an OpenGL"},
        {{"/right/projection/11", 0}, "message: eyes.right.projection[11] is 0, must be -1"},
        {{"/right/projection/11", 1}, "message: eyes.right.projection[11] is 1, must be -1"},
        {{"/right/projection/15", 1}, "message: eyes.right.projection[15] is 1, must be 0"},
        {{"/right/projection/0", 0}, "message: eyes.right.projection[0] is 0, must be from 0.01"},
        {{"/right/projection/0", -1}, "message: eyes.right.projection[0] is -1, must be from"},
        {{"/right/projection/5", 1001}, "message: eyes.right.projection[5] is 1001, must be"},
        {{"/right/projection/8", 1e300}, "message: eyes.right.projection[8] is 1e+300, must be"},
        {{"/right/projection/14", 0}, "message: eyes.right.projection has its near plane at"},
        {{"/right/projection/14", 1}, "message: eyes.right.projection has its near plane at -"},
        {{"/right/projection/10", -1}, "message: eyes.right.projection has its near plane at"},
        {{"/right/projection/10", -0.5}, "message: eyes.right.projection has its near plane at"},
        {{"/right/projection/10", 3}, "message: eyes.right.projection has its near plane at"},
        {{"/right/projection/14", -1e9}, "message: eyes.right.projection has its near plane at"},
        {{"/right/projection/14", -1e-5}, "message: eyes.right.projection has its near plane at"},
    };
    for (const auto& [change, text] : cases) {
        CAPTURE(change.first);
        CAPTURE(change.second.dump());
        CHECK(said_of(change.first, change.second).starts_with(text));
    }
}

TEST_CASE("only rotations without scale, shear and mirror place the patient before an eye") {
    const glm::dmat4 place = eyes_at(head, 25).left.patient_to_eye;
    const auto said = [&](const glm::dmat4& change) {
        return said_of("/left/patient_to_eye", elements_of(change * place));
    };
    glm::dmat4 shear(1);
    shear[1][0] = 0.01;
    const glm::dmat4 one(1);
    CHECK(said(glm::rotate(one, 2.0, glm::dvec3(0.6, 0, 0.8))).empty());
    CHECK(said(glm::scale(one, glm::dvec3(1.0004))).empty());
    CHECK(said(glm::scale(one, glm::dvec3(1.01))).find("columns 0 and 0 of the rotation have") !=
          std::string::npos);
    CHECK(said(shear).find("must have") != std::string::npos);
    CHECK(said(glm::scale(one, glm::dvec3(-1, 1, 1))).find("mirrors the patient") !=
          std::string::npos);
    CHECK(said(glm::scale(one, glm::dvec3(0))).find("the product 0, must have 1") !=
          std::string::npos);
}

TEST_CASE("eyes with another meaning, or numbers that no double has, are no message") {
    Json twice = good();
    twice["ping"] = true;
    CHECK_THROWS_WITH_AS(read_viewer_message(twice.dump()), doctest::Contains("has 2 of do"),
                         MessageError);
    std::string infinite = good().dump();
    infinite.replace(infinite.find("\"projection\":[") + 14, 1, "1e999,");
    CHECK_THROWS_WITH_AS(read_viewer_message(infinite), doctest::Contains("is no JSON object"),
                         MessageError);
}
