// Recording must not show in what is recorded.
#include <doctest/doctest.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host/base/digest.hpp"
#include "host/machine/machine.hpp"
#include "host/session/session.hpp"
#include "ringbus/trace/trace_file.hpp"
#include "tests/ringbus/scratch_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using bus::trace::TraceFile;
namespace schema = bus::schema;

namespace {

Topology plan(Recording record) {
    Topology topology;
    topology.gp.count = 3;
    topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.record = record;
    return topology;
}

MachineOptions options_in(const test::ScratchFolder& folder) {
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base = folder / "run";
    return options;
}

using Results = std::vector<std::uint64_t>;

/// Meshes' digests and frames' pixels of a short run.
Results results_of(Session& session, bool with_saves) {
    const auto save = [&] {
        if (with_saves) {
            session.nodes.save_traces();
        }
    };
    Results results;
    const auto add = [&results](const Picture& picture) {
        results.insert(results.end(), picture.rgba.begin(), picture.rgba.end());
    };
    session.volumes.load("phantom:letters");
    save();
    session.scene.size = {200, 150};
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
    session.surfaces.set("inner", middle * 1.2, CaseRule::lorensen1987, {90, 120, 160});
    results.push_back(session.meshes.digest("outer"));
    results.push_back(session.meshes.digest("inner"));
    add(session.frames.draw());
    save();
    session.frames.orbit(4, [&](int, const Picture& picture, const Camera&) { add(picture); });
    save();
    session.surfaces.set("outer", middle * 0.9, CaseRule::watertight, {200, 180, 160});
    add(session.frames.draw());
    return results;
}

/// The same on a machine of its own.
Results results_with(Recording record, bool with_saves = false) {
    const test::ScratchFolder folder;
    Machine machine(plan(record), options_in(folder));
    Session session(machine);
    Results results = results_of(session, with_saves);
    machine.shutdown();
    return results;
}

std::map<std::string, int> kinds_in(const TraceFile& file) {
    std::map<std::string, int> kinds;
    for (const bus::trace::Entry& entry : file.entries()) {
        ++kinds[bus::kind_name(entry.kind())];
    }
    return kinds;
}

}  // namespace

TEST_CASE("what a machine computes is the same whether it records or not") {
    const Results off = results_with(Recording::off);
    REQUIRE(off.size() == 2 + 6 * 200 * 150);
    CHECK(results_with(Recording::flight) == off);
    CHECK(results_with(Recording::full) == off);
    CHECK(results_with(Recording::flight, true) == off);
    CHECK(results_with(Recording::full, true) == off);
}

TEST_CASE("a second run in the same place, after one without recording, records like the first") {
    const test::ScratchFolder folder;
    std::map<std::string, int> first;
    for (const Recording record : {Recording::full, Recording::off, Recording::full}) {
        Machine machine(plan(record), options_in(folder));
        Session session(machine);
        results_of(session, false);
        machine.shutdown();
        const std::filesystem::path traces = machine.run_folder() / "traces";
        if (record == Recording::off) {
            CHECK(!std::filesystem::exists(traces));
            continue;
        }
        const std::map<std::string, int> kinds = kinds_in(TraceFile(traces / "renderer-1.mcap"));
        CHECK(kinds.at("BeginFrame") == 6);
        CHECK(kinds.at("RegionPrograms") == 6 * 3);
        CHECK((first.empty() || first == kinds));
        first = kinds;
    }
}

TEST_CASE("a full recording has every message between the nodes") {
    const test::ScratchFolder folder;
    Machine machine(plan(Recording::full), options_in(folder));
    Session session(machine);
    results_of(session, false);
    machine.shutdown();
    const std::filesystem::path traces = machine.run_folder() / "traces";
    int programs = 0;
    for (const char* name : {"renderer-0.mcap", "renderer-1.mcap"}) {
        const TraceFile file(traces / name);
        CHECK(file.cut() == "");
        programs += kinds_in(file).at("RegionPrograms");
        std::map<bus::NodeId, std::uint64_t> next;
        for (const bus::trace::Entry& entry : file.entries()) {  // Nothing is missing.
            CHECK(entry.header.sequence() == next[entry.header.source()]++);
        }
    }
    CHECK(programs == 6 * 3 * 2);
    CHECK(kinds_in(TraceFile(traces / "host-0.mcap")).at("FrameDone") == 6);
    CHECK(kinds_in(TraceFile(traces / "framebuffer-0.mcap")).at("RegionPixels") == 6 * 2);
}

TEST_CASE("the GPs' traces hold each slice once, and they are the volume that the header names") {
    const test::ScratchFolder folder;
    Machine machine(plan(Recording::full), options_in(folder));
    Session session(machine);
    session.volumes.load("phantom:letters");
    machine.shutdown();
    std::map<std::uint32_t, std::vector<std::byte>> slices;
    std::uint64_t digest = 0;
    for (const char* name : {"gp-0.mcap", "gp-1.mcap", "gp-2.mcap"}) {
        const TraceFile file(machine.run_folder() / "traces" / name);
        for (const bus::trace::Entry& entry : file.entries()) {
            const bus::Message message = file.load(entry);
            if (const auto* header = message.as<schema::VolumeHeader>()) {
                CHECK(header->source()->str() == "phantom:letters");
                digest = header->digest();
            } else if (const auto* some = message.as<schema::Slices>()) {
                const auto bytes =
                    std::as_bytes(std::span(some->values()->data(), some->values()->size()));
                const std::size_t size = bytes.size() / some->slice_count();
                for (std::uint32_t n = 0; n < some->slice_count(); ++n) {
                    const auto slice = bytes.subspan(n * size, size);
                    CHECK(slices[some->first_slice() + n].empty());
                    slices[some->first_slice() + n].assign(slice.begin(), slice.end());
                }
            }
        }
    }
    CHECK(slices.size() == static_cast<std::size_t>(session.volumes.volume().nz));
    Digest whole;
    for (const auto& [z, slice] : slices) {
        whole.add(slice);
    }
    CHECK(whole.value() == digest);
}

TEST_CASE("a Renderer that is killed at work leaves a trace that is read up to the cut") {
    const test::ScratchFolder folder;
    Machine machine(plan(Recording::full), options_in(folder));
    Session session(machine);
    session.volumes.load("phantom:letters");
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
    session.frames.orbit(5, [](int, const Picture&, const Camera&) {});
    session.nodes.save_traces();  // What has come by now is in the file.
    int pid = 0;
    for (const Machine::Process& process : machine.processes()) {
        pid = process.name == "renderer-0" ? process.pid : pid;
    }
    const auto kill_it = [&](int frame, const Picture&, const Camera&) {
        if (frame == 3) {
            ::kill(pid, SIGKILL);
        }
    };
    CHECK_THROWS_AS(session.frames.orbit(100'000, kill_it), MachineError);
    const TraceFile file(machine.run_folder() / "traces" / "renderer-0.mcap");
    CHECK(!file.cut().empty());  // Between two records, or within one.
    CHECK(kinds_in(file).at("BeginFrame") >= 5);
    for (const bus::trace::Entry& entry : file.entries()) {
        CHECK(bus::kind_name(file.load(entry).kind()) == bus::kind_name(entry.kind()));
    }
}
