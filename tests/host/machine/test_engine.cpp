#include "host/machine/computers/engine.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include "host/base/error.hpp"
#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/computers/lost_computers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

const JoinCommand join{"/opt/it's here/pxpl5", "tcp://10.0.0.1:4711", "CREDENTIAL"};

ClusterSettings cluster_of(const std::vector<std::string>& overrides) {
    return load_topology("one-of-each", overrides).cluster;
}

std::string error_of(const std::vector<std::string>& overrides) {
    try {
        engine_processes(cluster_of(overrides), join);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("engine: the words of `command` reach the program as they are, {join} as several") {
    const auto processes =
        engine_processes(cluster_of({"engine_command=env", "engine_command=at={computer}",
                                     "engine_command={join}", "computers=n1,n2", "engine=command"}),
                         join);
    REQUIRE(processes.size() == 2);
    CHECK(processes[1].name == "engine-n2");
    CHECK(processes[1].words == std::vector<std::string>{"env", "at=n2", "/opt/it's here/pxpl5",
                                                         "join", "tcp://10.0.0.1:4711", "--name",
                                                         "n2", "--key-stdin"});
}

TEST_CASE("engine: a word with {join} in it has a line for a shell") {
    const auto processes =
        engine_processes(cluster_of({"engine_command=sh", "engine_command=-c",
                                     "engine_command=nice {join}", "wait=1", "engine=command"}),
                         join);
    REQUIRE(processes.size() == 1);
    CHECK(processes[0].words.back() ==
          "nice exec '/opt/it'\\''s here/pxpl5' 'join' 'tcp://10.0.0.1:4711' '--key-stdin'");
}

TEST_CASE("engine: no key is among the arguments, but a munge credential may be") {
    CHECK(key_way_of(Engine::ssh) == KeyWay::input);
    CHECK(key_way_of(Engine::mpirun) == KeyWay::input);
    CHECK(key_way_of(Engine::command) == KeyWay::input);
    CHECK(key_way_of(Engine::slurm) == KeyWay::munge);
    CHECK(key_way_of(Engine::wait) == KeyWay::file);
    CHECK(join_line(join, KeyWay::input).find("CREDENTIAL") == std::string::npos);
    CHECK(join_line(join, KeyWay::munge) ==
          "/opt/it's here/pxpl5 join tcp://10.0.0.1:4711 --munge CREDENTIAL");
}

TEST_CASE("engine: an unknown number of computers is an error with the remedy") {
    unsetenv("SLURM_JOB_NUM_NODES");
    CHECK(error_of({"engine=slurm"}) ==
          "engine slurm: the number of computers is unknown. Name them (--computers n1,n2) or say "
          "how many (--set wait=2), or run inside an allocation");
    CHECK(error_of({"engine=ssh"}) == "engine ssh: no computers are named: --computers n1,n2");
    CHECK(error_of({"engine=command"}).starts_with("engine command: engine_command is empty"));
    CHECK(error_of({"engine=command", "engine_command=no-such-program", "wait=1"}) ==
          "engine command: it needs the program no-such-program, which is not in PATH");
}

TEST_CASE("engine: numbers and names that contradict each other are refused") {
    CHECK(error_of({"engine=ssh", "computers=n1,n2,n3", "wait=2"}) ==
          "engine ssh: wait is 2, but computers has 3: leave wait out");
    CHECK(
        error_of({"engine=command", "engine_command=env", "engine_command=A={computer}", "wait=1"})
            .starts_with("engine command: engine_command has {computer}, but no computers"));
    CHECK_THROWS_AS(cluster_of({"listen=eth0"}), RequestError);
    CHECK(cluster_of({"listen=10.0.0.1"}).listen == "10.0.0.1");
}

TEST_CASE("engine: the port for computers may be given with the address") {
    const ClusterSettings both = cluster_of({"listen=10.0.0.1:5755"});
    CHECK(both.listen == "10.0.0.1");
    CHECK(both.listen_port == 5755);
    CHECK(cluster_of({"listen=:5755"}).listen.empty());
    CHECK(cluster_of({"listen=:5755"}).listen_port == 5755);
    CHECK(cluster_of({"listen=10.0.0.1:5755", "listen=10.0.0.2"}).listen_port == 0);
    for (const char* text : {"10.0.0.1:", "10.0.0.1:0", "10.0.0.1:65536", "10.0.0.1:x", "eth0:1"}) {
        CAPTURE(text);
        CHECK_THROWS_AS(cluster_of({fmt::format("listen={}", text)}), RequestError);
    }
}

TEST_CASE("engine: inside an allocation, Slurm knows the number of computers") {
    setenv("SLURM_JOB_NUM_NODES", "3", 1);
    CHECK(expected_computers(cluster_of({"engine=slurm"})) == 3);
    CHECK(expected_computers(cluster_of({"engine=slurm", "wait=2"})) == 2);
    unsetenv("SLURM_JOB_NUM_NODES");
}

TEST_CASE("engine: names of computers that are options of other programs are refused") {
    for (const char* name : {"-oProxyCommand=x", "n1;ls", "n 1", ""}) {
        CAPTURE(name);
        CHECK_THROWS_AS(cluster_of({fmt::format("computers=n0,{}:1", name)}), RequestError);
    }
    const ClusterSettings cluster = cluster_of({"computers=user@n1.example.org:4,10.0.0.2"});
    REQUIRE(cluster.computers.size() == 2);
    CHECK(cluster.computers[0].name == "user@n1.example.org");
    CHECK(cluster.computers[0].slots == 4);
    CHECK(cluster.computers[1].slots == 0);
}

TEST_CASE("engine: what reaches the words of another program is checked to be a name") {
    for (const char* name : {"-oProxyCommand=x", "a/b", "a;b", ""}) {
        CAPTURE(name);
        CHECK_FALSE(problem_of_name(name).empty());
        CHECK_THROWS_AS(check_names({name}, "computers", "use"), RequestError);
    }
    CHECK(problem_of_name("user@n1.example.org").empty());
}

TEST_CASE("engine: a computer that is called like an engine has a log of its own") {
    const auto processes =
        engine_processes(cluster_of({"engine_command=env", "engine_command=at={computer}",
                                     "computers=command,n1", "engine=command"}),
                         join);
    REQUIRE(processes.size() == 2);
    CHECK(processes[0].name == "engine-command+");
    CHECK(processes[1].name == engine_process("n1"));
}

TEST_CASE("engine: a file alone cannot run a program") {
    const std::string text = R"({roles: {gp: {count: 1}, renderer: {count: 1}},
                                 engine: "command", engine_command: ["touch", "x"], wait: 1})";
    try {
        parse_topology(text, "from-a-stranger.json");
        FAIL("accepted");
    } catch (const RequestError& error) {
        CHECK(std::string(error.what()) ==
              "from-a-stranger.json: engine is command, which runs programs on other computers and "
              "sends them the volume. If you trust this file, repeat with --engine command");
    }
    // Every engine sends the key and the volume to the computers that the file names.
    const std::string ssh = R"({roles: {gp: {count: 1}, renderer: {count: 1}}, engine: "ssh",
                                computers: [{name: "x@evil"}]})";
    CHECK_THROWS_AS(parse_topology(ssh, "from-a-stranger.json"), RequestError);
    CHECK(parse_topology(text, "mine.json", {"engine=command"}).cluster.engine == Engine::command);
}

TEST_CASE("engine: the resolved plan has the computers") {
    const Topology plan = load_topology(
        "one-of-each", {"computers=n1:4,n2", "gp.computer=n2", "placement=spread", "wait=2",
                        "listen=10.0.0.1:5755", "compress_below_mb_s=7", "engine=ssh"});
    const Topology again = parse_topology(resolved_json(plan), "again.json", {"engine=ssh"});
    CHECK(resolved_json(again) == resolved_json(plan));
    CHECK(again.cluster.computers.size() == 2);
    CHECK(again.gp.computer == std::vector<std::string>{"n2"});
    CHECK(listen_text(again.cluster) == "10.0.0.1:5755");
    CHECK(again.cluster.compress_below_mb_s == 7);
}

namespace {

using Names = std::vector<std::string>;

/// The words of the only process of the engine.
Names words_without(const Topology& plan) {
    const auto processes = engine_processes(plan.cluster, join);
    REQUIRE(processes.size() == 1);
    return processes[0].words;
}

}  // namespace

TEST_CASE("lost computers: the engine starts the others, and nodes lose their place") {
    Topology plan = load_topology(
        "one-of-each", {"engine=command", "engine_command=env", "engine_command={computer}",
                        "computers=n1,n2,n3", "gp.computer=n2,n3", "renderer.computer=n2"});
    CHECK(leave_out(plan, {"n2", "n9", "n2"}) == Names{"n2"});
    const auto processes = engine_processes(plan.cluster, join);
    REQUIRE(processes.size() == 2);
    CHECK(processes[0].name == "engine-n1");
    CHECK(processes[1].name == "engine-n3");
    CHECK(plan.gp.computer == Names{"n3"});
    CHECK(plan.renderer.computer.empty());
    CHECK(leave_out(plan, {"n2"}).empty());
    CHECK(leave_out(plan, {"n1"}) == Names{"n1"});
    CHECK(expected_computers(plan.cluster) == 1);
    // The last one is asked again.
    CHECK(leave_out(plan, {"n3"}).empty());
    CHECK(expected_computers(plan.cluster) == 1);
}

TEST_CASE("lost computers: without names, fewer are awaited") {
    Topology plan = load_topology("one-of-each", {"engine=wait", "wait=3"});
    CHECK(leave_out(plan, {"n2"}) == Names{"n2"});
    CHECK(expected_computers(plan.cluster) == 2);
    CHECK(leave_out(plan, {"n2"}).empty());
    CHECK(leave_out(plan, {"n1", "n3"}).empty());
    CHECK(expected_computers(plan.cluster) == 2);
}

TEST_CASE("lost computers: Slurm is told which computer it must not use") {
    Topology plan =
        load_topology("one-of-each", {"engine=command", "engine_command=env", "wait=3"});
    plan.cluster.engine = Engine::slurm;
    CHECK(leave_out(plan, {"n2"}) == Names{"n2"});
    try {
        const Names words = words_without(plan);
        CHECK(std::ranges::count(words, "--exclude=n2") == 1);
        CHECK(std::ranges::count(words, "--nodes=2") == 1);
    } catch (const RequestError& error) {  // srun is not installed.
        CHECK(std::string(error.what()).find("srun") != std::string::npos);
    }
}
