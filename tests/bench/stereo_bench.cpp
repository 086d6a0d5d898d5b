// Prints what two views and depths cost as JSON: samples of frames of one view and of two, without
// and with depths, and of what the server does with depths. stereo.py runs this.
//
// usage: stereo_bench TOPOLOGY SIZE,SIZE.. ROUNDS FRAMES COMMAND...
//
// COMMAND  Lines that load a volume and set its surfaces: "load phantom:pelvis", "surface bone".
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/stopwatch.hpp"
#include "host/commands/commands.hpp"
#include "host/machine/machine.hpp"
#include "host/serve/depths/lean_packing.hpp"
#include "host/serve/encoding/encode.hpp"
#include "ringbus/process/kept_memory.hpp"

using namespace pxpl5;

namespace {

constexpr int largest_px = 4096;
constexpr host::serve::JpegQuality jpeg_quality{90, true};  ///< Moving pictures on a quick link.
constexpr int warm_up_frames = 20;

struct Kind {
    const char* name;
    host::StereoMode stereo;
    host::ReadBack read_back;
    host::PairForm form = host::PairForm::composed;
};
constexpr std::array kinds = {
    Kind{"view", host::StereoMode::off, host::ReadBack::pixels},
    Kind{"view_depths", host::StereoMode::off, host::ReadBack::pixels_and_depths},
    Kind{"pair", host::StereoMode::side_by_side, host::ReadBack::pixels},
    // As the viewer gets them: two pictures.
    Kind{"pair_depths", host::StereoMode::side_by_side, host::ReadBack::pixels_and_depths,
         host::PairForm::apart},
};

double clock_ms(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

/// The clocks of the processor time of this process and of its children: the nodes.
std::vector<clockid_t> machine_clocks() {
    std::vector<clockid_t> clocks = {CLOCK_PROCESS_CPUTIME_ID};
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::ifstream children(task.path() / "children");
        for (pid_t pid = 0; children >> pid;) {
            if (clockid_t clock = 0; clock_getcpuclockid(pid, &clock) == 0) {
                clocks.push_back(clock);
            }
        }
    }
    return clocks;
}

double sum_ms(const std::vector<clockid_t>& clocks) {
    double sum = 0;
    for (const clockid_t clock : clocks) {
        sum += clock_ms(clock);
    }
    return sum;
}

/// Wall and processor time of `count` calls, in ms per call.
template <class Work>
void measure(nlohmann::json& samples, const std::string& name, int count,
             const std::vector<clockid_t>& clocks, Work work) {
    const double before_ms = sum_ms(clocks);
    const std::int64_t start_ns = host::now_ns();
    for (int i = 0; i < count; ++i) {
        work(i);
    }
    samples[name]["wall_ms"].push_back(host::ms_since(start_ns) / count);
    samples[name]["cpu_ms"].push_back((sum_ms(clocks) - before_ms) / count);
}

/// All kinds, one after the other, in each of the rounds. All draw the same views.
nlohmann::json samples_of(host::Session& session, int rounds, int frames) {
    const std::vector<clockid_t> clocks = machine_clocks();
    const std::vector<clockid_t> own = {CLOCK_THREAD_CPUTIME_ID};
    const double step_deg = 360.0 / rounds / frames;
    nlohmann::json samples;
    const auto draw = [&](const Kind& kind, int round, int index) {
        session.scene.stereo.mode = kind.stereo;
        session.scene.camera.angles.azimuth_deg = step_deg * (round * frames + index);
        return session.frames.draw_samples(1, {}, kind.read_back, kind.form).value();
    };
    for (int i = 0; i < warm_up_frames; ++i) {
        draw(kinds[static_cast<std::size_t>(i) % kinds.size()], 0, i);
    }
    std::size_t packed_bytes = 0;
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t k = 0; k < kinds.size(); ++k) {
            const Kind& kind = kinds[(k + static_cast<std::size_t>(round)) % kinds.size()];
            measure(samples, kind.name, frames, clocks, [&](int i) { draw(kind, round, i); });
        }
        const host::Picture shown = draw(kinds[1], round, 0);
        host::serve::LeanDepths lean;
        measure(samples, "lean", 1, own, [&](int) {
            lean = host::serve::lean_depths(shown.width, shown.height, shown.depths);
        });
        measure(samples, "pack", 1, own,
                [&](int) { packed_bytes += host::serve::packed(lean).size(); });
        measure(samples, "jpeg", 1, own, [&](int) {
            host::serve::jpeg_of(shown.width, shown.height, shown.rgba, jpeg_quality);
        });
    }
    samples["packed_bytes"] = packed_bytes / static_cast<std::size_t>(rounds);
    return samples;
}

int run(const std::vector<std::string>& words) {
    host::MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base =
        std::filesystem::temp_directory_path() / ("pxpl5-stereo-bench-" + std::to_string(getpid()));
    const int rounds = host::parse_whole("ROUNDS", words[2], 1);
    const int frames = host::parse_whole("FRAMES", words[3], 1);
    nlohmann::json line;
    {
        host::Machine machine(host::load_topology(words[0]), options);
        host::Session session(machine);
        for (std::size_t i = 4; i < words.size(); ++i) {
            host::run_command(session, host::parse_line(words[i]));
        }
        std::int64_t triangles = 0;
        for (const host::Surface& surface : session.scene.surfaces) {
            triangles += session.surfaces.report_of(surface.name).triangles;
        }
        line["triangles"] = triangles;
        std::istringstream sizes(words[1]);
        for (std::string size; std::getline(sizes, size, ',');) {
            session.scene.size = host::parse_size(size, 1, largest_px);
            line["sizes"][size] = samples_of(session, rounds, frames);
        }
        machine.shutdown();
    }
    std::filesystem::remove_all(options.run_base);
    fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

int main(int count, char** words) {
    bus::keep_freed_memory(32 << 20, 64 << 20);
    constexpr int least_words = 6;
    if (count < least_words) {
        fmt::print(stderr, "usage: stereo_bench TOPOLOGY SIZE,SIZE.. ROUNDS FRAMES COMMAND...\n");
        return 2;
    }
    try {
        return run({words + 1, words + count});
    } catch (const std::exception& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return 1;
    }
}
