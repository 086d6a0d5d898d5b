// Tests the file browser's lists: what they show, and that nothing leads out of the allowed
// folders.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/serve/director/folder_list.hpp"
#include "tests/host/serve/scratch_folder.hpp"

namespace pxpl5::host::serve {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Scans in an allowed folder, and secrets outside of it.
struct Shelf {
    ScratchFolder scratch;
    fs::path scans = scratch.path / "scans";
    FileAccess access{scratch.path / "run/downloads", {scans}, {scratch.path / "run/uploads"}};

    Shelf() {
        for (const char* file :
             {"scans/knee10.nrrd", "scans/knee9.nrrd", "scans/IM0001", "scans/notes.txt",
              "scans/.secret.nrrd", "scans/ct/a.dcm", "scans/.cache/x.nrrd", "outside/other.nrrd",
              "run/uploads/u.nrrd", "run/downloads/d.nrrd"}) {
            scratch.write(file, "12345");
        }
        // Folders are allowed as they are when the server starts.
        access =
            FileAccess(scratch.path / "run/downloads", {scans}, {scratch.path / "run/uploads"});
    }
    Json list(const Json& more) const {
        Json ask = {{"id", 1}, {"ask", "folder"}};
        ask.update(more);
        return Json::parse(list_folder(access, ask.dump()));
    }
    Json list(const fs::path& folder) const { return list({{"path", folder.string()}}); }
    std::string refusal(const Json& more) const {
        try {
            list(more);
        } catch (const RequestError& error) {
            return error.what();
        }
        return "";
    }
};

std::vector<std::string> names(const Json& list) {
    std::vector<std::string> names;
    for (const Json& entry : list["entries"]) {
        names.push_back(entry["name"]);
    }
    return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a list has folders, then volumes, by name and number, and counts the other files") {
    const Shelf shelf;
    const Json list = shelf.list(shelf.scans);
    CHECK(names(list) == Names{"ct", "IM0001", "knee9.nrrd", "knee10.nrrd"});
    CHECK(list["other_files"] == 1);
    CHECK(list["above"] == "");
    const Json& knee = list["entries"][2];
    CHECK(knee["kind"] == "NRRD");
    CHECK(knee["bytes"] == 5);
    CHECK(knee["path"] == (fs::canonical(shelf.scans) / "knee9.nrrd").string());
    CHECK(knee["modified_s"].get<std::int64_t>() > 1'600'000'000);
    CHECK(list["entries"][0]["bytes"].is_null());
    CHECK(shelf.list(shelf.scans / "ct")["above"] == fs::canonical(shelf.scans).string());
}

TEST_CASE("all files are listed, names are searched, hidden ones stay hidden") {
    const Shelf shelf;
    const std::string path = shelf.scans.string();
    CHECK(names(shelf.list({{"path", path}, {"all", true}})) ==
          Names{"ct", "IM0001", "knee9.nrrd", "knee10.nrrd", "notes.txt"});
    CHECK(names(shelf.list({{"path", path}, {"find", "KNEE"}})) ==
          Names{"knee9.nrrd", "knee10.nrrd"});
    CHECK(names(shelf.list({{"path", path}, {"find", "secret"}, {"all", true}})).empty());
}

TEST_CASE("the empty path lists the user's folders without those of the program") {
    const Shelf shelf;
    CHECK(names(shelf.list(fs::path())) == Names{fs::canonical(shelf.scans).string()});
    FileAccess nested(shelf.scratch.path / "run/downloads", {shelf.scans / "ct", shelf.scans});
    nested.allow_volume((shelf.scratch.path / "outside/other.nrrd").string());
    CHECK(nested.roots() == std::vector<fs::path>{fs::canonical(shelf.scans),
                                                  fs::canonical(shelf.scratch.path / "outside")});
}

TEST_CASE("dots, links and hidden folders do not lead out of the allowed folders") {
    const Shelf shelf;
    fs::create_directory_symlink(shelf.scratch.path / "outside", shelf.scans / "way-out");
    fs::create_symlink(shelf.scratch.path / "outside/other.nrrd", shelf.scans / "file-out.nrrd");
    fs::create_directory_symlink(shelf.scans / ".cache", shelf.scans / "to-hidden");
    fs::create_directory_symlink(shelf.scans / "ct", shelf.scans / "way-in");
    const Json list = shelf.list(shelf.scans);
    CHECK(names(list) == Names{"ct", "way-in", "IM0001", "knee9.nrrd", "knee10.nrrd"});
    CHECK(list["links_out"] == 3);
    CHECK(names(shelf.list(shelf.scans / "way-in")) == Names{"a.dcm"});
    for (const fs::path& path :
         {shelf.scans / "..", shelf.scans / "../outside", shelf.scans / "way-out",
          shelf.scans / "way-out/..", shelf.scans / "ct/../../outside", fs::path("/"),
          shelf.scratch.path, fs::path("/etc"), shelf.scans / "way-out/other.nrrd"}) {
        CAPTURE(path);
        const std::string reason = shelf.refusal({{"path", path.string()}});
        CHECK(reason.find("is outside of the folders") != std::string::npos);
        CHECK(reason.find("--allow DIR") != std::string::npos);
    }
    for (const char* hidden : {".cache", "to-hidden", "ct/../.cache"}) {
        CAPTURE(hidden);
        CHECK(shelf.refusal({{"path", (shelf.scans / hidden).string()}}).find("hidden folder") !=
              std::string::npos);
    }
    CHECK(names(shelf.list(shelf.scans / "ct/..")).size() == 5);
}

TEST_CASE("a long folder gives the first entries by name and counts the rest") {
    const Shelf shelf;
    for (std::size_t i = 0; i < max_listed + 7; ++i) {
        shelf.scratch.write("scans/long/" + std::to_string(i) + ".dcm", "");
    }
    const Json list = shelf.list(shelf.scans / "long");
    CHECK(list["entries"].size() == max_listed);
    CHECK(list["more"] == 7);
    CHECK(list["entries"].back()["name"] == std::to_string(max_listed - 1) + ".dcm");
    const Json found = shelf.list({{"path", (shelf.scans / "long").string()}, {"find", "506"}});
    CHECK(names(found) == Names{"506.dcm"});
}

TEST_CASE("names that are no text, and what is neither folder nor file, are left out") {
    const Shelf shelf;
    shelf.scratch.write("scans/odd/b\xff.dcm", "");
    shelf.scratch.write("scans/odd/<b>&.dcm", "");
    fs::create_symlink(shelf.scans / "odd/loop.dcm", shelf.scans / "odd/loop.dcm");
    const Json list = shelf.list(shelf.scans / "odd");
    CHECK(names(list) == Names{"<b>&.dcm"});
    CHECK(list["odd_names"] == 1);
}

TEST_CASE("questions that are none are refused with what is wrong") {
    const Shelf shelf;
    CHECK(shelf.refusal(Json::object()).find("'path' must be") != std::string::npos);
    CHECK(shelf.refusal({{"path", 3}}).find("'path' must be") != std::string::npos);
    CHECK(shelf.refusal({{"path", std::string("a\0b", 3)}}).find("code 0") != std::string::npos);
    CHECK(shelf.refusal({{"path", ""}, {"find", 3}}).find("'find' must be") != std::string::npos);
    CHECK(shelf.refusal({{"path", ""}, {"all", 1}}).find("'all' must be") != std::string::npos);
    const std::string file = (shelf.scans / "IM0001").string();
    CHECK(shelf.refusal({{"path", file}}).find(file + " is no folder") != std::string::npos);
    const std::string gone = (shelf.scans / "gone").string();
    CHECK(shelf.refusal({{"path", gone}}).find(gone + " is no folder: No such") !=
          std::string::npos);
    CHECK(asks_for_folder(R"({"id":1,"ask":"folder"})"));
    CHECK_FALSE(asks_for_folder(R"({"id":1,"ask":"slice"})"));
    CHECK_FALSE(asks_for_folder("[]"));
}

}  // namespace pxpl5::host::serve
