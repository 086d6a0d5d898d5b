#include "host/session/pictures/write_picture.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/program_folder.hpp"
#include "host/base/part_file.hpp"
#include "host/scene/marks_messages.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

constexpr double png_scale = 2;

/// A file in memory, which a child process inherits as one of its streams.
class MemoryFile {
  public:
    explicit MemoryFile(const char* name) : fd_(memfd_create(name, MFD_CLOEXEC)) {
        check(fd_ >= 0);
    }
    ~MemoryFile() { close(fd_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    int fd() const { return fd_; }
    void put(std::span<const std::uint8_t> bytes) const {
        for (std::size_t done = 0; done < bytes.size();) {
            const ssize_t wrote = write(fd_, &bytes[done], bytes.size() - done);
            check(wrote > 0);
            done += static_cast<std::size_t>(wrote);
        }
        check(lseek(fd_, 0, SEEK_SET) == 0);
    }
    std::vector<std::uint8_t> take() const {
        const off_t size = lseek(fd_, 0, SEEK_END);
        check(size >= 0);
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
        check(pread(fd_, bytes.data(), bytes.size(), 0) == size);
        return bytes;
    }

  private:
    static void check(bool good) {
        if (!good) {
            throw RequestError(
                ExitCode::failed,
                fmt::format("the request to pxpl5-io has no memory: {}", std::strerror(errno)));
        }
    }
    int fd_;
};

/// Runs `pxpl5-io --one-request` from `in` to `out`. Returns the wait status.
int run_io(const MemoryFile& in, const MemoryFile& out) {
    const std::string program = (program_folder() / "pxpl5-io").string();
    std::array<std::string, 2> words{program, "--one-request"};
    std::array<char*, 3> arguments{words[0].data(), words[1].data(), nullptr};
    posix_spawn_file_actions_t streams;
    posix_spawn_file_actions_init(&streams);
    posix_spawn_file_actions_adddup2(&streams, in.fd(), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&streams, out.fd(), STDOUT_FILENO);
    pid_t pid = 0;
    const int failure =
        posix_spawn(&pid, program.c_str(), &streams, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&streams);
    if (failure != 0) {
        throw RequestError(ExitCode::unavailable, fmt::format("pxpl5-io cannot start: {}: {}",
                                                              program, std::strerror(failure)));
    }
    int status = 0;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

/// Sends the request and returns the answer.
schema::IoDoneT answer_to(const std::string& path, const schema::ExportPictureT& request) {
    const MemoryFile in("request"), out("answer");
    in.put(bus::pack(request).bytes());
    const int status = run_io(in, out);
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("{}: pxpl5-io was ended by its sandbox; the line above names "
                        "the system call, which a library of this system may need. "
                        "Please report it",
                        path));
    }
    if (WIFSIGNALED(status)) {
        throw RequestError(ExitCode::failed, fmt::format("{}: pxpl5-io was killed by signal {}",
                                                         path, WTERMSIG(status)));
    }
    if (WEXITSTATUS(status) != 0) {
        throw RequestError(ExitCode::failed, fmt::format("{}: pxpl5-io ended with exit code {}",
                                                         path, WEXITSTATUS(status)));
    }
    const std::vector<std::uint8_t> bytes = out.take();
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(bus::Body::IoDone), bus::host_id,
                                bus::host_id, 0, 0, 0, bytes.size(), 0, 0, 0);
    schema::IoDoneT done;
    bus::Message(header, bytes, nullptr).as<schema::IoDone>()->UnPackTo(&done);
    return done;
}

}  // namespace

void check_picture_suffix(const std::string& option, const std::string& path) {
    const std::string suffix = suffix_of(path);
    if (suffix != ".png" && suffix != ".svg" && suffix != ".pdf") {
        throw RequestError(
            ExitCode::usage,
            fmt::format("{} {}: suffix is '{}', must be .png, .svg or .pdf", option, path, suffix));
    }
}

void write_picture(const std::string& path, const WrittenPicture& picture) {
    schema::ExportPictureT request;
    request.path = path;
    request.width = static_cast<std::uint32_t>(picture.size.width);
    request.height = static_cast<std::uint32_t>(picture.size.height);
    request.description = picture.description;
    request.marks = marks_message(picture.marks);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.rgba.data());
    request.rgba.assign(bytes, bytes + picture.rgba.size_bytes());
    if (const schema::IoDoneT done = answer_to(path, request); !done.ok) {
        throw RequestError(ExitCode::failed, done.error);
    }
}

void write_chart(const std::string& path, const Chart& chart, const std::string& description) {
    const Chart drawn = suffix_of(path) == ".png" ? scaled(chart, png_scale) : chart;
    const Size size{static_cast<int>(std::ceil(drawn.width)),
                    static_cast<int>(std::ceil(drawn.height))};
    const std::vector<std::uint32_t> paper(
        static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), 0xffff'ffffU);
    write_picture(path, {size, paper, drawn.marks, description});
}

}  // namespace pxpl5::host
