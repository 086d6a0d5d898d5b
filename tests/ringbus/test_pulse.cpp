#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <system_error>
#include <thread>

#include "ringbus/pulse.hpp"

using namespace pxpl5::bus;

TEST_CASE("a pulse beats on its own, and shows the phase and the work of its node") {
    PulseCell cell;
    CHECK(cell.read().beats == 0);
    Pulse pulse(dup(cell.fd()), 1);
    while (cell.read().beats < 3) {
        std::this_thread::yield();
    }
    const std::uint64_t progress = cell.read().progress;
    pulse.enter(Phase::working, {Body::SetSurface, 70'000, 3, 12});
    const PulseReading working = cell.read();
    CHECK(working.progress == progress + 1);
    CHECK(working.worked == 1);
    CHECK(working.phase == Phase::working);
    CHECK(working.doing.kind == Body::SetSurface);
    CHECK(working.doing.subject == 70'000);
    CHECK(working.doing.done == 3);
    CHECK(working.doing.total == 12);
    pulse.enter(Phase::waiting);
    CHECK(cell.read().progress == progress + 2);
    CHECK_MESSAGE(cell.read().worked == 1, "waiting is no work");
    CHECK(cell.read().cpu_ns > 0);
}

TEST_CASE("a pulse without a cell writes nothing") {
    Pulse pulse;
    pulse.enter(Phase::working, {Body::SetSurface});
}

TEST_CASE("nonsense in a cell is read as no kind") {
    PulseCell cell;
    cell.words().work = ~std::uint64_t{0};
    CHECK(cell.read().doing.kind == Body::NONE);
}

TEST_CASE("no process can change the size of a cell") {
    const PulseCell cell;
    CHECK(ftruncate(cell.fd(), 0) != 0);
    CHECK(ftruncate(cell.fd(), 1 << 20) != 0);
}

TEST_CASE("a descriptor that is no cell is refused") {
    CHECK_THROWS_AS(PulseCell(open("/dev/null", O_RDONLY)), std::system_error);
}
