// Computers that join, are lost and are released, over sockets of this computer.
#include <doctest/doctest.h>
#include <poll.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/computers/facts.hpp"
#include "host/machine/computers/remote_computers.hpp"
#include "ringbus/process/process.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

constexpr int limit_ms = 20'000;
using Names = std::vector<std::string>;

ClusterSettings loopback() {
    ClusterSettings cluster;
    cluster.engine = Engine::wait;
    cluster.listen = "127.0.0.1";
    return cluster;
}

/// The host's side of a session, and the computers that join it.
struct Meeting {
    bus::Credentials credentials =
        bus::make_credentials(bus::Protection::plain_tcp, bus::Reach::network);
    RemoteComputers host{loopback(), credentials, {bus::build_id(), bus::schema_hash()}, "/tmp"};
    std::int64_t time_ms = 0;

    /// Pumps until `done`, as time goes by for the sockets, but not for the host's clock.
    void pump_until(bus::Line& line, const std::function<bool()>& done) {
        const std::int64_t end_ms = now_ms() + limit_ms;
        for (host.pump(time_ms); !done(); host.pump(time_ms)) {
            REQUIRE(now_ms() < end_ms);
            std::array<pollfd, 3> fds = {pollfd{host.poll_fd(), POLLIN, 0},
                                         pollfd{line.poll_fd(), POLLIN, 0},
                                         pollfd{line.event_fd(), POLLIN, 0}};
            poll(fds.data(), fds.size(), 10);
            line.is_connected();
        }
    }
    /// A computer that has joined.
    std::unique_ptr<bus::Line> join(const std::string& name) {
        auto line = std::make_unique<bus::Line>(host.addresses(), credentials);
        line->send(packed_letter(own_question(credentials, name)));
        bool is_answered = false;
        pump_until(*line, [&] { return is_answered |= line->receive().has_value(); });
        return line;
    }
    /// The next letter to a computer.
    join::LetterT letter_to(bus::Line& line) {
        std::optional<bus::Letter> bytes;
        pump_until(line, [&] { return (bytes = line.receive()).has_value(); });
        return unpacked_letter(*bytes);
    }
    /// The host listens, but no computer says anything.
    void pass_silence() {
        for (int n = 0; n < 5; ++n) {
            host.pump(time_ms += RemoteComputers::beat_ms);
        }
    }
    Names names() const {
        Names list;
        for (const RemoteComputer& each : host.computers()) {
            list.push_back(each.facts.name);
        }
        return list;
    }
};

ProcessCommand node(const std::string& name) {
    ProcessCommand command;
    command.name = name;
    command.program = "/bin/pxpl5-gp";
    return command;
}

}  // namespace

TEST_CASE("computers: one that joins a running machine is announced, and sorted into the next") {
    Meeting meeting;
    const auto second = meeting.join("n2"), third = meeting.join("n3");
    CHECK(meeting.host.take_news().empty());
    meeting.host.close({});
    const auto first = meeting.join("n1");
    const Names news = meeting.host.take_news();
    REQUIRE(news.size() == 1);
    CHECK(news[0].starts_with("n1 with "));
    CHECK(news[0].find("has joined") != std::string::npos);
    CHECK(meeting.names() == Names{"n2", "n3", "n1"});  // Numbers stay while a machine runs.
    CHECK(meeting.host.open("/tmp").empty());
    meeting.host.close({"n3"});
    CHECK(meeting.names() == Names{"n3", "n1", "n2"});
}

TEST_CASE("computers: one that was lost is left out, until it joins again") {
    Meeting meeting;
    const auto line = meeting.join("n1");
    meeting.host.close({});
    meeting.host.spawn(1, node("gp-0"), 0);
    meeting.pass_silence();
    const std::vector<Death> deaths = meeting.host.take_deaths();
    REQUIRE(deaths.size() == 1);
    CHECK(deaths[0].why.find("gp-0 is lost with computer n1: it has not answered") == 0);
    CHECK(meeting.host.open("/tmp") == Names{"n1"});
    CHECK(meeting.names().empty());
    REQUIRE(meeting.host.former().size() == 1);
    CHECK_FALSE(meeting.host.former()[0].is_released);
    const auto again = meeting.join("n1");
    CHECK(meeting.host.former().empty());
    CHECK(meeting.host.takes_part("n1"));
}

TEST_CASE("computers: one that comes back before the next machine is not left out") {
    Meeting meeting;
    const auto line = meeting.join("n1");
    meeting.host.close({});
    meeting.host.spawn(1, node("gp-0"), 0);
    meeting.pass_silence();
    const auto again = meeting.join("n1");
    CHECK(meeting.host.open("/tmp").empty());
    CHECK(meeting.names() == Names{"n1"});
    CHECK(meeting.host.former().empty());
}

TEST_CASE("computers: one without nodes that leaves is told of, and is no death") {
    Meeting meeting;
    meeting.host.close({});
    const auto line = meeting.join("n1");
    meeting.host.take_news();
    meeting.pass_silence();
    CHECK(meeting.host.take_deaths().empty());
    const Names news = meeting.host.take_news();
    REQUIRE(news.size() == 1);
    CHECK(news[0].starts_with("n1 has left: it has not answered for"));
}

TEST_CASE("computers: a released one ends at once without nodes, else with the machine") {
    Meeting meeting;
    const auto used = meeting.join("n1");
    meeting.host.close({});
    const auto idle = meeting.join("n2");
    meeting.host.spawn(1, node("gp-0"), 0);
    CHECK(meeting.letter_to(*used).word.AsStart() != nullptr);
    REQUIRE(meeting.host.release("n1"));
    REQUIRE(meeting.host.release("n2"));
    CHECK_FALSE(meeting.host.release("n2"));
    const join::LetterT end = meeting.letter_to(*idle);
    REQUIRE(end.word.AsDismiss() != nullptr);
    CHECK(end.word.AsDismiss()->is_released);
    CHECK(end.word.AsDismiss()->reason.empty());
    CHECK_FALSE(used->receive().has_value());
    CHECK(meeting.host.open("/tmp").empty());
    const join::LetterT later = meeting.letter_to(*used);
    REQUIRE(later.word.AsDismiss() != nullptr);
    CHECK(later.word.AsDismiss()->is_released);
    CHECK(meeting.host.former().size() == 2);
    // Its last letters are no letters of strangers.
    used->send(packed_letter(join::BeatT{}));
    const auto next = meeting.join("n3");
    CHECK(meeting.host.refused() == 0);
}

TEST_CASE("computers: one whose name is no name is refused, and the reason names the remedy") {
    Meeting meeting;
    for (const std::string name : {"-oProxyCommand=x", "a/b", "a;b"}) {
        CAPTURE(name);
        bus::Line line(meeting.host.addresses(), meeting.credentials);
        line.send(packed_letter(own_question(meeting.credentials, name)));
        const join::LetterT letter = meeting.letter_to(line);
        REQUIRE(letter.word.AsAnswer() != nullptr);
        const std::string refusal = letter.word.AsAnswer()->refusal;
        CHECK(refusal.starts_with("its name is '" + name + "'; "));
        CHECK(refusal.ends_with("Give it a name with --name"));
    }
    CHECK(meeting.names().empty());
}

TEST_CASE("computers: a line that the host does not know is dismissed with the reason") {
    Meeting meeting;
    bus::Line line(meeting.host.addresses(), meeting.credentials);
    line.send(packed_letter(join::BeatT{}));
    const join::LetterT letter = meeting.letter_to(line);
    REQUIRE(letter.word.AsDismiss() != nullptr);
    CHECK(letter.word.AsDismiss()->reason.starts_with("the host does not know this connection"));
    CHECK_FALSE(letter.word.AsDismiss()->is_released);
    CHECK(meeting.host.refused() == 1);
}

TEST_CASE("computers: the end of an engine takes its computers along, but no others") {
    Meeting meeting;
    meeting.host.expect_from("engine-slurm");
    const auto first = meeting.join("n1");
    meeting.host.close({});
    const auto second = meeting.join("n2");
    CHECK_FALSE(meeting.host.take_end_of_engine("engine-n3", "it ended"));
    CHECK(meeting.host.takes_part("n1"));
    meeting.host.spawn(1, node("gp-0"), 0);
    CHECK(meeting.host.take_end_of_engine("engine-slurm", "it ended"));
    CHECK_FALSE(meeting.host.takes_part("n1"));
    CHECK(meeting.host.takes_part("n2"));
    meeting.host.open("/tmp");
    CHECK(meeting.host.former().empty());  // The engine may start it again.
    CHECK_FALSE(meeting.host.take_end_of_engine("engine-n2", "it ended"));  // It has no nodes.
    CHECK(meeting.host.open("/tmp") == Names{"n2"});
}
