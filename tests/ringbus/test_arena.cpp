#include "ringbus/zmq/arena.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/ringbus/large_bodies.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::contains;
using pxpl5::test::large_slices;

namespace {

constexpr std::size_t body_bytes = 100'000;

schema::Header header_of(const Payload& payload) {
    return test::WireBytes(payload).header;
}

/// An arena with a body in it, and a reader.
struct Lent {
    Arena arena;
    Payload payload = large_slices(&arena, body_bytes, 1);
    std::shared_ptr<ArenaView> view = ArenaView::open(arena.offer(), 2);
};

std::string refusal_of(Lent& lent, std::uint64_t offset, std::uint64_t bytes,
                       std::uint32_t ticket) {
    schema::Header header = header_of(lent.payload);
    header.mutate_body_bytes(bytes);
    ArenaPlace place;
    place.offset = offset;
    place.ticket = ticket;
    const auto owner = lent.view->hold(ticket);
    try {
        lent.view->body(header, place);
    } catch (const BadMessage& bad) {
        return bad.what();
    }
    return {};
}

std::size_t memory_bytes(const Arena& arena) {
    struct stat facts {};
    REQUIRE(fstat(static_cast<int>(arena.offer().descriptor), &facts) == 0);
    return static_cast<std::size_t>(facts.st_blocks) * 512;
}

}  // namespace

TEST_SUITE("ringbus/arena") {
    TEST_CASE("a body is lent in place, and its block is free after the last reader") {
        Lent lent;
        REQUIRE(lent.view);
        const auto second_view = ArenaView::open(lent.arena.offer(), 3);
        REQUIRE(second_view);
        const auto place_2 = lent.arena.lend(2, lent.payload);
        const auto place_3 = lent.arena.lend(3, lent.payload);
        REQUIRE(place_2);
        REQUIRE(place_3);
        CHECK(place_2->offset == place_3->offset);  // A broadcast holds its bytes once.
        const schema::Header header = header_of(lent.payload);
        const std::uint8_t* const body = lent.payload.bytes().data();
        std::optional<Message> at_2, at_3;
        at_2.emplace(header, lent.view->body(header, *place_2), lent.view->hold(place_2->ticket));
        at_3.emplace(header, second_view->body(header, *place_3),
                     second_view->hold(place_3->ticket));
        lent.payload = {};
        CHECK(test::is_whole(*at_2, body_bytes, 1));
        const Payload other = large_slices(&lent.arena, body_bytes, 2);
        CHECK(other.bytes().data() != body);
        at_2.reset();
        CHECK(large_slices(&lent.arena, body_bytes, 3).bytes().data() != body);
        CHECK(test::is_whole(*at_3, body_bytes, 1));
        at_3.reset();
        CHECK(large_slices(&lent.arena, body_bytes, 4).bytes().data() == body);
    }

    TEST_CASE("small bodies, bodies outside the arena and unknown readers are not lent to") {
        Lent lent;
        CHECK(lent.arena.lend(2, lent.payload));
        CHECK(!lent.arena.lend(3, lent.payload));
        CHECK(!lent.arena.lend(max_arena_readers, lent.payload));
        flatbuffers::DefaultAllocator heap;
        CHECK(!lent.arena.lend(2, large_slices(&heap, body_bytes, 1)));
        CHECK(!lent.arena.lend(2, large_slices(&lent.arena, 1000, 1)));
    }

    TEST_CASE("a place outside the arena is refused with both values, and its ticket returns") {
        Lent lent;
        const auto place = lent.arena.lend(2, lent.payload);
        REQUIRE(place);
        CHECK(contains(
            refusal_of(lent, arena_bytes - 8, 16, place->ticket),
            "its body is at 536870904 and has 16 bytes, the sender's arena has 536870912"));
        CHECK(contains(refusal_of(lent, ~std::uint64_t{7}, 16, place->ticket), "its body is at"));
        CHECK(contains(refusal_of(lent, 8, ~std::uint64_t{0}, place->ticket), "its body is at"));
        CHECK(contains(refusal_of(lent, 4, 16, place->ticket), "in words of 8"));
        CHECK(contains(refusal_of(lent, 0, 16, max_tickets),
                       "ticket is 4096, allowed are at most 4095"));
        CHECK(refusal_of(lent, arena_bytes - 16, 16, place->ticket).empty());
        const std::uint8_t* const body = lent.payload.bytes().data();
        lent.payload = {};
        CHECK(large_slices(&lent.arena, body_bytes, 4).bytes().data() == body);
    }

    TEST_CASE("a ticket is held once, by the node it was lent to, until it is lent again") {
        Lent lent;
        const auto other_view = ArenaView::open(lent.arena.offer(), 3);
        REQUIRE(other_view);
        const std::uint8_t* const body = lent.payload.bytes().data();
        const auto place = lent.arena.lend(2, lent.payload);
        REQUIRE(place);
        lent.payload = {};
        CHECK(!other_view->hold(place->ticket));
        auto owner = lent.view->hold(place->ticket);
        REQUIRE(owner);
        CHECK(!lent.view->hold(place->ticket));
        CHECK(!other_view->hold(place->ticket));
        CHECK(large_slices(&lent.arena, body_bytes, 2).bytes().data() != body);
        owner.reset();
        CHECK(!lent.view->hold(place->ticket));
        CHECK(large_slices(&lent.arena, body_bytes, 3).bytes().data() == body);
    }

    TEST_CASE("a late return by a forgotten reader does not free another reader's body") {
        Lent lent;
        const auto other_view = ArenaView::open(lent.arena.offer(), 3);
        const auto place = lent.arena.lend(2, lent.payload);
        REQUIRE(place);
        auto late = lent.view->hold(place->ticket);
        lent.arena.forget(2);
        REQUIRE(lent.arena.lend(3, lent.payload)->ticket == place->ticket);
        const auto owner = other_view->hold(place->ticket);
        REQUIRE(owner);
        const std::uint8_t* const body = lent.payload.bytes().data();
        lent.payload = {};
        late.reset();
        CHECK(large_slices(&lent.arena, body_bytes, 2).bytes().data() != body);
    }

    TEST_CASE("a small body may be dropped by another thread while the first large one is made") {
        // The thread sanitizer detects a race.
        Arena arena;
        std::uint8_t* const small = arena.allocate(min_arena_body_bytes - 1);
        std::thread other([&] { arena.deallocate(small, min_arena_body_bytes - 1); });
        const Payload large = large_slices(&arena, body_bytes, 1);
        other.join();
        CHECK(arena.can_lend(large));
    }

    TEST_CASE("a large body of the heap may be dropped by another thread") {
        Arena arena(ArenaBlocks::grain_bytes);
        std::uint8_t* const large = arena.allocate(body_bytes);
        std::thread other([&] { arena.deallocate(large, body_bytes); });
        std::uint8_t* const next = arena.allocate(body_bytes);
        other.join();
        arena.deallocate(next, body_bytes);
        CHECK(!arena.can_lend(large_slices(&arena, body_bytes, 1)));
    }

    TEST_CASE("without tickets nothing is lent, and a returned ticket is lent again") {
        Lent lent;
        std::optional<ArenaPlace> place;
        for (std::uint32_t i = 0; i < max_tickets; ++i) {
            place = lent.arena.lend(2, lent.payload);
            REQUIRE(place);
        }
        CHECK(!lent.arena.lend(2, lent.payload));
        lent.view->hold(place->ticket).reset();
        CHECK(lent.arena.lend(2, lent.payload));
        CHECK(!lent.arena.lend(2, lent.payload));
    }

    TEST_CASE("bodies lent to a reader that has ended are free again") {
        Lent lent;
        const std::uint8_t* const body = lent.payload.bytes().data();
        REQUIRE(lent.arena.lend(2, lent.payload));
        lent.payload = {};
        CHECK(large_slices(&lent.arena, body_bytes, 2).bytes().data() != body);
        lent.arena.forget(2);
        CHECK(large_slices(&lent.arena, body_bytes, 3).bytes().data() == body);
        CHECK(!lent.arena.lend(2, large_slices(&lent.arena, body_bytes, 3)));
    }

    TEST_CASE("a damaged list of tickets ends") {
        Lent lent;
        const auto first = lent.arena.lend(2, lent.payload);
        const auto second = lent.arena.lend(2, lent.payload);
        REQUIRE(second);
        auto* control = static_cast<ArenaControl*>(
            mmap(nullptr, sizeof(ArenaControl), PROT_READ | PROT_WRITE, MAP_SHARED,
                 static_cast<int>(lent.arena.offer().descriptor), 0));
        REQUIRE(control != MAP_FAILED);
        control->next[first->ticket] = second->ticket;
        control->next[second->ticket] = first->ticket;
        control->returned = first->ticket;
        CHECK(lent.arena.lend(2, lent.payload));
        control->returned = ~std::uint32_t{0};
        CHECK(lent.arena.lend(2, lent.payload));
        munmap(control, sizeof(ArenaControl));
    }

    TEST_CASE("bodies beyond the arena come from the heap") {
        Arena arena;
        std::uint8_t* const whole = arena.allocate(arena_bytes + 1);
        whole[arena_bytes] = 1;
        arena.deallocate(whole, arena_bytes + 1);
        arena.deallocate(arena.allocate(0), 0);
    }

    TEST_CASE("memory between bodies returns to the system on request, and is there again") {
        constexpr std::size_t much = 64 << 20;
        Arena arena;
        std::uint8_t* const below = arena.allocate(much);
        const Payload used = large_slices(&arena, body_bytes, 4);
        arena.deallocate(below, much);
        arena.return_memory();
        CHECK(memory_bytes(arena) < 2 << 20);
        CHECK(test::is_whole(test::WireBytes(used).read(), body_bytes, 4));
        const Payload again = large_slices(&arena, 8 << 20, 6);
        CHECK(test::is_whole(test::WireBytes(again).read(), 8 << 20, 6));
    }

    TEST_CASE("unused memory returns to the system") {
        constexpr std::size_t much = 64 << 20;
        Arena arena;
        arena.deallocate(arena.allocate(much), much);
        CHECK(memory_bytes(arena) >= much);
        for (int i = 0; i < 10'000; ++i) {
            arena.deallocate(arena.allocate(body_bytes), body_bytes);
        }
        CHECK(memory_bytes(arena) < 2 << 20);
        const Payload after = large_slices(&arena, 8 << 20, 5);
        CHECK(test::is_whole(test::WireBytes(after).read(), 8 << 20, 5));
    }

    TEST_CASE("an offer of a file that is no arena is refused") {
        const Lent lent;
        ArenaOffer offer = lent.arena.offer();
        CHECK(ArenaView::open(offer, 2));
        CHECK(!ArenaView::open(offer, max_arena_readers));
        offer.inode += 1;
        CHECK(!ArenaView::open(offer, 2));
        offer = lent.arena.offer();
        offer.descriptor = 1'000'000;
        CHECK(!ArenaView::open(offer, 2));
        offer = lent.arena.offer();
        offer.pid = 0;
        CHECK(!ArenaView::open(offer, 2));
        // As large as an arena, but without a seal against shrinking.
        const int file = memfd_create("unsealed", MFD_CLOEXEC | MFD_ALLOW_SEALING);
        REQUIRE(ftruncate(file, static_cast<off_t>(arena_file_bytes)) == 0);
        struct stat facts {};
        REQUIRE(fstat(file, &facts) == 0);
        offer = {facts.st_dev, facts.st_ino, static_cast<std::uint32_t>(getpid()),
                 static_cast<std::uint32_t>(file)};
        CHECK(!ArenaView::open(offer, 2));
        close(file);
    }

    TEST_CASE("an offered file is opened only if its identity matches") {
        const Lent lent;
        ArenaOffer offer = lent.arena.offer();
        const int events = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
        REQUIRE(events >= 0);
        const std::string path = "/proc/self/fd/" + std::to_string(offer.descriptor);
        REQUIRE(inotify_add_watch(events, path.c_str(), IN_OPEN) >= 0);
        std::array<char, 256> event{};
        offer.device += 1;
        CHECK(!ArenaView::open(offer, 2));
        offer = lent.arena.offer();
        offer.inode += 1;
        CHECK(!ArenaView::open(offer, 2));
        CHECK(read(events, event.data(), event.size()) < 0);
        CHECK(ArenaView::open(lent.arena.offer(), 2));
        CHECK(read(events, event.data(), event.size()) > 0);
        close(events);
    }

    TEST_CASE("a process with limited address space neither lends nor borrows") {
        Lent lent;
        rlimit before{};
        getrlimit(RLIMIT_AS, &before);
        rlimit limited = before;
        limited.rlim_cur = std::uint64_t{1} << 46;
        setrlimit(RLIMIT_AS, &limited);
        Arena arena;
        const Payload payload = large_slices(&arena, body_bytes, 1);
        const bool can_lend = arena.can_lend(payload);
        const auto view = ArenaView::open(lent.arena.offer(), 4);
        setrlimit(RLIMIT_AS, &before);
        CHECK(!can_lend);
        CHECK(!view);
    }
}
