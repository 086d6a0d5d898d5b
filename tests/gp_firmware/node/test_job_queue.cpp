// The order in which a GP works.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "gp_firmware/node/job_queue.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;

namespace {

ExtractJob extraction(std::uint16_t surface, std::uint32_t revision) {
    ExtractJob job;
    job.surface = surface;
    job.revision = revision;
    return job;
}

DrawJob frame_showing(std::uint16_t surface, std::uint32_t revision) {
    DrawJob job;
    job.request.surfaces = {{surface, revision, false, SlabChoice::all}};
    return job;
}

/// "extract 4.2", "remove 4", "draw 4.2" or "measure".
std::string name_of(const Job& job) {
    if (const auto* extract = std::get_if<ExtractJob>(&job)) {
        return "extract " + std::to_string(extract->surface) + "." +
               std::to_string(extract->revision);
    }
    if (const auto* remove = std::get_if<RemoveJob>(&job)) {
        return "remove " + std::to_string(remove->surface);
    }
    if (const auto* draw = std::get_if<DrawJob>(&job)) {
        return "draw " + std::to_string(draw->request.surfaces[0].surface) + "." +
               std::to_string(draw->request.surfaces[0].revision);
    }
    return "measure";
}

/// The jobs up to the first one that waits.
std::vector<std::string> order_of(JobQueue& queue) {
    std::vector<std::string> names;
    for (const Job* job = queue.front(); job != nullptr; job = queue.front()) {
        names.push_back(name_of(*job));
        queue.pop();
    }
    return names;
}

}  // namespace

TEST_SUITE("gp_firmware/node/job_queue") {
    TEST_CASE("an extraction replaces those of its surface since the last removal") {
        JobQueue queue;
        queue.add_extraction(extraction(4, 1));
        queue.add_removal(4);
        queue.add_extraction(extraction(4, 2));
        queue.add_extraction(extraction(5, 1));
        queue.add_extraction(extraction(4, 3));
        CHECK(order_of(queue) ==
              std::vector<std::string>{"extract 4.1", "remove 4", "extract 5.1", "extract 4.3"});
    }

    TEST_CASE("an extraction precedes the frames that show its revision") {
        JobQueue queue;
        queue.add(frame_showing(4, 1));
        queue.add(frame_showing(4, 2));
        queue.add_extraction(extraction(4, 2));
        CHECK(order_of(queue) == std::vector<std::string>{"draw 4.1", "extract 4.2", "draw 4.2"});
    }

    TEST_CASE("a frame waits for a newer revision of an announced surface only") {
        JobQueue queue;
        queue.announce(4, 1);
        queue.add(frame_showing(5, 7));
        queue.add(frame_showing(4, 2));
        CHECK(order_of(queue) == std::vector<std::string>{"draw 5.7"});
        CHECK(queue.size() == 1);
        queue.add_removal(4);  // Ends the wait.
        CHECK(order_of(queue) == std::vector<std::string>{"draw 4.2", "remove 4"});
        CHECK(queue.empty());
    }

    TEST_CASE("a measurement comes after all other jobs, and a newer one replaces it") {
        JobQueue queue;
        queue.set_measurement(MeasureJob{});
        queue.set_measurement(MeasureJob{});
        queue.add(RemoveJob{4});
        CHECK(queue.size() == 2);
        CHECK(order_of(queue) == std::vector<std::string>{"remove 4", "measure"});
    }

    TEST_CASE("clearing returns the jobs that owe an answer and forgets announcements") {
        JobQueue queue;
        queue.announce(4, 1);
        queue.add(RemoveJob{5});
        queue.add(frame_showing(4, 2));
        queue.add(FetchJob{4});
        queue.set_measurement(MeasureJob{});
        const std::vector<Job> owed = queue.clear();
        REQUIRE(owed.size() == 3);
        CHECK(std::holds_alternative<DrawJob>(owed[0]));
        CHECK(std::holds_alternative<FetchJob>(owed[1]));
        CHECK(std::holds_alternative<MeasureJob>(owed[2]));
        CHECK(queue.empty());
        queue.add(frame_showing(4, 2));
        CHECK(queue.front() != nullptr);
    }
}
