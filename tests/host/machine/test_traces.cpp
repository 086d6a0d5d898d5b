// Tests the traces of a machine of real processes.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"
#include "host/machine/machine.hpp"
#include "isa/table_hash.hpp"
#include "ringbus/process/process.hpp"
#include "ringbus/trace/trace_file.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/host/machine/idle_node.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;
namespace schema = bus::schema;
using bus::trace::TraceFile;

namespace {

/// Lets a GP answer once.
void ask(Machine& machine) {
    bool answered = false;
    machine.send(machine.gp_ids()[0], order(Order::answer));
    machine.pump([&](const bus::Message&) { answered = true; }, [&] { return answered; });
}

/// "Hello Hello Connected": each kind as often as it came, in order of first receipt.
std::map<std::string, int> kinds_in(const TraceFile& file) {
    std::map<std::string, int> kinds;
    for (const bus::trace::Entry& entry : file.entries()) {
        ++kinds[bus::kind_name(entry.kind())];
    }
    return kinds;
}

const std::vector<std::string> all_files = {"framebuffer-0.mcap", "gp-0.mcap",
                                            "gp-1.mcap",          "host-0.mcap",
                                            "renderer-0.mcap",    "renderer-1.mcap"};

std::vector<std::string> files_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

/// While it lives, files of a process do not grow.
class FullDisk {
  public:
    explicit FullDisk(int pid) : pid_(pid) {
        prlimit(pid, RLIMIT_FSIZE, nullptr, &before_);
        rlimit none = before_;
        none.rlim_cur = 1;
        prlimit(pid, RLIMIT_FSIZE, &none, nullptr);
    }
    ~FullDisk() { prlimit(pid_, RLIMIT_FSIZE, &before_, nullptr); }
    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;

  private:
    int pid_;
    rlimit before_{};
};

/// A machine that records.
struct Recorded {
    explicit Recorded(Recording record) : machine(plan(bench, record), bench.options) {}
    static const Topology& plan(Bench& bench, Recording record) {
        bench.topology.record = record;
        return bench.topology;
    }
    fs::path traces() const { return machine.run_folder() / "traces"; }
    int pid_of(const std::string& name) const {
        int pid = 0;
        for (const Machine::Process& process : machine.processes()) {
            pid = process.name == name ? process.pid : pid;
        }
        REQUIRE(pid != 0);
        return pid;
    }
    std::string end_after_killing(const std::string& name) {
        ::kill(pid_of(name), SIGKILL);
        try {
            machine.pump([](const bus::Message&) {}, [] { return false; });
        } catch (const MachineError& error) {
            return error.what();
        }
        return "no error";
    }

    Bench bench;
    Machine machine;
};

}  // namespace

TEST_SUITE("host/machine/traces") {
    TEST_CASE("a machine that records nothing says so when asked to save") {
        Recorded run(Recording::off);
        CHECK(!run.machine.is_recording());
        try {
            run.machine.save_traces();
            FAIL("nothing was thrown");
        } catch (const RequestError& error) {
            CHECK(error.code == ExitCode::usage);
            CHECK_MESSAGE(has(error.what(), "--record flight"), error.what());
        }
        CHECK(!fs::exists(run.traces()));
        run.machine.shutdown();
    }

    TEST_CASE("every node and the host save what they have received, as often as asked") {
        for (const Recording record : {Recording::flight, Recording::full}) {
            Recorded run(record);
            CHECK(run.machine.is_recording());
            ask(run.machine);
            const SavedTraces first = run.machine.save_traces();
            CHECK(first.nodes == 6);
            CHECK(first.missing.empty());
            CHECK(first.folder == run.traces().string());
            CHECK(files_in(run.traces()) == all_files);
            std::uint64_t messages = 0, bytes = 0;
            for (const std::string& name : all_files) {
                messages += TraceFile(run.traces() / name).entries().size();
                bytes += fs::file_size(run.traces() / name);
            }
            CHECK(messages == first.messages);
            CHECK(bytes == first.bytes);
            ask(run.machine);
            CHECK(run.machine.save_traces().messages > first.messages);
            const TraceFile gp(run.traces() / "gp-0.mcap");
            CHECK(kinds_in(gp) ==
                  std::map<std::string, int>{{"Topology", 1}, {"Go", 1}, {"RemoveSurface", 2}});
            ask(run.machine);  // And the machine is as well as before.
            run.machine.shutdown();
        }
    }

    TEST_CASE("a trace says who recorded it, and the host's what machine it was") {
        Recorded run(Recording::flight);
        run.machine.save_traces();
        const TraceFile renderer(run.traces() / "renderer-1.mcap"),
            host(run.traces() / "host-0.mcap");
        CHECK(renderer.info().node_name() == "renderer-1");
        CHECK(renderer.info().node == 4);
        CHECK(renderer.info().build == bus::build_id());
        CHECK(renderer.info().recording == Recording::flight);
        CHECK(host.info().node_name() == "host");
        CHECK(host.info().more.at("isa_hash") == isa::table_hash());
        CHECK(resolved_json(parse_topology(host.info().more.at("topology"), "x.json")) ==
              resolved_json(run.bench.topology));
        CHECK(kinds_in(host).at("Hello") == 5);
        const auto told = renderer.load(renderer.entries().at(0));
        REQUIRE(told.kind() == bus::Body::Topology);
        CHECK(told.as<schema::Topology>()->recording() == Recording::flight);
        run.machine.shutdown();
    }

    TEST_CASE("a flight that nobody asks for is not written") {
        Recorded run(Recording::flight);
        ask(run.machine);
        run.machine.shutdown();
        CHECK(files_in(run.traces()).empty());
    }

    TEST_CASE("a full recording is closed at the end, and holds what the host received") {
        Recorded run(Recording::full);
        ask(run.machine);
        run.machine.shutdown();
        CHECK(files_in(run.traces()) == all_files);
        for (const std::string& name : all_files) {
            CHECK_MESSAGE(TraceFile(run.traces() / name).cut() == "", name);
        }
        const TraceFile host(run.traces() / "host-0.mcap"), gp(run.traces() / "gp-0.mcap");
        CHECK(kinds_in(host) ==
              std::map<std::string, int>{{"Hello", 5}, {"Connected", 5}, {"VolumeReady", 1}});
        CHECK(kinds_in(gp).at("Shutdown") == 1);
    }

    TEST_CASE("when a node is killed the others' flights are saved, and the error says where") {
        Recorded run(Recording::flight);
        ask(run.machine);
        const std::string error = run.end_after_killing("gp-1");
        CHECK_MESSAGE(has(error, "gp-1 was killed by signal 9 (SIGKILL)"), error);
        CHECK_MESSAGE(has(error, "; traces of 5 of 6 nodes: " + run.traces().string()), error);
        std::vector<std::string> survivors = all_files;
        std::erase(survivors, "gp-1.mcap");
        CHECK(files_in(run.traces()) == survivors);
        const TraceFile gp(run.traces() / "gp-0.mcap");
        CHECK(gp.cut() == "");
        CHECK(kinds_in(gp).at("RemoveSurface") == 1);
    }

    TEST_CASE("neither a flood nor a silent node holds up the traces and the end") {
        static_assert(chatter_messages > host::max_backlog_messages);
        Recorded run(Recording::flight);
        run.machine.send(run.machine.gp_ids()[1], order(Order::hang));
        run.machine.send(run.machine.gp_ids()[0], order(Order::chatter));
        std::string error = "no error";
        try {
            run.machine.save_traces();  // The silent node never answers.
        } catch (const MachineError& failure) {
            error = failure.what();
        }
        CHECK_MESSAGE(has(error, "came from gp-0 although 16384 messages"), error);
        CHECK_MESSAGE(has(error, " of 6 nodes: " + run.traces().string()), error);
    }

    TEST_CASE("a node that has refused a message saves its trace, too") {
        Recorded run(Recording::flight);
        ask(run.machine);
        fs::path sockets;
        for (const auto& entry : fs::directory_iterator(run.bench.folder)) {
            sockets =
                entry.path().filename().string().starts_with("pxpl5-") ? entry.path() : sockets;
        }
        // A message "of the host" with a number that the node has had.
        bus::ZmqLink another({bus::host_id, schema::Role::host},
                             "ipc://" + (sockets / "another").string());
        another.add_peer(1, schema::Role::gp, "ipc://" + (sockets / "gp-0").string());
        another.send(1, order(Order::answer));
        bool has_fault = false;
        run.machine.pump(
            [&](const bus::Message& message) {
                has_fault = has_fault || message.kind() == bus::Body::Fault;
            },
            [&] { return has_fault; });
        const SavedTraces saved = run.machine.save_traces_after_fault();
        CHECK(saved.nodes == 6);
        CHECK(saved.missing.empty());
        ask(run.machine);
        run.machine.shutdown();
    }

    TEST_CASE("a node whose disk is full says so once, and works on") {
        Recorded run(Recording::full);
        const FullDisk full(run.pid_of("gp-0"));
        std::vector<std::string> faults;
        bool answered = false;
        run.machine.send(run.machine.gp_ids()[0], order(Order::answer));
        run.machine.pump(
            [&](const bus::Message& message) {
                answered = answered || message.kind() == bus::Body::VolumeReady;
                if (const auto* fault = message.as<schema::Fault>()) {
                    faults.push_back(fault->reason()->str());
                }
            },
            [&] { return answered && !faults.empty(); });
        REQUIRE(faults.size() == 1);
        CHECK_MESSAGE(has(faults[0], "recording stops: cannot write trace"), faults[0]);
        CHECK_MESSAGE(has(faults[0], "gp-0.mcap at byte "), faults[0]);
        ask(run.machine);
        const SavedTraces saved = run.machine.save_traces();
        CHECK(saved.nodes == 5);
        REQUIRE(saved.missing.size() == 1);
        CHECK_MESSAGE(has(saved.missing[0], "gp-0: cannot write trace"), saved.missing[0]);
        run.machine.shutdown();
    }

    TEST_CASE("a host whose disk is full says so once, and works on") {
        Recorded run(Recording::full);
        std::string error;
        {
            const FullDisk full(getpid());
            try {
                for (int i = 0; i < 3; ++i) {
                    run.machine.send(run.machine.gp_ids()[0], order(Order::answer));
                }
                run.machine.pump([](const bus::Message&) {}, [] { return false; });
            } catch (const RequestError& failure) {
                error = failure.what();
            }
        }
        CHECK_MESSAGE(has(error, "recording stops: cannot write trace"), error);
        CHECK_MESSAGE(has(error, "host-0.mcap at byte "), error);
        ask(run.machine);
        run.machine.shutdown();
    }

    TEST_CASE("a node that is killed while it records everything leaves what it had received") {
        Recorded run(Recording::full);
        ask(run.machine);
        run.machine.save_traces();  // So that it is known what has reached the file.
        const std::string error = run.end_after_killing("gp-0");
        CHECK_MESSAGE(has(error, "; traces of 5 of 6 nodes: "), error);
        const TraceFile killed(run.traces() / "gp-0.mcap"), other(run.traces() / "gp-1.mcap");
        CHECK_MESSAGE(has(killed.cut(), "it was not closed"), killed.cut());
        CHECK(kinds_in(killed).at("RemoveSurface") == 1);
        CHECK(other.cut() == "");
    }
}
