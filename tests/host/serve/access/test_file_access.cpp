// Tests which files the browser's commands may read and write.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "host/base/command_descriptor.hpp"
#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/serve/director/file_access.hpp"
#include "tests/host/serve/scratch_folder.hpp"

namespace pxpl5::host::serve {
namespace {

namespace fs = std::filesystem;

CommandDescriptor reader() {
    return {.name = "load", .help = "", .words = {{"FILE", "FILE", "", ValueType::file}}};
}

CommandDescriptor writer() {
    return {.name = "history", .help = "", .words = {{"FILE", "FILE", "", ValueType::output}}};
}

/// Why the file may not be read or written. Empty if it may.
std::string refusal(const FileAccess& access, const CommandDescriptor& command,
                    const fs::path& file) {
    try {
        access.check(command,
                     {.name = std::string(command.name), .words = {file.string()}, .options = {}});
    } catch (const RequestError& refused) {
        return refused.what();
    }
    return "";
}

bool may_read(const FileAccess& access, const fs::path& file) {
    return refusal(access, reader(), file).empty();
}

bool may_write(const FileAccess& access, const fs::path& file) {
    return refusal(access, writer(), file).empty();
}

/// A home folder with a scan, keys and a program's start-up folder.
struct Home {
    ScratchFolder scratch;
    fs::path path = scratch.path / "home";

    Home() {
        for (const char* file : {"scan.nrrd", ".hidden.nrrd", ".ssh/id", ".local/state/notes",
                                 "data/.git/config", "data/other.nrrd"}) {
            scratch.write("home/" + std::string(file), "text");
        }
        scratch.write("run/.downloads/x", "text");
    }
    FileAccess access(std::vector<fs::path> allowed) const {
        return {scratch.path / "run/.downloads", std::move(allowed)};
    }
};

}  // namespace

TEST_CASE("hidden files and folders below an allowed folder are not read") {
    const Home home;
    const FileAccess access = home.access({home.path});
    CHECK(may_read(access, home.path / "scan.nrrd"));
    CHECK(may_read(access, home.path / "data/other.nrrd"));
    CHECK(may_read(access, home.path / "data/../scan.nrrd"));
    for (const char* file : {".ssh/id", ".ssh", ".hidden.nrrd", ".local/state/notes",
                             "data/.git/config", "data/../.ssh/id", ".ssh/absent"}) {
        CAPTURE(file);
        const std::string reason = refusal(access, reader(), home.path / file);
        CHECK(reason.find("is a hidden file or in a hidden folder") != std::string::npos);
        CHECK(reason.find("--allow") != std::string::npos);
    }
}

TEST_CASE("nothing is written in hidden folders below an allowed folder") {
    const Home home;
    const FileAccess access = home.access({home.path});
    CHECK(may_write(access, home.path / "new"));
    CHECK(may_write(access, home.path / "data/new"));
    for (const char* file : {".ssh/new", ".local/state/new", "data/.git/new", "data/../.ssh/new"}) {
        CAPTURE(file);
        const std::string reason = refusal(access, writer(), home.path / file);
        CHECK(reason.find("is in a hidden folder") != std::string::npos);
        CHECK(reason.find("download:NAME") != std::string::npos);
    }
    CHECK(refusal(access, writer(), home.path / ".new").find("is a hidden file") !=
          std::string::npos);
}

TEST_CASE("links count as their targets, hidden or not") {
    const Home home;
    fs::create_symlink(home.path / ".ssh", home.path / "keys");
    fs::create_symlink(home.path / ".ssh/id", home.path / "key");
    fs::create_symlink(home.path / "data", home.path / ".data");
    const FileAccess access = home.access({home.path});
    CHECK_FALSE(may_read(access, home.path / "keys/id"));
    CHECK_FALSE(may_read(access, home.path / "key"));
    CHECK_FALSE(may_write(access, home.path / "keys/new"));
    CHECK(may_read(access, home.path / ".data/other.nrrd"));
    CHECK(may_write(access, home.path / ".data/new"));
}

TEST_CASE("a link whose target does not exist yet counts as its target") {
    const Home home;
    fs::create_directory(home.path / "outside");
    fs::create_symlink(home.path / "outside/new", home.scratch.path / "run/.downloads/link");
    const FileAccess access = home.access({home.path / "data"});
    CHECK_FALSE(may_write(access, home.scratch.path / "run/.downloads/link"));
    CHECK(may_write(access, home.scratch.path / "run/.downloads/new"));
}

TEST_CASE("the files that export writes beside a mesh are checked, too") {
    const CommandDescriptor& command = find_command("export");
    for (const char* beside : {"bone.mtl", "bone.obj.certificate.json"}) {
        CAPTURE(beside);
        const Home home;
        const FileAccess access = home.access({home.path / "data"});
        for (const fs::path& folder : {home.path / "data", home.scratch.path / "run/.downloads"}) {
            CHECK(refusal(access, command, folder / "bone.obj") == "");
            fs::create_symlink(home.path / ".ssh/id", folder / beside);
            const std::string reason = refusal(access, command, folder / "bone.obj");
            CHECK_MESSAGE(
                reason.find((folder / beside).string() + " is outside") != std::string::npos,
                reason);
            fs::remove(folder / beside);
            std::ofstream(folder / beside) << "text";
        }
        const std::string reason = refusal(access, command, home.path / "data/bone.obj");
        CHECK_MESSAGE(reason.find(std::string(beside) + " exists already") != std::string::npos,
                      reason);
        CHECK(refusal(access, command, home.scratch.path / "run/.downloads/bone.obj") == "");
        CHECK(refusal(access, writer(), home.path / "data/bone.obj") == "");
    }
    const Home home;
    const FileAccess access = home.access({home.path / "data"});
    home.scratch.write("home/data/bone.mtl", "text");
    CHECK(refusal(access, command, home.path / "data/bone.stl") == "");  // It has no colors.
}

TEST_CASE("each file that a numbered name may replace is checked") {
    const Home home;
    const FileAccess access = home.access({home.path / "data"});
    const fs::path downloads = home.scratch.path / "run/.downloads";
    std::ofstream(downloads / "turn0000.png") << "text";
    CHECK(may_write(access, downloads / "turn{}.png"));
    fs::create_symlink(home.path / ".ssh/id", downloads / "turn0001.png");
    const std::string reason = refusal(access, writer(), downloads / "turn{}.png");
    CHECK_MESSAGE(
        reason.find((downloads / "turn0001.png").string() + " is outside") != std::string::npos,
        reason);
    home.scratch.write("home/data/turn0007.png", "text");
    CHECK(refusal(access, writer(), home.path / "data/turn{}.png").find("turn0007.png exists") !=
          std::string::npos);
}

TEST_CASE("a hidden folder that was named itself is allowed, what it hides is not") {
    const Home home;
    home.scratch.write("home/.local/.deeper/file", "text");
    const FileAccess access = home.access({home.path, home.path / ".local"});
    CHECK(may_read(access, home.path / ".local/state/notes"));
    CHECK(may_write(access, home.path / ".local/state/new"));
    CHECK_FALSE(may_read(access, home.path / ".local/.deeper/file"));
    CHECK_FALSE(may_read(access, home.path / ".ssh/id"));
    // The run folder may lie in a hidden folder, as ~/.local/state does.
    CHECK(may_write(access, home.scratch.path / "run/.downloads/x"));
}

TEST_CASE("the folder of a volume is allowed if it is hidden, and a hidden volume itself") {
    const Home home;
    FileAccess in_hidden = home.access({});
    in_hidden.allow_volume((home.path / ".local/state/notes").string());
    CHECK(may_read(in_hidden, home.path / ".local/state/notes"));
    CHECK(may_write(in_hidden, home.path / ".local/state/new"));
    CHECK_FALSE(may_read(in_hidden, home.path / "scan.nrrd"));
    FileAccess hidden_file = home.access({});
    hidden_file.allow_volume((home.path / ".hidden.nrrd").string());
    CHECK(may_read(hidden_file, home.path / ".hidden.nrrd"));
    CHECK(may_read(hidden_file, home.path / "scan.nrrd"));
    CHECK_FALSE(may_read(hidden_file, home.path / ".ssh/id"));
    CHECK_FALSE(may_write(hidden_file, home.path / ".hidden.nrrd"));
}

TEST_CASE("a volume whose path cannot be resolved allows nothing") {
    const Home home;
    fs::create_symlink(home.path / "loop", home.path / "loop");
    FileAccess access = home.access({});
    access.allow_volume((home.path / "loop").string());
    CHECK_FALSE(may_read(access, home.path / "scan.nrrd"));
    CHECK_FALSE(may_read(access, "/etc/hostname"));
}

}  // namespace pxpl5::host::serve
