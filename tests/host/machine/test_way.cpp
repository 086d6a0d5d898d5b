#include "host/machine/computers/join/way.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>

#include "host/base/error.hpp"

using namespace pxpl5::host;

namespace {

/// A port of loopback at which no program listens yet.
class Listener {
  public:
    Listener() {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        REQUIRE(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
        REQUIRE(getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
        port_ = ntohs(address.sin_port);
    }
    ~Listener() { close(fd_); }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    void start() const { REQUIRE(listen(fd_, 1) == 0); }
    std::string at(const std::string& host) const {
        return fmt::format("tcp://{}:{}", host, port_);
    }

  private:
    int fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), port_ = 0;
};

constexpr std::int64_t long_ms = 60'000;

}  // namespace

TEST_CASE("way: a host is found by its address and by its name") {
    const Listener host;
    host.start();
    Supervisor supervisor;
    for (const std::string name : {"127.0.0.1", "localhost"}) {
        CAPTURE(name);
        const Way way = await_way(host.at(name), now_ms() + long_ms, supervisor,
                                  [](const std::string& text) { FAIL(text); });
        CHECK(way.address == host.at("127.0.0.1"));  // Nodes need the number.
        CHECK(way.own == "127.0.0.1");
    }
}

TEST_CASE("way: a host that starts later is awaited, and the reason to wait is said once") {
    const Listener host;
    Supervisor supervisor;
    std::vector<std::string> said;
    const Way way = await_way(host.at("127.0.0.1"), now_ms() + long_ms, supervisor,
                              [&](const std::string& text) {
                                  said.push_back(text);
                                  host.start();
                              });
    CHECK(way.address == host.at("127.0.0.1"));
    REQUIRE(said.size() == 1);
    CHECK(said[0].starts_with("waits for the host at " + host.at("127.0.0.1") + ", "));
    CHECK(said[0].find(" s more: no program listens at port ") != std::string::npos);
}

TEST_CASE("way: a name that is not known is told as such at the end of the time") {
    Supervisor supervisor;
    std::string error;
    try {
        await_way("tcp://pxpl5-host.invalid:5755", now_ms() + 900, supervisor,
                  [](const std::string&) {});
    } catch (const RequestError& caught) {
        error = caught.what();
        CHECK(caught.code == ExitCode::unavailable);
    }
    CHECK(
        error.starts_with("no host answers at tcp://pxpl5-host.invalid:5755 within 1 s: the name"));
    CHECK(error.find("pxpl5-host.invalid") != std::string::npos);
}

TEST_CASE("way: a signal ends the wait") {
    const Listener host;
    Supervisor supervisor;
    try {
        await_way(host.at("127.0.0.1"), now_ms() + long_ms, supervisor,
                  [](const std::string&) { raise(SIGTERM); });
        FAIL("waited on");
    } catch (const MachineError& error) {
        CHECK(error.code == 128 + SIGTERM);
        CHECK(error.is_interruption);
    }
}

TEST_CASE("way: what is neither address nor name is refused") {
    for (const char* text : {"127.0.0.1:80", "tcp://127.0.0.1", "tcp://a b:80", "tcp://-a:80",
                             "tcp://1.2.3.4:0", "tcp://:80", "tcp://a:80,tcp://b:81"}) {
        CAPTURE(text);
        CHECK_THROWS_AS(parse_addresses(text), RequestError);
    }
    CHECK(parse_addresses("tcp://pxpl5-host:5755,tcp://10.0.0.1:5755").hosts ==
          std::vector<std::string>{"pxpl5-host", "10.0.0.1"});
}
