#include "host/machine/computers/cluster_settings.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/machine/topology_file.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_slots = 4096;
constexpr std::size_t max_name_length = 253;

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

/// "n1,n2:8" as computers with their slots.
std::vector<ComputerSlots> computers_of(std::string_view key, std::string_view text) {
    std::vector<ComputerSlots> computers;
    for (const std::string& word : words_of(text)) {
        const std::size_t colon = std::min(word.find(':'), word.size());
        computers.push_back(
            {word.substr(0, colon),
             colon == word.size() ? 0 : parse_whole(key, word.substr(colon + 1), 0, max_slots)});
    }
    return computers;
}

bool is_name(std::string_view text) {
    return !text.empty() && text.size() <= max_name_length && text.front() != '-' &&
           text.find_first_not_of(
               "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
               ".-_@") == std::string_view::npos;
}

}  // namespace

std::vector<std::string> words_of(std::string_view text) {
    std::vector<std::string> words;
    while (!text.empty()) {
        const std::size_t comma = std::min(text.find(','), text.size());
        words.emplace_back(text.substr(0, comma));
        text.remove_prefix(std::min(comma + 1, text.size()));
    }
    return words;
}

void set_listen(ClusterSettings& cluster, std::string_view text) {
    constexpr int max_port = 65535;
    const std::size_t colon = std::min(text.rfind(':'), text.size());
    cluster.listen = text.substr(0, colon);
    cluster.listen_port =
        colon == text.size() ? 0 : parse_whole("listen", text.substr(colon + 1), 1, max_port);
}

std::string listen_text(const ClusterSettings& cluster) {
    return cluster.listen_port == 0 ? cluster.listen
                                    : fmt::format("{}:{}", cluster.listen, cluster.listen_port);
}

bool set_cluster_value(ClusterSettings& cluster, std::string_view key, std::string_view value) {
    if (key == "engine") {
        cluster.engine = value_named<Engine>(key, value);
    } else if (key == "engine_command") {
        cluster.command.emplace_back(value);
    } else if (key == "computers") {
        cluster.computers = computers_of(key, value);
    } else if (key == "placement") {
        cluster.placement = value_named<Placement>(key, value);
    } else if (key == "listen") {
        set_listen(cluster, value);
    } else {
        return false;
    }
    return true;
}

std::string problem_of_name(std::string_view name) {
    if (is_name(name)) {
        return {};
    }
    return fmt::format(
        "a name has letters, digits and .-_@, does not begin with - and has at most {} characters",
        max_name_length);
}

void check_names(const std::vector<std::string>& names, const std::string& where,
                 std::string_view key) {
    for (const std::string& name : names) {
        if (const std::string problem = problem_of_name(name); !problem.empty()) {
            refuse(fmt::format("{}: {} names '{}'; {}", where, key, name, problem));
        }
    }
}

void check_ipv4(const std::string& what, const std::string& text) {
    in_addr address{};
    if (inet_pton(AF_INET, text.c_str(), &address) != 1) {
        refuse(fmt::format("{} is '{}', must be an IPv4 address such as 10.0.0.1", what, text));
    }
}

void check_cluster(const ClusterSettings& cluster, const std::string& where) {
    if (!cluster.listen.empty()) {
        check_ipv4(where + ": listen", cluster.listen);
    }
    std::vector<std::string> names;
    for (const ComputerSlots& computer : cluster.computers) {
        names.push_back(computer.name);
        if (computer.slots < 0 || computer.slots > max_slots) {
            refuse(fmt::format("{}: {} has {} slots, must be 0..{}", where, computer.name,
                               computer.slots, max_slots));
        }
    }
    check_names(names, where, "computers");
    if (names.size() > max_computers) {
        refuse(fmt::format("{}: computers has {}, at most {}", where, names.size(), max_computers));
    }
}

void check_trust(const ClusterSettings& cluster, const std::string& file,
                 const std::vector<std::string>& overrides) {
    const std::string allowed = "engine=" + std::string(enum_name(cluster.engine));
    if (cluster.is_used() && std::ranges::find(overrides, allowed) == overrides.end()) {
        refuse(
            fmt::format("{}: engine is {}, which runs programs on other computers and sends "
                        "them the volume. If you trust this file, repeat with --engine {}",
                        file, enum_name(cluster.engine), enum_name(cluster.engine)));
    }
}

}  // namespace pxpl5::host
