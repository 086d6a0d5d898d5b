#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "host/serve/server/routes.hpp"
#include "tests/host/serve/scratch_folder.hpp"

namespace pxpl5::host::serve {
namespace {

/// A page with a folder, downloads beside the page, and a file that must not be served.
struct Folders {
    ScratchFolder scratch;
    RouteFolders folders{scratch.path / "page", scratch.path / "bundle", scratch.path / "out"};

    Folders() {
        scratch.write("page/index.html", "page");
        scratch.write("page/main.js", "code");
        scratch.write("page/panels/slice.js", "code");
        scratch.write("page/panels/notes.md", "notes");
        scratch.write("code/other.js", "no");
        scratch.write("page/README.md", "notes");
        scratch.write("bundle/index.html", "page");
        scratch.write("bundle/main.js", "code");
        scratch.write("bundle/main.js.map", "map");
        scratch.write("out/mesh.ply", "mesh");
        scratch.write("out/.hidden", "no");
        scratch.write("secret", "no");
        std::filesystem::create_symlink(scratch.path / "secret", scratch.path / "out/link.ply");
        std::filesystem::create_symlink(scratch.path / "secret", scratch.path / "page/link.js");
        std::filesystem::create_symlink(scratch.path / "secret",
                                        scratch.path / "page/panels/link.js");
        std::filesystem::create_directory_symlink(scratch.path / "code",
                                                  scratch.path / "page/linked");
    }
};

}  // namespace

TEST_CASE("the files of page, bundle and downloads have their paths and types") {
    const Folders at;
    const Routes routes(at.folders);
    CHECK(routes.find("/").file.path == at.folders.bundle / "index.html");
    CHECK(routes.find("/").file.is_page);
    CHECK(routes.find("/index.html").file.is_page);
    CHECK_FALSE(routes.find("/main.js").file.is_page);
    CHECK(routes.find("/main.js").file.path == at.folders.bundle / "main.js");
    CHECK(routes.find("/main.js").file.is_bundled);
    CHECK(routes.find("/main.js.map").file.type == "application/json");
    CHECK(routes.find("/").file.type == "text/html; charset=utf-8");
    CHECK(routes.find("/main.js").file.type == "text/javascript; charset=utf-8");
    CHECK(routes.find("/panels/slice.js").file.path == at.folders.page / "panels/slice.js");
    CHECK_FALSE(routes.find("/panels/slice.js").file.is_bundled);
    const Route mesh = routes.find("/download/mesh.ply");
    CHECK(mesh.file.path == at.folders.downloads / "mesh.ply");
    CHECK(mesh.file.attachment == "mesh.ply");
    CHECK(routes.find("/socket").kind == RouteKind::socket);
    CHECK(routes.find("/upload").kind == RouteKind::upload);
    CHECK(routes.find("/upload/done").kind == RouteKind::upload_done);
}

TEST_CASE("no path leads to another file") {
    const Folders at;
    const Routes routes(at.folders);
    for (const char* path : {"",
                             "/secret",
                             "/../secret",
                             "//secret",
                             "/./main.js",
                             "/README.md",
                             "/link.js",
                             "main.js",
                             "/panels",
                             "/panels/",
                             "/panels/../main.js",
                             "/panels/../../secret",
                             "/panels/./slice.js",
                             "/panels//slice.js",
                             "/panels\\slice.js",
                             "/panels/slice.js/",
                             "/panels/notes.md",
                             "/panels/link.js",
                             "/linked/other.js",
                             "/slice.js",
                             "/download/",
                             "/download/..",
                             "/download/../secret",
                             "/download/.hidden",
                             "/download/link.ply",
                             "/download/a\\b",
                             "/download//secret",
                             "/download",
                             "/download/nothing",
                             "/index.html/",
                             "/upload/"}) {
        CAPTURE(path);
        CHECK(routes.find(path).kind == RouteKind::none);
    }
    CHECK(routes.find(std::string_view("/download/mesh.ply\0x", 20)).kind == RouteKind::none);
}

TEST_CASE("the prefix of a portal ends with the port") {
    const Folders at;
    const Routes routes(at.folders);
    CHECK(routes.find("/main.js", 4711).kind == RouteKind::file);
    CHECK(routes.find("/node/n1/4711/", 4711).file.path == at.folders.bundle / "index.html");
    CHECK(routes.find("/node/n1/4711/main.js", 4711).kind == RouteKind::file);
    CHECK(routes.find("/user/ada/proxy/absolute/4711/socket", 4711).kind == RouteKind::socket);
    CHECK(routes.find("/4711/upload", 4711).kind == RouteKind::upload);
    CHECK(routes.find("/node/47110/4711/main.js", 4711).kind == RouteKind::file);
    CHECK(routes.find("/node/n1/4711", 4711).kind == RouteKind::slash);
    for (const char* path : {"/node/n1/4712/main.js", "/node/n1/main.js", "/node/n1/4711main.js",
                             "/node/n1/4711/../secret", "/node/n1/4711//main.js",
                             "/node/n1/4711/secret", "/node/n1/47110/main.js", "/4711x"}) {
        CAPTURE(path);
        CHECK(routes.find(path, 4711).kind == RouteKind::none);
    }
}

TEST_CASE("a download may be called as the port") {
    const Folders at;
    at.scratch.write("out/4711", "mesh");
    CHECK(Routes(at.folders).find("/download/4711", 4711).kind == RouteKind::file);
}

TEST_CASE("a file that is missing at start is named") {
    const Folders at;
    RouteFolders folders = at.folders;
    folders.bundle = "/nowhere";
    CHECK_THROWS_WITH_AS(Routes{folders}, doctest::Contains("/nowhere is missing"), RequestError);
    folders.bundle.clear();
    CHECK(Routes(folders).find("/main.js").file.path == at.folders.page / "main.js");
    std::filesystem::remove(at.folders.page / "index.html");
    CHECK_THROWS_WITH_AS(Routes{at.folders}, doctest::Contains("index.html is missing"),
                         RequestError);
    folders.page = "/nowhere";
    CHECK_THROWS_WITH_AS(Routes{folders}, doctest::Contains("/nowhere is missing"), RequestError);
}

}  // namespace pxpl5::host::serve
