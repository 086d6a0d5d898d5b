// The io process: decodes volumes and writes pictures, under limits, so that the host survives
// what broken files do to third-party decoders.
#include <unistd.h>

#include <clocale>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "host/base/part_file.hpp"
#include "host/io/export_requests.hpp"
#include "host/io/limits.hpp"
#include "host/io/node.hpp"
#include "host/io/survey.hpp"
#include "ringbus/process/process.hpp"

namespace {

/// The host ends a canceled export with SIGTERM.
extern "C" void end_without_parts(int signal) {
    pxpl5::host::remove_part_files();
    _exit(128 + signal);
}

}  // namespace

int main(int argc, char** argv) {
    using namespace pxpl5;
    std::vector<std::string> arguments(argv, argv + argc);
    host::io::Limits limits;
    std::vector<std::string> allowed;
    const bool confines = !host::io::take_switch(arguments, "--no-sandbox");
    try {
        limits = host::io::take_limits(arguments);
        allowed = host::io::take_allowed(arguments);
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "pxpl5-io: %s\n", error.what());
        return 64;
    }
    // Names in archives are UTF-8. The sandbox does not let the files of a locale be opened later.
    std::setlocale(LC_CTYPE, "C.UTF-8");
    // A full disk, or a file size limit, is an error of the call that writes.
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGTERM, end_without_parts);
    host::io::limit_memory(limits);
    if (arguments.size() == 2 && arguments[1] == "--one-request") {
        return host::io::serve_one_request(limits, confines);
    }
    if (const auto question = host::io::take_survey(arguments)) {
        return host::io::serve_survey(*question, {allowed, limits, confines});
    }
    std::vector<char*> rest;
    for (std::string& argument : arguments) {
        rest.push_back(argument.data());
    }
    rest.push_back(nullptr);
    return bus::run_process(
        static_cast<int>(arguments.size()), rest.data(), bus::schema::Role::io,
        [&] { return std::make_unique<host::io::IoNode>(limits, allowed, confines); });
}
