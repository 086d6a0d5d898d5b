// Folders of programs that live, that were killed, and that other programs remove at that time.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "host/base/kernel/locked_folder.hpp"
#include "host/base/kernel/socket_folder.hpp"
#include "host/base/state_folder.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

/// Called once, before the next lock.
std::function<void()> before_lock;  // NOLINT(cert-err58-cpp): an empty function does not throw.
bool has_no_locks = false;

/// A folder for temporary files and sockets of each test.
struct Place {
    Place() {
        setenv("TMPDIR", folder.file("").c_str(), 1);
        setenv("XDG_RUNTIME_DIR", folder.file("").c_str(), 1);
    }
    ~Place() {
        unsetenv("TMPDIR");
        unsetenv("XDG_RUNTIME_DIR");
    }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    fs::path operator/(const std::string& name) const { return folder.file(name); }
    /// A folder as mkdtemp() makes it.
    fs::path make(const std::string& name, mode_t mode = S_IRWXU) const {
        const fs::path made = *this / name;
        REQUIRE(mkdir(made.c_str(), mode) == 0);
        return made;
    }

    pxpl5::test::TemporaryFolder folder;
};

void make_old(const fs::path& folder, int minutes = 1) {
    fs::last_write_time(folder, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
}

void write(const fs::path& file, const std::string& text = "") {
    std::ofstream(file) << text;
}

/// A socket that is bound; it listens while the descriptor is open.
int serve(const fs::path& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    REQUIRE(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(listen(fd, 1) == 0);
    return fd;
}

/// A process that has made a folder, and waits until it is killed.
template <typename FolderT>
class Program {
  public:
    template <typename... Arguments>
    explicit Program(const Arguments&... arguments) {
        int ends[2];
        REQUIRE(pipe2(ends, O_CLOEXEC) == 0);
        pid_ = fork();
        if (pid_ == 0) {
            const FolderT made(arguments...);
            write(made.path() / "file", "text");
            fs::create_directory(made.path() / "inner");
            write(made.path() / "inner/file", "text");
            const std::string path = made.path();
            if (::write(ends[1], path.c_str(), path.size()) == static_cast<ssize_t>(path.size())) {
                ::close(ends[1]);
                for (;;) {
                    pause();
                }
            }
            _exit(1);
        }
        ::close(ends[1]);
        std::string text(4096, '\0');
        const ssize_t size = read(ends[0], text.data(), text.size());
        ::close(ends[0]);
        REQUIRE(size > 0);
        folder = text.substr(0, static_cast<std::size_t>(size));
    }
    ~Program() { end(); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void end() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            waitpid(std::exchange(pid_, 0), nullptr, 0);
        }
    }

    fs::path folder;

  private:
    pid_t pid_ = 0;
};

}  // namespace

/// The C library's function, with a call before.
extern "C" int flock(int file, int operation) noexcept {
    if (before_lock) {
        std::exchange(before_lock, nullptr)();
    }
    if (has_no_locks) {
        errno = ENOLCK;
        return -1;
    }
    return static_cast<int>(syscall(SYS_flock, file, operation));
}

TEST_CASE("the temporary folder of a killed program goes with the next one") {
    for (const char* name : {info_folder, class_folder}) {
        CAPTURE(name);
        const Place place;
        Program<TemporaryFolder> program{std::string(name)};
        make_old(program.folder);
        { const TemporaryFolder next(name); }
        CHECK(fs::exists(program.folder / "inner/file"));  // The program lives.
        program.end();
        { const TemporaryFolder next("pxpl5-other"); }
        CHECK(!fs::exists(program.folder));
    }
}

TEST_CASE("the temporary folder of a killed program goes with the next machine") {
    const Place place;
    Program<TemporaryFolder> program{std::string(class_folder)};
    make_old(program.folder);
    { const SocketFolder next; }
    CHECK(fs::exists(program.folder));
    program.end();
    { const SocketFolder next; }
    CHECK(!fs::exists(program.folder));
}

TEST_CASE("a folder of sockets goes if its host was killed before it had a socket") {
    const Place place;
    Program<SocketFolder> program;
    make_old(program.folder);
    { const SocketFolder next; }
    CHECK(fs::exists(program.folder / "inner/file"));  // The program lives.
    program.end();
    { const SocketFolder next; }
    CHECK(!fs::exists(program.folder));
}

TEST_CASE("a young folder of a killed program stays") {
    const Place place;
    Program<SocketFolder> program;
    program.end();
    make_old(program.folder, -60);  // Younger than the test can be slow.
    { const SocketFolder next; }
    CHECK(fs::exists(program.folder));
}

TEST_CASE("no child inherits the lock of a folder") {
    const Place place;
    const TemporaryFolder folder(info_folder);
    const std::string lock = folder.path() / temporary_lock;
    int found = 0;
    for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
        std::error_code closed;
        if (fs::read_symlink(entry.path(), closed) == lock) {
            ++found;
            CHECK(fcntl(std::stoi(entry.path().filename()), F_GETFD) == FD_CLOEXEC);
        }
    }
    CHECK(found == 1);
}

TEST_CASE("folders go with their contents at the end of the program") {
    const Place place;
    fs::path path;
    {
        const TemporaryFolder folder(info_folder);
        path = folder.path();
        CHECK((fs::status(path).permissions() & fs::perms::all) == fs::perms::owner_all);
        fs::create_directory(path / "inner");
        write(path / "inner/file");
        fs::create_symlink("nowhere", path / "link");
    }
    CHECK(!fs::exists(fs::symlink_status(path)));
}

TEST_CASE("a folder that another start removes before it has a lock is made again") {
    // As if this program had been stopped for a minute in between.
    const Place place;
    fs::path first;
    bool locks_meanwhile = false;
    SUBCASE("the other start has ended") {}
    SUBCASE("the other start has the lock") {
        locks_meanwhile = true;
    }
    int other = -1;
    before_lock = [&] {
        for (const auto& entry : fs::directory_iterator(place / "")) {
            first = entry.path();
        }
        if (locks_meanwhile) {
            other = ::open((first / temporary_lock).c_str(), O_RDWR | O_CLOEXEC);
            REQUIRE(syscall(SYS_flock, other, LOCK_EX) == 0);
        } else {
            make_old(first);
            remove_stale_temporary_folders();
        }
    };
    const TemporaryFolder folder(info_folder);
    CHECK(!first.empty());
    CHECK(fs::exists(first) == locks_meanwhile);
    CHECK(fs::exists(folder.path() / temporary_lock));
    CHECK(folder.path() != first);
    if (other >= 0) {
        ::close(other);
    }
}

TEST_CASE("a file system without locks leaves a folder that no start removes") {
    const Place place;
    has_no_locks = true;
    const TemporaryFolder folder(info_folder);
    const SocketFolder sockets;
    has_no_locks = false;
    CHECK(!fs::exists(folder.path() / temporary_lock));
    make_old(folder.path());
    make_old(sockets.path());
    { const SocketFolder next; }
    CHECK(fs::exists(folder.path()));
    CHECK(fs::exists(sockets.path()));
}

TEST_CASE("only folders of killed programs go") {
    const Place place;
    const fs::path elsewhere = place.make("elsewhere"), link = place / "pxpl5-info-dddddd";
    write(elsewhere / temporary_lock);
    write(elsewhere / "file");
    fs::create_directory_symlink(elsewhere, link);
    const fs::path without_lock = place.make("pxpl5-info-aaaaaa"),
                   other_lock = place.make("pxpl5-info-bbbbbb"),
                   linked_lock = place.make("pxpl5-info-cccccc"),
                   folder_lock = place.make("pxpl5-info-eeeeee"),
                   other_name = place.make("pxpl5-info-much-longer"),
                   foreign = place.make("pxpl5-info-ffffff");
    write(other_lock / temporary_lock, "text of the user");
    fs::create_symlink(elsewhere / temporary_lock, linked_lock / temporary_lock);
    fs::create_directory(folder_lock / temporary_lock);
    write(other_name / temporary_lock);
    write(foreign / temporary_lock);
    constexpr uid_t other = 65533;
    if (chown(foreign.c_str(), other, other) != 0) {
        MESSAGE("SKIPPED in part: only root can give a folder to another user");
        fs::remove_all(foreign);
        fs::create_directory(foreign);
    }
    write(place / "pxpl5-info-gggggg");
    for (const auto& entry : fs::directory_iterator(place / "")) {
        make_old(entry.path(), 120);
    }
    { const SocketFolder next; }
    for (const fs::path& path :
         {without_lock, other_lock, linked_lock, folder_lock, other_name, foreign, link,
          elsewhere / "file", elsewhere / temporary_lock, place / "pxpl5-info-gggggg"}) {
        CAPTURE(path);
        CHECK(fs::exists(path));
    }
}

TEST_CASE("folders of the user stay that look much like temporary ones") {
    const Place place;
    const fs::path copied_run = place.make("pxpl5-oldrun"), build = place.make("pxpl5-build1"),
                   open = place.make("pxpl5-shared", 0755), tools = place.make("pxpl5-socket");
    for (const fs::path& folder : {copied_run, build}) {
        write(folder / "lock");  // As in each run folder.
        write(folder / "manifest.json", "{}");
    }
    write(open / temporary_lock);
    write(open / "file");
    ::close(serve(tools / "host"));
    write(tools / "file");
    for (const fs::path& folder : {copied_run, build, open, tools}) {
        make_old(folder, 120);
    }
    { const SocketFolder next; }
    for (const fs::path& file :
         {copied_run / "manifest.json", build / "manifest.json", open / "file", tools / "file"}) {
        CAPTURE(file);
        CHECK(fs::exists(file));
    }
}

TEST_CASE("what lies in a folder goes - but nothing behind its links") {
    const Place place;
    const fs::path elsewhere = place.make("elsewhere"), dead = place.make("pxpl5-info-aaaaaa");
    write(elsewhere / "file");
    write(dead / temporary_lock);
    fs::create_directory_symlink(elsewhere, dead / "inner");
    make_old(dead);
    { const SocketFolder next; }
    CHECK(!fs::exists(dead));
    CHECK(fs::exists(elsewhere / "file"));
}

TEST_CASE("a folder of which a part cannot be removed keeps its lock for a later start") {
    if (geteuid() == 0) {
        MESSAGE("SKIPPED: root can remove each file");
        return;
    }
    const Place place;
    const fs::path dead = place.make("pxpl5-info-aaaaaa"), inner = dead / "inner";
    write(dead / temporary_lock);
    write(dead / "file");
    fs::create_directory(inner);
    write(inner / "file");
    fs::permissions(inner, fs::perms::owner_read | fs::perms::owner_exec);
    make_old(dead);
    { const SocketFolder next; }
    CHECK(!fs::exists(dead / "file"));
    CHECK(fs::exists(inner / "file"));
    fs::permissions(inner, fs::perms::owner_all);
    make_old(dead);
    { const SocketFolder next; }
    CHECK(!fs::exists(dead));
}

TEST_CASE("an empty folder of sockets without a lock goes after an hour") {
    const Place place;
    const fs::path old = place.make("pxpl5-aaaaaa"), young = place.make("pxpl5-bbbbbb"),
                   full = place.make("pxpl5-cccccc"), open = place.make("pxpl5-photos", 0755);
    write(full / "file");
    for (const fs::path& folder : {old, full, open}) {
        make_old(folder, 90);
    }
    make_old(young, 30);
    { const SocketFolder next; }
    CHECK(!fs::exists(old));
    CHECK(fs::exists(young));
    CHECK(fs::exists(full));
    CHECK(fs::exists(open));
}

TEST_CASE("a folder whose host listens stays also without a lock") {
    const Place place;
    for (const bool has_lock : {false, true}) {
        CAPTURE(has_lock);
        const fs::path folder = place.make("pxpl5-aaaaaa");
        const int listening = serve(folder / "host");
        if (has_lock) {
            write(folder / temporary_lock);
        }
        make_old(folder, 120);
        { const SocketFolder next; }
        CHECK(fs::exists(folder));
        ::close(listening);
        { const SocketFolder next; }
        CHECK(!fs::exists(folder));
    }
}

TEST_CASE("a folder stays whose program has locked it and does not listen") {
    const Place place;
    const SocketFolder folder;
    ::close(serve(folder.path() / "host"));
    make_old(folder.path(), 120);
    { const SocketFolder next; }
    CHECK(fs::exists(folder.path()));
}
