#include "host/machine/computers/engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

using Words = std::vector<std::string>;

constexpr std::string_view computer_word = "{computer}", join_word = "{join}";

[[noreturn]] void refuse_engine(Engine engine, const std::string& text) {
    throw RequestError(ExitCode::usage, fmt::format("engine {}: {}", enum_name(engine), text));
}

/// computer  Its name in the topology; empty: the program asks the system.
Words join_words(const JoinCommand& join, KeyWay way, const std::string& computer = {}) {
    Words words = {join.program, "join", join.addresses};
    if (!computer.empty()) {
        words.insert(words.end(), {"--name", computer});
    }
    switch (way) {
        case KeyWay::input:
            words.emplace_back("--key-stdin");
            break;
        case KeyWay::munge:
            words.insert(words.end(), {"--munge", join.key});
            break;
        case KeyWay::file:
            words.insert(words.end(), {"--key-file", join.key});
            break;
    }
    return words;
}

/// A word as a shell on the other side of ssh reads it back.
std::string quoted(const std::string& word) {
    std::string text = "'";
    for (const char letter : word) {
        text += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    }
    return text + "'";
}

std::string line_of(const Words& words) {
    Words quotes;
    for (const std::string& word : words) {
        quotes.push_back(quoted(word));
    }
    return fmt::format("exec {}", fmt::join(quotes, " "));
}

bool is_in_path(const std::string& program) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) {
            return true;
        }
    }
    return program.find('/') != std::string::npos && access(program.c_str(), X_OK) == 0;
}

void check_program(const std::string& program, Engine engine) {
    if (!is_in_path(program)) {
        refuse_engine(engine,
                      fmt::format("it needs the program {}, which is not in PATH", program));
    }
}

std::string names_of(const ClusterSettings& cluster) {
    Words names;
    for (const ComputerSlots& computer : cluster.computers) {
        names.push_back(computer.name);
    }
    return fmt::format("{}", fmt::join(names, ","));
}

EngineProcess slurm(const ClusterSettings& cluster, int count, const JoinCommand& join) {
    const std::string number = std::to_string(count);
    // One task for each computer, with all of its cores and memory, whatever the site's defaults
    // are. The end of one task does not end the others. SLURM_OVERLAP: beside other steps.
    Words words = {"srun",
                   "--quiet",
                   "--nodes=" + number,
                   "--ntasks=" + number,
                   "--cpu-bind=none",
                   "--mem=0",
                   "--kill-on-bad-exit=0",
                   "--wait=0",
                   "--unbuffered"};
    if (!cluster.computers.empty()) {
        words.push_back("--nodelist=" + names_of(cluster));
    }
    if (!cluster.lost.empty()) {
        words.push_back(fmt::format("--exclude={}", fmt::join(cluster.lost, ",")));
    }
    const Words program = join_words(join, KeyWay::munge);
    words.insert(words.end(), program.begin(), program.end());
    return {fmt::format("{}slurm", engine_prefix), words, {"SLURM_OVERLAP=1"}, true};
}

EngineProcess ssh(const std::string& computer, const JoinCommand& join) {
    return {engine_process(computer),
            {"ssh", "-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10", "--", computer,
             line_of(join_words(join, KeyWay::input, computer))},
            {}};
}

EngineProcess mpirun(const ClusterSettings& cluster, int count, const JoinCommand& join) {
    Words words = {"mpirun",  "--map-by", "ppr:1:node", "-np", std::to_string(count),
                   "--stdin", "all",      "--bind-to",  "none"};
    if (!cluster.computers.empty()) {
        words.insert(words.end(), {"--host", names_of(cluster)});
    }
    if (getuid() == 0) {
        words.emplace_back("--allow-run-as-root");
    }
    const Words program = join_words(join, KeyWay::input);
    words.insert(words.end(), program.begin(), program.end());
    return {fmt::format("{}mpirun", engine_prefix), words, {}, true};
}

/// The user's words, with {computer} and {join} replaced.
EngineProcess by_command(const Words& words, const std::string& computer, const JoinCommand& join) {
    EngineProcess process{
        computer.empty() ? fmt::format("{}command", engine_prefix) : engine_process(computer),
        {},
        {},
        computer.empty()};
    const Words program = join_words(join, KeyWay::input, computer);
    for (std::string word : words) {
        if (word == join_word) {
            process.words.insert(process.words.end(), program.begin(), program.end());
            continue;
        }
        for (std::size_t at = 0; (at = word.find(computer_word, at)) != std::string::npos;) {
            word.replace(at, computer_word.size(), computer);
            at += computer.size();
        }
        for (std::size_t at = 0; (at = word.find(join_word, at)) != std::string::npos;) {
            const std::string line = line_of(program);
            word.replace(at, join_word.size(), line);
            at += line.size();
        }
        process.words.push_back(word);
    }
    return process;
}

int slurm_computers() {
    const char* text = std::getenv("SLURM_JOB_NUM_NODES");
    return text == nullptr ? 0 : std::atoi(text);
}

}  // namespace

KeyWay key_way_of(Engine engine) {
    return engine == Engine::slurm  ? KeyWay::munge
           : engine == Engine::wait ? KeyWay::file
                                    : KeyWay::input;
}

int expected_computers(const ClusterSettings& cluster) {
    if (cluster.engine == Engine::command && cluster.command.empty()) {
        refuse_engine(cluster.engine,
                      "engine_command is empty: give its words, one by one, with "
                      "--set engine_command=WORD");
    }
    if (cluster.engine == Engine::ssh && cluster.computers.empty()) {
        refuse_engine(cluster.engine, "no computers are named: --computers n1,n2");
    }
    const bool names_all = !cluster.computers.empty() && cluster.engine != Engine::wait;
    if (cluster.wait > 0 && names_all &&
        static_cast<std::size_t>(cluster.wait) != cluster.computers.size()) {
        refuse_engine(cluster.engine,
                      fmt::format("wait is {}, but computers has {}: leave wait out", cluster.wait,
                                  cluster.computers.size()));
    }
    if (cluster.wait > 0) {
        return cluster.wait;
    }
    if (!cluster.computers.empty()) {
        return static_cast<int>(cluster.computers.size());
    }
    const int count = cluster.engine == Engine::slurm ? slurm_computers() : 0;
    if (count == 0) {
        refuse_engine(
            cluster.engine,
            fmt::format("the number of computers is unknown. Name them (--computers n1,n2) or say "
                        "how many (--set wait=2){}",
                        cluster.engine == Engine::slurm ? ", or run inside an allocation" : ""));
    }
    return count;
}

std::vector<EngineProcess> engine_processes(const ClusterSettings& cluster,
                                            const JoinCommand& join) {
    std::vector<EngineProcess> processes;
    const int count = expected_computers(cluster);
    const auto for_each_computer = [&](const auto& make) {
        for (const ComputerSlots& computer : cluster.computers) {
            processes.push_back(make(computer.name));
        }
    };
    switch (cluster.engine) {
        case Engine::local:
        case Engine::wait:
            return processes;
        case Engine::slurm:
            processes.push_back(slurm(cluster, count, join));
            break;
        case Engine::ssh:
            for_each_computer([&](const std::string& name) { return ssh(name, join); });
            break;
        case Engine::mpirun:
            processes.push_back(mpirun(cluster, count, join));
            break;
        case Engine::command: {
            const bool is_for_each = std::ranges::any_of(cluster.command, [](const auto& word) {
                return word.find(computer_word) != std::string::npos;
            });
            if (is_for_each && cluster.computers.empty()) {
                refuse_engine(cluster.engine,
                              "engine_command has {computer}, but no computers are "
                              "named: --computers n1,n2");
            }
            if (is_for_each) {
                for_each_computer([&](const std::string& name) {
                    return by_command(cluster.command, name, join);
                });
            } else {
                processes.push_back(by_command(cluster.command, "", join));
            }
            break;
        }
    }
    for (const EngineProcess& process : processes) {
        check_program(process.words.front(), cluster.engine);
    }
    return processes;
}

std::string join_line(const JoinCommand& join, KeyWay way) {
    return fmt::format("{}", fmt::join(join_words(join, way), " "));
}

}  // namespace pxpl5::host
