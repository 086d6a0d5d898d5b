// Tests a session's history: lines of its script, and steps of undo.
#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/session/history/history.hpp"

using namespace pxpl5::host;

namespace {

/// A session without a machine: each line moves the camera's zoom, so that each is a step.
struct Memory {
    Scene scene;
    History history;

    void does(const std::string& line, double zoom) {
        const Arguments arguments = parse_line(line);
        const Scene before = scene;
        scene.camera.zoom = zoom;
        history.note({line, subject_of(arguments), kind_of(arguments) == CommandKind::action},
                     before, scene);
    }
    void undo() {
        const Scene before = scene;
        scene = history.before_last();
        history.undone(before);
    }
    void redo() {
        const Scene before = scene;
        scene = history.after_next();
        history.redone(before);
    }
};

std::string subject(const char* line) {
    return subject_of(parse_line(line));
}

}  // namespace

TEST_SUITE("host/history") {
    TEST_CASE("a subject is a command, the words that name a thing, and what is set of it") {
        CHECK(subject("surface bone iso=3") == subject("surface bone iso=250"));
        CHECK(subject("surface bone iso=3") != subject("surface skin iso=3"));
        CHECK(subject("surface bone iso=3") != subject("surface bone opacity=0.5"));
        CHECK(subject("view 10 20") == subject("view 30 40"));
        // Or the angles of the first would be lost.
        CHECK(subject("view 10 20 zoom=2") != subject("view zoom=3"));
        CHECK(subject("clip L 3") != subject("clip R 3"));
        CHECK(subject("snapshot a.png").empty());
    }

    TEST_CASE("what is switched off is an action: lights behind it are counted anew") {
        CHECK(kind_of(parse_line("light 1 20 30")) == CommandKind::setting);
        CHECK(kind_of(parse_line("light 1 off")) == CommandKind::action);
        CHECK(kind_of(parse_line("light three-point")) == CommandKind::action);
        CHECK(kind_of(parse_line("clip off")) == CommandKind::action);
    }

    TEST_CASE("a drag is one line and one step, whatever it passed") {
        Memory memory;
        memory.does("material power=1", 2);
        memory.does("view zoom=3", 3);
        memory.does("view zoom=4", 4);
        memory.does("view zoom=5", 5);
        CHECK(memory.history.script() == "material power=1\nview zoom=5\n");
        memory.undo();
        CHECK(memory.scene.camera.zoom == 2);
        memory.redo();
        CHECK(memory.scene.camera.zoom == 5);
    }

    TEST_CASE("a mark ends a step, and the script has it where it would be missed") {
        Memory memory;
        memory.does("view zoom=3", 3);
        memory.history.mark();
        memory.does("view zoom=4", 4);
        memory.history.mark();
        memory.does("material power=1", 5);
        CHECK(memory.history.script() == "view zoom=3\nmark\nview zoom=4\nmaterial power=1\n");
        memory.undo();
        memory.undo();
        CHECK(memory.scene.camera.zoom == 3);
    }

    TEST_CASE("an undone line is gone from the script, unless something was done with it") {
        Memory memory;
        memory.does("view zoom=3", 3);
        memory.undo();
        CHECK(memory.history.script().empty());
        memory.redo();
        CHECK(memory.history.script() == "view zoom=3\n");
        memory.does("snapshot a.png", 3);
        memory.undo();
        CHECK(memory.history.script() == "view zoom=3\nsnapshot a.png\nundo\n");
        memory.redo();
        CHECK(memory.history.script() == "view zoom=3\nsnapshot a.png\n");
        memory.undo();
        memory.does("snapshot b.png", 1);
        memory.redo();
        CHECK(memory.history.script() ==
              "view zoom=3\nsnapshot a.png\nundo\nsnapshot b.png\nview zoom=3\n");
    }

    TEST_CASE("after an undo, the same setting is a step of its own") {
        Memory memory;
        memory.does("view zoom=3", 3);
        memory.does("material power=1", 4);
        memory.undo();
        memory.does("view zoom=5", 5);
        CHECK(memory.history.script() == "view zoom=3\nmark\nview zoom=5\n");
        memory.undo();
        CHECK(memory.scene.camera.zoom == 3);
    }

    TEST_CASE("a change forgets what could be done again, and a load also what could be undone") {
        Memory memory;
        memory.does("view zoom=3", 3);
        memory.undo();
        memory.does("view zoom=4", 4);
        CHECK(!memory.history.redo_line());
        CHECK_THROWS_AS(memory.history.after_next(), RequestError);
        CHECK(memory.history.undo_line() == "view zoom=4");
        memory.history.begin_anew("load phantom:sphere");
        CHECK(!memory.history.undo_line());
        CHECK_THROWS_AS(memory.history.before_last(), RequestError);
        CHECK(memory.history.load_line() == "load phantom:sphere");
    }

    TEST_CASE("a setting that changes nothing, and a question, leave no line") {
        Memory memory;
        memory.does("view zoom=1", memory.scene.camera.zoom);
        memory.does("stats", memory.scene.camera.zoom);
        CHECK(memory.history.script().empty());
        CHECK(!memory.history.undo_line());
    }

    TEST_CASE("the size of the picture is in the script, and no step") {
        Memory memory;
        const Scene before = memory.scene;
        memory.scene.size = {64, 64};
        memory.history.note({"size 64x64", "size *", false}, before, memory.scene);
        CHECK(memory.history.script() == "size 64x64\n");
        CHECK(!memory.history.undo_line());
    }

    TEST_CASE("a surface that a failed command lost is lost in the script") {
        Memory memory;
        Scene before = memory.scene;
        before.surfaces.emplace_back().name = "fine bone";
        memory.history.note_losses(before, memory.scene);
        CHECK(memory.history.script() == "remove 'fine bone'\n");
    }

    TEST_CASE("the oldest steps are forgotten beyond the limit") {
        Memory memory;
        for (std::size_t i = 0; i < max_undo_steps + 7; ++i) {
            memory.history.mark();
            memory.does("view zoom=2", 2 + static_cast<double>(i));
        }
        for (std::size_t i = 0; i < max_undo_steps; ++i) {
            memory.undo();
        }
        CHECK(memory.scene.camera.zoom == 2 + 6);
        CHECK(!memory.history.undo_line());
    }
}
