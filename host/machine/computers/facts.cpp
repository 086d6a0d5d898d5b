#include "host/machine/computers/facts.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sched.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "ringbus/process/process.hpp"

namespace pxpl5::host {

namespace {

std::string first_line(const char* path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// "pid:[4026531836]"
std::string name_space(const char* kind) {
    std::error_code error;
    return std::filesystem::read_symlink(fmt::format("/proc/self/ns/{}", kind), error).string();
}

std::string variable(const char* name) {
    const char* text = std::getenv(name);
    return text == nullptr ? "" : text;
}

std::string job_of_engine() {
    if (const std::string job = variable("SLURM_JOB_ID"); !job.empty()) {
        return fmt::format("slurm {}.{}", job, variable("SLURM_STEP_ID"));
    }
    if (const std::string job = variable("OMPI_COMM_WORLD_RANK"); !job.empty()) {
        return fmt::format("mpirun {}", job);
    }
    return {};
}

std::string text_of(const in_addr& address) {
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address, text.data(), text.size());
    return text.data();
}

}  // namespace

join::FactsT own_facts() {
    join::FactsT facts;
    std::array<char, HOST_NAME_MAX + 1> name{};
    gethostname(name.data(), HOST_NAME_MAX);
    // The name that Slurm knows may differ from the computer's own.
    const std::string known = variable("SLURMD_NODENAME");
    facts.name = known.empty() ? name.data() : known;
    cpu_set_t cores;
    facts.cores = static_cast<std::uint16_t>(
        sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1);
    struct sysinfo system {};
    sysinfo(&system);
    facts.memory_bytes = std::uint64_t{system.totalram} * system.mem_unit;
    facts.place = fmt::format("{} {} {} user {}", first_line("/proc/sys/kernel/random/boot_id"),
                              name_space("pid"), name_space("mnt"), getuid());
    facts.pid = static_cast<std::uint32_t>(getpid());
    facts.job = job_of_engine();
    return facts;
}

join::AskT own_question(const bus::Credentials& credentials, const std::string& name) {
    join::AskT ask;
    ask.secret_low = credentials.secret.low();
    ask.secret_high = credentials.secret.high();
    ask.build = bus::build_id();
    ask.schema_hash = bus::schema_hash();
    ask.facts = std::make_unique<join::FactsT>(own_facts());
    if (!name.empty()) {
        ask.facts->name = name;
    }
    return ask;
}

std::vector<std::string> own_addresses() {
    std::vector<std::string> addresses;
    ifaddrs* list = nullptr;
    if (getifaddrs(&list) != 0) {
        return addresses;
    }
    const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
    for (const ifaddrs* each = list; each != nullptr; each = each->ifa_next) {
        const bool is_usable = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
                               (each->ifa_flags & IFF_UP) != 0 &&
                               (each->ifa_flags & IFF_LOOPBACK) == 0;
        if (is_usable) {
            addresses.push_back(
                text_of(reinterpret_cast<const sockaddr_in*>(each->ifa_addr)->sin_addr));
        }
    }
    return addresses;
}

}  // namespace pxpl5::host
