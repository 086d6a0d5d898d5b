#include "host/base/kernel/program_folder.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"

namespace pxpl5::host {

std::filesystem::path program_folder() {
    constexpr const char* link = "/proc/self/exe";
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink(link, error);
    if (error) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("cannot find pxpl5-gp and the other programs, which are beside this one: "
                        "{}: {}. Run it where /proc is mounted",
                        link, error.message()));
    }
    return program.parent_path();
}

}  // namespace pxpl5::host
