// An io process that sends lawful messages at the wrong time.
#include <doctest/doctest.h>

#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

/// A machine whose io process answers each request with `answers`.
class UnsoundMachine final : public MachinePort {
  public:
    const std::vector<bus::NodeId>& gp_ids() const override { return ids_; }
    const std::vector<bus::NodeId>& renderer_ids() const override { return ids_; }
    const std::vector<bus::NodeId>& frame_buffer_ids() const override { return ids_; }
    void send(bus::NodeId to, bus::Payload payload) override {
        is_asked_ = is_asked_ || to == io_id;
        const auto* end = schema::GetMessage(payload.bytes().data())->body_as_SceneEnd();
        scene_ = end == nullptr ? scene_ : end->scene();
    }
    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override {
        while (!done()) {
            if (scene_ != 0) {  // The GP has taken the empty scene after a failed load.
                schema::VolumeReadyT ready;
                ready.volume = scene_;
                take(test::WireBytes(bus::pack(ready)).read());
                continue;
            }
            if (!is_asked_ || answers.empty()) {
                throw MachineError(1, "no answer is left");
            }
            const bus::Payload answer = answers.front();
            answers.pop_front();
            take(test::WireBytes(answer).read());
        }
    }
    void wait_readable(int) override {}
    void prepare_io() override {}
    bus::NodeId start_io(ExitCode) override { return io_id; }
    void release_io() override { ++released; }
    bool takes_more(bus::NodeId) const override { return true; }
    void allow_cancel(bool) override {}
    void watch(int, std::function<bool()>) override {}
    bool is_recording() const override { return false; }
    SavedTraces save_traces() override { return {}; }

    static constexpr bus::NodeId io_id = 9;
    std::deque<bus::Payload> answers;
    int released = 0;

  private:
    bool is_asked_ = false;
    std::uint32_t scene_ = 0;  ///< The last scene that was sent whole.
    std::vector<bus::NodeId> ids_ = {3};
};

/// A header whose values the io process sends.
schema::VolumeHeaderT whole_header() {
    schema::VolumeHeaderT header = test::example_header();
    header.stored.reset();
    header.reduction = 1;
    return header;
}

/// The messages of volumes of a series of three, by their numbers.
std::deque<bus::Payload> volumes_of(const std::vector<std::uint32_t>& frames) {
    std::deque<bus::Payload> messages;
    schema::VolumeHeaderT header = whole_header();
    header.frames = 3;
    header.times_ms.resize(3);
    schema::SlicesT slices;
    slices.volume = header.volume;
    slices.slice_count = header.nz;
    slices.values.resize(std::size_t{4} * header.nx * header.ny * header.nz);
    schema::VolumeEndT end;
    end.volume = header.volume;
    for (const std::uint32_t frame : frames) {
        header.frame = frame;
        messages.push_back(bus::pack(header));
        messages.push_back(bus::pack(slices));
        messages.push_back(bus::pack(end));
    }
    return messages;
}

/// A request for three volumes of a series.
struct Reading {
    Reading() { options.volumes = 3; }
    UnsoundMachine machine;
    Session session{machine};
    VolumeReader reader{session.conversation, session.io, session.load_settings};
    ImportOptions options;
};

}  // namespace

TEST_SUITE("host/session/unsound_io") {
    TEST_CASE("a second header during an import ends the request") {
        UnsoundMachine machine;
        schema::VolumeHeaderT larger = whole_header();
        larger.nx *= 2;
        machine.answers = {bus::pack(whole_header()), bus::pack(larger)};
        Session session(machine);
        CHECK_THROWS_WITH_AS(session.volumes.load("scan.nrrd"),
                             "the io process announced a volume that was not due", RequestError);
        CHECK(machine.released == 1);
    }

    TEST_CASE("of several volumes, no more are taken than were asked for or the series has") {
        Reading reading;
        auto& [machine, session, reader, options] = reading;
        machine.answers = volumes_of({1, 2, 3, 1});
        CHECK(reader.read_several("scan.nrrd", options).size() == 3);
        CHECK(machine.answers.size() == 3);
        machine.answers = volumes_of({2, 3, 1});
        const std::vector<Volume> rest = reader.read_several("scan.nrrd", options);
        REQUIRE(rest.size() == 2);
        CHECK(machine.answers.size() == 3);
        CHECK(rest[1].frame == 3);
        CHECK(rest[1].source == std::filesystem::absolute("scan.nrrd").string());
        CHECK(machine.released == 2);
    }

    TEST_CASE("several volumes that do not follow each other end the request") {
        Reading reading;
        auto& [machine, session, reader, options] = reading;
        machine.answers = volumes_of({1, 3});
        CHECK_THROWS_WITH_AS(reader.read_several("scan.nrrd", options),
                             doctest::Contains("volume 3 of 3 with 4 x 5 x 6 voxels follows volume "
                                               "1 of 3"),
                             IoFailure);
        machine.answers = volumes_of({1});
        schema::VolumeHeaderT larger = whole_header();
        larger.frames = 3;
        larger.times_ms.resize(3);
        larger.frame = 2;
        larger.nx *= 2;
        machine.answers.push_back(bus::pack(larger));
        CHECK_THROWS_WITH_AS(reader.read_several("scan.nrrd", options),
                             doctest::Contains("volume 2 of 3 with 8 x 5 x 6 voxels follows"),
                             IoFailure);
        schema::IoDoneT broken;
        broken.error = "broken";
        machine.answers = volumes_of({1, 2});
        machine.answers.push_back(bus::pack(broken));
        CHECK_THROWS_WITH_AS(reader.read_several("scan.nrrd", options), "broken", IoFailure);
    }

    TEST_CASE("a data file that was not due ends the request") {
        UnsoundMachine machine;
        machine.answers = {bus::pack(test::example_header())};
        Session session(machine);
        ImportOptions options;
        options.read = ReadBy::host;
        CHECK_THROWS_WITH_AS(session.volumes.load("scan.nrrd", options),
                             "scan.nrrd: the io process states that the GPs read the values from "
                             "/data/pelvis.raw, but the request has read=host, so that the host "
                             "reads them. Load it again",
                             RequestError);
        CHECK(machine.released == 1);
    }

    TEST_CASE("a volume instead of a written file ends the request, and the next import works") {
        UnsoundMachine machine;
        machine.answers = {bus::pack(whole_header())};
        Session session(machine);
        CHECK_THROWS_WITH_AS(session.io.write("x.png", bus::pack(schema::ReadMeshT{{}, "x"})),
                             "the io process announced a volume that was not due", RequestError);
        schema::IoDoneT done;
        done.error = "as ordered";
        machine.answers = {bus::pack(whole_header()), bus::pack(done)};
        CHECK_THROWS_WITH_AS(session.volumes.load("scan.nrrd"), "as ordered", RequestError);
    }

    TEST_CASE("an answer without a mesh, or with none in it, ends the request") {
        UnsoundMachine machine;
        Session session(machine);
        schema::IoDoneT done;
        done.ok = true;
        schema::MeshContentT nothing;
        for (const std::deque<bus::Payload>& answers :
             {std::deque{bus::pack(done)}, std::deque{bus::pack(nothing), bus::pack(done)}}) {
            machine.answers = answers;
            CHECK_THROWS_WITH_AS(session.exports.read_mesh("x.stl"),
                                 "x.stl: the io process answered with 0 meshes instead of one",
                                 RequestError);
        }
    }

    TEST_CASE("an answer without the content of an archive ends the request") {
        UnsoundMachine machine;
        Session session(machine);
        schema::IoDoneT done;
        done.ok = true;
        for (const std::deque<bus::Payload>& answers :
             {std::deque{bus::pack(done)},
              std::deque{bus::pack(schema::MeshContentT{}), bus::pack(done)}}) {
            machine.answers = answers;
            CHECK_THROWS_WITH_AS(
                session.volumes.load("a.phigs"),
                "a.phigs: the io process answered without the content of the archive",
                RequestError);
        }
    }

    TEST_CASE("content of another kind than the request's is dropped") {
        UnsoundMachine machine;
        Session session(machine);
        schema::IoDoneT done;
        done.ok = true;
        for (const bus::Payload& payload : test::one_of_each_kind()) {
            if (payload.kind() == bus::Body::ArchiveContent) {
                machine.answers = {payload, bus::pack(done)};
            }
        }
        REQUIRE(machine.answers.size() == 2);
        const IoOutcome read = session.io.read("x.stl", bus::pack(schema::ReadMeshT{{}, "x.stl"}));
        CHECK(!read.content);
    }

    TEST_CASE("only names that end in .phigs are archives") {
        CHECK(is_archive("a.phigs"));
        CHECK(is_archive("x/A.PHIGS"));
        CHECK(!is_archive(".phigs"));
        CHECK(!is_archive("a.phigs.nrrd"));
    }
}
