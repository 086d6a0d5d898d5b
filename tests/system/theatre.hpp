// Fixtures for tests of the director: viewers, a machine that dies on order, and a clock.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/serve/director/director.hpp"
#include "tests/system/mortal_machine.hpp"

namespace pxpl5::test {

using namespace host;
using namespace host::serve;
using Json = nlohmann::json;

constexpr std::int64_t ns_per_ms = 1'000'000;

/// Viewers that hear all and take every frame.
class Watchers final : public Audience {
  public:
    ~Watchers() override { close(fd_); }
    int event_fd() const override { return fd_; }
    std::vector<Event> take() override {
        eventfd_t count = 0;
        eventfd_read(fd_, &count);
        if (scrolls) {
            const Json slice = {{"id", 77}, {"ask", "slice"}, {"axis", "x"}};
            events.emplace_back(Said{2, Role::watcher, slice.dump()});
        }
        return std::exchange(events, {});
    }
    void send(std::uint32_t viewer, std::string text) override {
        texts.push_back({viewer, Json::parse(text)});
    }
    void send_binary(std::uint32_t, std::string bytes) override { binaries.push_back(bytes); }
    void opened(std::string path) override { openings.push_back(std::move(path)); }
    void show(serve::Shown frame) override {
        frames.push_back(std::move(frame));
        if (on_show) {
            on_show(frames.back());
        }
    }
    void wear(std::uint32_t viewer, std::size_t pair_pixels) override {
        wearers.emplace_back(viewer, pair_pixels);
    }
    bool wants_frame() const override { return takes_frames; }
    bool wants_pair() const override { return takes_pairs; }
    LinkAdvice advice() const override { return {scale, wants_depths, pair_scale}; }

    void says(const Json& message, Role role = Role::driver, std::uint32_t viewer = 1) {
        events.emplace_back(Said{viewer, role, message.dump()});
        eventfd_write(fd_, 1);
    }
    void joins(std::uint32_t viewer) {
        events.emplace_back(Joined{viewer, Role::watcher});
        eventfd_write(fd_, 1);
    }
    void does(int id, const std::string& line) { says({{"id", id}, {"do", line}}); }
    Json reply(int id) const {
        for (const auto& [viewer, text] : texts) {
            if (text.contains("re") && text["re"] == id) {
                return text;
            }
        }
        return {};
    }
    Json last(const char* kind) const {
        for (auto text = texts.rbegin(); text != texts.rend(); ++text) {
            if (text->second.contains(kind)) {
                return text->second[kind];
            }
        }
        return {};
    }

    std::vector<Event> events;
    std::vector<std::pair<std::uint32_t, Json>> texts;
    std::vector<std::string> binaries;
    std::vector<std::string> openings;
    std::vector<serve::Shown> frames;
    std::vector<std::pair<std::uint32_t, std::size_t>> wearers;  ///< The calls of wear().
    bool takes_frames = true, takes_pairs = true;
    bool wants_depths = false;
    double scale = 1;
    double pair_scale = 1;
    bool scrolls = false;  ///< A second viewer, who asks for slices without end.
    std::function<void(const serve::Shown&)> on_show;  ///< Called for each frame; may be empty.

  private:
    int fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
};

struct Theatre {
    Watchers watchers;
    std::int64_t now_ns = 0;
    int extractions = 0, launches = 0;
    bool dies = false;
    std::function<void()> during;  ///< Called once, while the session waits for nodes.
    int failing_launches = 0;      ///< Number of launches that will fail.
    bool dies_always = false;      ///< Each further machine dies, too.
    double idle_limit_ms = 0;
    std::filesystem::path saved_session;  ///< See DirectorParts.
    std::shared_ptr<MortalMachine> machine;
    Director director{watchers, parts()};

    /// its_idle_limit_ms  See DirectorParts.
    explicit Theatre(double its_idle_limit_ms = 0, std::filesystem::path its_saved_session = {})
        : idle_limit_ms(its_idle_limit_ms), saved_session(std::move(its_saved_session)) {
        director.session().scene.overlay = false;
        director.open("size 128x96");
        director.open("load phantom:sphere");
        director.show_first_surfaces();
        watchers.events.emplace_back(Joined{1, Role::driver});
        if (idle_limit_ms == 0) {
            settle();
        } else {
            steps();  // There is always a time to come.
        }
    }
    DirectorParts parts() {
        DirectorParts parts;
        parts.topology = "simulated";
        parts.downloads = "downloads";
        parts.answer = [](Session&, std::uint32_t id, std::string_view) {
            return std::to_string(id);
        };
        parts.clock_ns = [this] { return now_ns; };
        parts.idle_limit_ms = idle_limit_ms;
        parts.saved_session = saved_session;
        parts.moving_triangles = 1000;  // Fewer than the sphere has.
        const auto launch = [this] {
            ++launches;
            if (failing_launches > 0) {
                --failing_launches;
                throw MachineError(69, "no node can be started");
            }
            dies |= dies_always;
            return Disturbance{};
        };
        Topology topology;
        topology.gp.count = 2;
        topology.renderer.count = 2;
        topology.frame_buffer.count = 1;
        topology.gp_memory_mib = 64;
        topology.seed = 5;
        const auto fate = [this] {
            return std::exchange(dies, false) ? std::optional(killed()) : std::nullopt;
        };
        machine = std::make_shared<MortalMachine>(topology, extractions, fate, during, launch);
        parts.machine = machine;
        return parts;
    }
    void steps() {
        while (director.step()) {
        }
    }
    void passes(double ms) { now_ns += static_cast<std::int64_t>(ms * ns_per_ms); }
    /// Until nothing is to do any more.
    void settle() {
        steps();
        for (double due = 0; (due = director.due_ms()) >= 0;) {
            passes(due + 1);
            steps();
        }
    }
};

}  // namespace pxpl5::test
