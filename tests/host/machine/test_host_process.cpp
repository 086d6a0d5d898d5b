// A host that is interrupted or killed, seen from outside.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5::test;

namespace {

/// The idle host as a child process, up and running.
struct HostProcess {
    HostProcess(const Bench& bench, const std::vector<std::string>& settings) {
        int out[2], err[2];
        REQUIRE(pipe(out) == 0);
        REQUIRE(pipe(err) == 0);
        pid = fork();
        if (pid == 0) {
            dup2(out[1], 1);
            dup2(err[1], 2);
            for (const int fd : {out[0], out[1], err[0], err[1]}) {
                close(fd);
            }
            std::vector<std::string> words = {PXPL5_IDLE_HOST, PXPL5_IDLE_NODES,
                                              (bench.folder / "run").string(), "one-of-each"};
            words.insert(words.end(), settings.begin(), settings.end());
            std::vector<char*> arguments;
            for (std::string& word : words) {
                arguments.push_back(word.data());
            }
            arguments.push_back(nullptr);
            execv(arguments[0], arguments.data());
            _exit(127);
        }
        close(out[1]);
        close(err[1]);
        errors = fdopen(err[0], "r");
        FILE* lines = fdopen(out[0], "r");
        char name[64];
        for (int node = 0; std::fscanf(lines, "%d %63s", &node, name) == 2;) {
            nodes.emplace_back(node);
            names.emplace_back(name);
        }
        std::fclose(lines);
    }
    ~HostProcess() { std::fclose(errors); }

    /// Waits for the host's end. Returns its exit code, or 128 + signal.
    int wait() const {
        int status = 0;
        REQUIRE(waitpid(pid, &status, 0) == pid);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::string error_text() const {
        std::string text;
        for (int c = 0; (c = std::fgetc(errors)) != EOF;) {
            text += static_cast<char>(c);
        }
        return text;
    }

    int pid = 0;
    FILE* errors = nullptr;
    std::vector<Watch> nodes;
    std::vector<std::string> names;
};

}  // namespace

TEST_CASE("Ctrl-C and SIGTERM end the host in order, with their own exit code") {
    for (const int signal : {SIGINT, SIGTERM}) {
        const Bench bench;
        const HostProcess host(bench, {"gp.count=3"});
        CHECK(host.names == std::vector<std::string>{"host", "gp-0", "gp-1", "gp-2", "renderer-0",
                                                     "framebuffer-0"});
        ::kill(host.pid, signal);
        CHECK(host.wait() == 128 + signal);
        check_all_ended(host.nodes);
        const std::string text = host.error_text();
        const std::string last =
            signal == SIGINT ? "error: interrupted by SIGINT\n" : "error: interrupted by SIGTERM\n";
        CHECK_MESSAGE(text.ends_with(last), text);
        CHECK(bench.socket_folders() == 0);
    }
}

TEST_CASE("repeated Ctrl-C ends even nodes that will not") {
    const Bench bench;
    const HostProcess host(bench, {"gp.count=2", "gp.env=PXPL5_MISBEHAVE=deaf"});
    for (int i = 0; i < 3; ++i) {
        ::kill(host.pid, SIGINT);
    }
    CHECK(host.nodes.back().ends_within(limit_ms));
    CHECK(host.wait() == 130);
    check_all_ended(host.nodes);
    const std::string text = host.error_text();
    CHECK_MESSAGE(has(text, "still running: gp-0, gp-1"), text);
    CHECK_MESSAGE(has(text, "; sending SIGKILL\nerror: interrupted by SIGINT\n"), text);
}

TEST_CASE("nothing outlives a host that is killed") {
    const Bench bench;
    const HostProcess host(bench, {"gp.count=4"});
    CHECK(host.nodes.size() == 7);
    ::kill(host.pid, SIGKILL);
    CHECK(host.wait() == 137);
    check_all_ended(host.nodes, limit_ms);
}
