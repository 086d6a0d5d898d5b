// The director on a simulated machine, before viewers whose every word and clock tick is the
// test's.
#include <doctest/doctest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <set>

#include "host/error.hpp"
#include "host/picture_text.hpp"
#include "host/serve/director.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using Json = nlohmann::json;

namespace {

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
    void show(serve::Shown frame) override {
        frames.push_back(std::move(frame));
        if (on_show) {
            on_show(frames.back());
        }
    }
    bool wants_frame() const override { return takes_frames; }
    LinkAdvice advice() const override { return {}; }

    void says(const Json& message, Role role = Role::driver) {
        events.emplace_back(Said{1, role, message.dump()});
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
    std::vector<serve::Shown> frames;
    bool takes_frames = true;
    bool scrolls = false;  ///< A second viewer, who asks for slices without end.
    std::function<void(const serve::Shown&)> on_show;  ///< What viewers do about it; may be empty.

  private:
    int fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
};

/// A machine that dies when the test says so.
class MortalMachine final : public MachinePort {
  public:
    MortalMachine(const Topology& topology, int& extractions, bool& dies)
        : inside_(topology), extractions_(extractions), dies_(dies) {}

    const std::vector<bus::NodeId>& gp_ids() const override { return inside_.gp_ids(); }
    const std::vector<bus::NodeId>& renderer_ids() const override { return inside_.renderer_ids(); }
    void send(bus::NodeId to, bus::Payload payload) override {
        inside_.send(to, std::move(payload));
    }
    bool takes_more(bus::NodeId to) const override { return inside_.takes_more(to); }
    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override {
        if (std::exchange(dies_, false)) {
            throw MachineError(137, "gp-1 was killed by signal 9 (SIGKILL)");
        }
        const auto count = [&](const bus::Message& message) {
            extractions_ +=
                message.kind() == bus::Body::SurfaceBuilt && message.source() == gp_ids().front()
                    ? 1
                    : 0;
            take(message);
        };
        inside_.pump(count, done);
    }
    void wait_readable(int fd) override { inside_.wait_readable(fd); }
    void prepare_io() override {}
    bus::NodeId start_io(ExitCode code) override { return inside_.start_io(code); }
    void release_io() override {}
    void allow_cancel(bool allowed) override { inside_.allow_cancel(allowed); }
    void watch(int fd, std::function<bool()> give_up) override {
        inside_.watch(fd, std::move(give_up));
    }
    bool is_recording() const override { return false; }
    SavedTraces save_traces() override { return inside_.save_traces(); }

  private:
    test::SimulatedMachine inside_;
    int& extractions_;
    bool& dies_;
};

struct Theatre {
    Watchers watchers;
    std::int64_t now_ns = 0;
    int extractions = 0, launches = 0;
    bool dies = false;
    Director director{watchers, parts()};

    Theatre() {
        director.session().scene.overlay = false;
        director.open("size 128x96");
        director.open("load phantom:sphere");
        director.show_first_surfaces();
        watchers.events.emplace_back(Joined{1, Role::driver});
        settle();
    }
    DirectorParts parts() {
        DirectorParts parts;
        parts.topology = "simulated";
        parts.downloads = "downloads";
        parts.answer = [](Session&, std::uint32_t id, std::string_view) {
            return std::to_string(id);
        };
        parts.clock_ns = [this] { return now_ns; };
        parts.launch = [this] {
            ++launches;
            Topology topology;
            topology.gp.count = 2;
            topology.renderer.count = 2;
            topology.frame_buffer.count = 1;
            topology.gp_memory_mib = 64;
            topology.seed = 5;
            return std::make_shared<MortalMachine>(topology, extractions, dies);
        };
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

/// From frame `first` on there is the picture itself, better twice, and no more.
void check_refined(const std::vector<serve::Shown>& frames, std::size_t first) {
    REQUIRE(frames.size() == first + 3);
    for (std::size_t i = 0; i < 3; ++i) {
        const serve::Shown& frame = frames[first + i];
        CHECK(frame.rests);
        CHECK(frame.samples == std::array{1, 4, 16}[i]);
        CHECK(frame.last == (i == 2));
    }
}

}  // namespace

TEST_CASE("who joins is greeted, and hears of the volume and its first surface") {
    Theatre stage;
    CHECK(stage.watchers.last("hello")["role"] == "driver");
    const Json state = stage.watchers.last("state");
    CHECK(state["volume"]["name"] == "phantom:sphere");
    CHECK(state["surfaces"].size() == 1);
    CHECK(state["camera"]["patient_to_clip"].size() == 16);
    CHECK(state["busy"].is_null());
    CHECK(state["redo"].is_null());
    CHECK(state["size"] == Json({128, 96}));
}

TEST_CASE("a flood of isovalues costs few extractions, and the newest is what rests") {
    Theatre stage;
    const int before = stage.extractions;
    for (int i = 1; i <= 1000; ++i) {
        stage.watchers.does(i, "surface sphere iso=" + std::to_string(0.001 * i - 0.6));
        if (i % 100 == 0) {
            stage.director.step();
        }
    }
    stage.steps();
    CHECK(stage.extractions - before <= 10);
    CHECK(stage.watchers.reply(50)["superseded"] == true);
    const Json newest = stage.watchers.reply(1000);
    CHECK(newest["ok"] == true);
    CHECK(newest["result"]["isovalue"].get<double>() == doctest::Approx(0.4));
    const serve::Shown moving = stage.watchers.frames.back();
    CHECK(!moving.rests);
    CHECK(moving.revision == newest["revision"]);
    stage.settle();
    const serve::Shown resting = stage.watchers.frames.back();
    CHECK(resting.rests);
    CHECK(resting.revision == newest["revision"]);
    CHECK(resting.samples == 16);
    CHECK(resting.digest == picture_digest(*stage.director.session().draw_samples(16)));
    CHECK(stage.watchers.last("state")["revision"] == newest["revision"]);
    CHECK(stage.director.due_ms() < 0);  // Nothing is left to do: nobody turns in circles.
}

TEST_CASE("what moves is drawn at once, and itself 150 ms after the last input") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.does(1, "view 10 20");
    stage.steps();
    REQUIRE(stage.watchers.frames.size() == 1);
    CHECK(!stage.watchers.frames[0].rests);
    stage.passes(rest_ms - 10);
    stage.steps();
    CHECK(stage.watchers.frames.size() == 1);
    stage.watchers.does(2, "view 10 30");
    stage.steps();
    CHECK(stage.watchers.frames.size() == 2);
    stage.passes(rest_ms - 10);
    stage.steps();
    CHECK(stage.watchers.frames.size() == 2);
    stage.passes(11);
    stage.steps();
    check_refined(stage.watchers.frames, 2);
}

TEST_CASE("a refinement is given up when something comes, and its picture is not shown") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.on_show = [&](const serve::Shown& frame) {
        if (frame.rests && frame.samples == 4 && !stage.watchers.reply(2).is_object()) {
            stage.watchers.does(2, "view 10 30");
        }
    };
    stage.watchers.does(1, "view 10 20");
    stage.settle();
    std::vector<std::pair<std::uint32_t, int>> shown;  // Revision after the first, and samples.
    for (const serve::Shown& frame : stage.watchers.frames) {
        shown.emplace_back(frame.revision - stage.watchers.frames[0].revision,
                           frame.rests ? frame.samples : 0);
    }
    CHECK(shown == std::vector<std::pair<std::uint32_t, int>>{
                       {0, 0}, {0, 1}, {0, 4}, {1, 0}, {1, 1}, {1, 4}, {1, 16}});
}

TEST_CASE("who scrolls through slices keeps the refined picture from nobody") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.does(1, "view 10 20");
    stage.steps();
    stage.passes(rest_ms + 1);
    stage.watchers.scrolls = true;
    constexpr int rounds = 10;
    for (int i = 0; i < rounds; ++i) {
        stage.director.step();
    }
    check_refined(stage.watchers.frames, 1);
    CHECK(stage.watchers.binaries.size() == rounds);
}

TEST_CASE("of questions for bytes the newest of each kind is answered") {
    Theatre stage;
    stage.watchers.says({{"id", 1}, {"ask", "slice"}, {"axis", "x"}});
    stage.watchers.says({{"id", 2}, {"ask", "slice"}, {"axis", "y"}});
    stage.watchers.says({{"id", 3}, {"ask", "slice"}, {"axis", "x"}});
    stage.settle();
    CHECK(stage.watchers.reply(1)["superseded"] == true);
    CHECK(stage.watchers.binaries == std::vector<std::string>{"3", "2"});
}

TEST_CASE("viewers who take no frame get the resting one, and none of those between") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.takes_frames = false;
    for (int i = 0; i < 20; ++i) {
        stage.watchers.does(i, "view 10 " + std::to_string(i));
        stage.steps();
    }
    CHECK(stage.watchers.frames.empty());
    stage.settle();
    check_refined(stage.watchers.frames, 0);
}

TEST_CASE("a question changes no revision and draws nothing") {
    Theatre stage;
    const Json before = stage.watchers.last("state")["revision"];
    const std::size_t frames = stage.watchers.frames.size();
    stage.watchers.does(1, "stats");
    stage.settle();
    CHECK(stage.watchers.reply(1)["revision"] == before);
    CHECK(stage.watchers.frames.size() == frames);
}

TEST_CASE("who only watches changes nothing, and nobody ends the program from the page") {
    Theatre stage;
    stage.watchers.says({{"id", 1}, {"do", "view 10 20"}}, Role::watcher);
    stage.watchers.says({{"id", 2}, {"ask", "scrub"}}, Role::watcher);
    stage.watchers.does(3, "quit");
    stage.watchers.does(4, "surfice bone");
    stage.watchers.does(5, "surface bone");
    stage.settle();
    for (const int id : {1, 2, 3, 4, 5}) {
        CHECK(stage.watchers.reply(id)["ok"] == false);
        CHECK(!stage.watchers.reply(id)["error"].get<std::string>().empty());
    }
    CHECK(stage.director.session().scene.camera.angles.azimuth_deg == 0);
}

TEST_CASE("a load is given up when somebody says so, and leaves nothing") {
    Theatre stage;
    stage.watchers.does(1, "load phantom:pelvis");
    stage.watchers.does(2, "load phantom:pelvis");
    stage.director.step();  // Takes both, does the first.
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.watchers.last("progress").is_null());
    // The second is under way when the word comes: it waits where pump() looks.
    stage.director.session().progress = [&](const LoadProgress&) {
        stage.watchers.says({{"cancel", true}});
    };
    stage.director.step();
    CHECK(stage.watchers.reply(2)["ok"] == false);
    CHECK(stage.watchers.reply(2)["error"] == "cancelled");
    stage.settle();
    CHECK(stage.watchers.last("state")["volume"].is_null());
    CHECK(stage.watchers.last("state")["busy"].is_null());
}

TEST_CASE("a machine that dies is started again, with everything as it was") {
    Theatre stage;
    stage.watchers.does(1, "view 30 20 roll=10");
    stage.watchers.does(2, "surface sphere iso=0.25 color=red");
    stage.watchers.does(3, "light 1 off");
    stage.settle();
    const std::uint64_t before = stage.watchers.frames.back().digest;
    stage.dies = true;
    stage.watchers.does(4, "digest");
    stage.settle();
    CHECK(stage.launches == 2);
    CHECK(stage.watchers.reply(4)["error"].get<std::string>().find("gp-1 was killed") !=
          std::string::npos);
    CHECK(stage.watchers.frames.back().digest == before);
    CHECK(stage.watchers.frames.back().rests);
    stage.watchers.does(5, "undo");
    stage.settle();
    CHECK(stage.watchers.reply(5)["ok"] == true);
    CHECK(stage.director.session().scene.lights.size() == 2);
}

TEST_CASE("a machine that dies three times in a minute ends the program with its error") {
    Theatre stage;
    for (int i = 0; i < max_deaths - 1; ++i) {
        stage.dies = true;
        stage.watchers.does(i, "digest");
        stage.settle();
    }
    stage.dies = true;
    stage.watchers.does(9, "digest");
    CHECK_THROWS_WITH_AS(stage.settle(), "gp-1 was killed by signal 9 (SIGKILL)", MachineError);
}

TEST_CASE("deaths that are far apart do not end the program") {
    Theatre stage;
    for (int i = 0; i < max_deaths + 1; ++i) {
        stage.dies = true;
        stage.watchers.does(i, "digest");
        stage.settle();
        stage.passes(death_window_ms / (max_deaths - 1));
    }
    CHECK(stage.launches == max_deaths + 2);
}
