#!/usr/bin/env python3
"""Nodes that are replaced, given up, added and retired: test_restart.py BIN_DIR [unittest's]."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from processes import children_of, name_of

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
ARCHIVE = pathlib.Path(__file__).resolve().parents[3] / "host/phigs/archives/molecule.phigs"
LIMIT_S = 120
TWO_OF_EACH = ("--set", "gp.count=2", "--set", "renderer.count=2")
SCENE = ("load phantom:pelvis", "surface skin iso=-300 opacity=0.5 rim=0.5", "surface bone iso=250",
         "components bone show=largest", "view 30 20 zoom=1.5", "clip L 10", "planes z=20 y=60",
         "light 1 off",
         "background white", "size 200x160", "antialias 4")
ROLES = {"gp": "pxpl5-gp", "renderer": "pxpl5-renderer", "frame_buffer": "pxpl5-framebuff"}


def policy(role, word, most=3):
    return ("--set", f"{role}.restart.policy={word}", "--set", f"{role}.restart.max={most}")


class Restarts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_lines(self, lines, *words):
        """Exit code, replies and standard error."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", *TWO_OF_EACH,
             *words, "-c", "; ".join(lines)], capture_output=True, text=True, check=False,
            timeout=LIMIT_S, env={**os.environ, "XDG_RUNTIME_DIR": str(self.folder)})
        self.assertEqual(list(self.folder.glob("pxpl5-*")), [], "folders of sockets are left")
        return done.returncode, [json.loads(line) for line in done.stdout.splitlines()], done.stderr

    def answers(self, lines, *words):
        """The results of commands that all succeed."""
        code, replies, complaint = self.run_lines(lines, *words)
        self.assertEqual([each["error"] for each in replies if not each["ok"]], [])
        self.assertEqual(code, 0, complaint)
        self.assertEqual(len(replies), len(lines))
        return replies

    def test_everything_is_restored_after_any_node_dies(self):
        before = self.answers([*SCENE, "digest"])[-1]["result"]
        for node in ("gp-0", "gp-1", "renderer-0", "renderer-1", "framebuffer-0"):
            with self.subTest(node=node):
                replies = self.answers([*SCENE, f"kill {node}", "digest", "stats", "undo",
                                        "redo", "digest"])
                answer = replies[len(SCENE) + 1]
                self.assertEqual(answer["result"], before)
                self.assertEqual(replies[-1]["result"], before)
                (restart,) = answer["restarts"]
                self.assertEqual(restart["node"], node)
                self.assertIn(f"{node} was killed by signal 9", restart["cause"])
                self.assertEqual([restart["gps"], restart["renderers"]], [2, 2])
                self.assertNotIn("restarts", replies[-1])

    def test_a_pair_is_drawn_again_after_either_frame_buffer_dies(self):
        """With a frame buffer for each eye the pair has the bits that one frame buffer gives it."""
        pair = [*SCENE, "stereo sbs"]
        before = self.answers([*pair, "digest"])[-1]["result"]
        two = ("--set", "frame_buffer.count=2")
        for node in ("framebuffer-0", "framebuffer-1"):
            with self.subTest(node=node):
                replies = self.answers([*pair, "digest", f"kill {node}", "digest"], *two)
                self.assertEqual([replies[-3]["result"], replies[-1]["result"]], [before, before])
                (restart,) = replies[-1]["restarts"]
                self.assertEqual(restart["node"], node)
                self.assertIn(f"{node} was killed by signal 9", restart["cause"])
        code, replies, _ = self.run_lines([*pair, "kill framebuffer-1", "digest"], *two,
                                          *policy("frame_buffer", "end"))
        self.assertEqual(code, 137)
        self.assertIn("framebuffer-1 was killed by signal 9", replies[-1]["error"])

    def test_the_user_reads_of_it_on_standard_error(self):
        _, _, complaint = self.run_lines(["load phantom:sphere", "kill gp-1", "surface a iso=0.5"])
        first, second = complaint.splitlines()
        self.assertRegex(first, r"^warning: gp-1 was killed by signal 9 \(SIGKILL\) \(log: .*"
                                r"gp-1\.log\).*\. The machine is started again \(restart 1 of 3\)$")
        self.assertRegex(second, r"^note: The machine runs again with 2 GPs, 2 Renderers\. "
                                 r"Everything is restored after \d+ ms$")

    def test_the_user_reads_of_the_pause_before_another_restart(self):
        _, _, complaint = self.run_lines(
            ["load phantom:sphere", "kill gp-1", "surface a iso=0.5", "kill gp-1", "digest"],
            "--set", "gp.restart.backoff_ms=20")
        first, _, third, _ = complaint.splitlines()
        self.assertIn("The machine is started again (restart 1 of 3)", first)
        self.assertIn("The machine is started again after a pause of 0.02 s (restart 1 of 3)",
                      third)

    def test_kill_states_what_the_machine_does(self):
        for word, outcome in (("replace", "is started again"), ("end", "stops")):
            done = subprocess.run(
                [BIN / "pxpl5", "run", "--run-folder", self.folder / "run", *TWO_OF_EACH,
                 *policy("gp", word), "-c", "kill gp-1"], capture_output=True, text=True,
                check=False, timeout=LIMIT_S)
            self.assertEqual(done.stdout, f"gp-1 killed; the machine {outcome}\n")

    def test_an_archive_is_restored(self):
        load = f"load '{ARCHIVE}'"
        scene = [load, "view 20 10", "clip L 10"]
        before = self.answers([*scene, "digest"])[-1]["result"]
        after = self.answers([*scene, "kill gp-0", "digest"])[-1]["result"]
        self.assertEqual(after, before)

    def test_an_archive_that_has_gone_is_told_and_the_session_goes_on(self):
        copy = self.folder / "m.phigs"
        shutil.copy(ARCHIVE, copy)
        with subprocess.Popen(
                [BIN / "pxpl5", "run", "--json", "--keep-going", "--run-folder",
                 self.folder / "run", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, text=True) as program:
            def ask(line):
                program.stdin.write(line + "\n")
                program.stdin.flush()
                return json.loads(program.stdout.readline())
            self.assertTrue(ask(f"load '{copy}'")["ok"])
            copy.unlink()
            self.assertTrue(ask("kill gp-0")["ok"])
            answer = ask("digest")
            self.assertFalse(answer["ok"])
            # The host notices the death while it waits for this line, or afterwards.
            self.assertRegex(answer["error"],
                             "no volume is loaded|its content cannot be restored: .*m.phigs")
            (restart,) = answer["restarts"]
            self.assertFalse(restart["restored"])
            self.assertTrue(ask("load phantom:sphere")["ok"])
            self.assertTrue(ask("surface a iso=0.5")["ok"])
            self.assertTrue(ask("digest")["ok"])
            program.stdin.close()
            self.assertEqual(program.wait(LIMIT_S), 65)

    def test_a_machine_may_go_on_with_fewer_nodes(self):
        before = self.answers([*SCENE, "digest"])[-1]["result"]
        for node, counts in (("gp-0", [1, 2]), ("renderer-1", [2, 1])):
            with self.subTest(node=node):
                role = node.split("-", maxsplit=1)[0]
                replies = self.answers([*SCENE, f"kill {node}", "digest"],
                                       *policy(role, "degrade"))
                (restart,) = replies[-1]["restarts"]
                self.assertEqual([restart["gps"], restart["renderers"]], counts)
                self.assertEqual(replies[-1]["result"], before)

    def test_the_last_node_of_a_role_cannot_be_given_up(self):
        code, replies, complaint = self.run_lines(
            ["load phantom:sphere", "surface a iso=0.5", "kill gp-0", "digest", "kill gp-0",
             "digest"], *policy("gp", "degrade"))
        self.assertEqual(code, 137)
        self.assertTrue(replies[3]["ok"])
        self.assertFalse(replies[5]["ok"])
        self.assertIn("The machine cannot continue without it: it was the last GP", complaint)

    def test_fewer_nodes_that_cannot_hold_the_volume_are_told(self):
        """Six GPs of 1 MiB hold the volume, five do not."""
        small = ("--set", "gp.count=6", "--set", "gp.memory_mib=1", "--keep-going")
        _, replies, _ = self.run_lines(
            ["load phantom:letters", "kill gp-1", "digest", "digest", "load phantom:sphere",
             "surface a iso=0.5", "digest"], *policy("gp", "degrade"), *small)
        self.assertEqual([each["ok"] for each in replies], [True] * 2 + [False] * 2 + [True] * 3)
        self.assertIn("its content cannot be restored: phantom:letters", replies[2]["error"])
        self.assertIn("no volume is loaded", replies[3]["error"])

    def test_a_scale_that_fails_leaves_the_former_nodes(self):
        """Six GPs of 1 MiB hold the volume, five do not."""
        _, replies, _ = self.run_lines(
            ["load phantom:letters", "surface a iso=500", "digest", "scale gp=-1", "digest"],
            "--set", "gp.count=6", "--set", "gp.memory_mib=1", "--keep-going")
        self.assertEqual([each["ok"] for each in replies], [True] * 3 + [False, True])
        self.assertIn("The machine has its former nodes again", replies[3]["error"])
        self.assertEqual(replies[4]["result"], replies[2]["result"])

    def test_too_many_restarts_end_the_machine(self):
        code, replies, complaint = self.run_lines(
            ["load phantom:sphere", "surface a iso=0.5", "kill renderer-0", "digest"],
            *policy("renderer", "replace", 0))
        self.assertEqual(code, 137)
        self.assertFalse(replies[-1]["ok"])
        self.assertIn("renderer.restart.max is 0, and --set renderer.restart.max=N changes this",
                      complaint)

    def test_a_dying_load_is_begun_again(self):
        """The load finds the death."""
        other = self.answers(["load phantom:torus", "surface a iso=0.5", "digest"])[-1]["result"]
        replies = self.answers(["load phantom:sphere", "surface a iso=0.5", "kill gp-0",
                                "load phantom:torus", "surface a iso=0.5", "digest"])
        self.assertEqual(len(replies[3]["restarts"]), 1)
        self.assertEqual(replies[-1]["result"], other)

    def test_a_script_that_is_played_is_not_repeated(self):
        script = self.folder / "script"
        script.write_text("surface a iso=0.5\nkill gp-0\nview 10 10\nsurface b iso=0.2\n")
        replies = self.answers(["load phantom:sphere", f"play {script}", "history"])
        self.assertEqual(len(replies[1]["restarts"]), 1)
        self.assertEqual(replies[2]["result"]["script"].count("surface a"), 1)
        self.assertEqual(replies[2]["result"]["script"].count("view 10 10"), 1)

    def test_scale_keeps_every_bit(self):
        before = self.answers([*SCENE, "digest"])[-1]["result"]
        replies = self.answers([*SCENE, "scale gp=+2 renderer=-1", "digest", "scale gp=1",
                                "digest", "scale renderer=+4", "digest", "scale"])
        scaled = replies[len(SCENE):]
        self.assertEqual([[each["result"]["gps"], each["result"]["renderers"]]
                          for each in scaled[::2]], [[4, 1], [1, 1], [1, 5], [1, 5]])
        for each in scaled[1::2]:
            self.assertEqual(each["result"], before)

    def test_scale_refuses_what_is_no_machine(self):
        for words, error in (("gp=-2", "gp is '-2', which makes 0 of 2, must make 1..64"),
                             ("renderer=65", "renderer is '65', which makes 65 of 2"),
                             ("gp=+100000", "which makes 100002 of 2, must make 1..64"),
                             ("gp=two", "gp is 'two', must be a count"),
                             ("gp=+", "gp is '+', must be a count")):
            with self.subTest(words=words):
                code, replies, _ = self.run_lines(
                    ["load phantom:sphere", "surface a iso=0.5", f"scale {words}", "digest"],
                    "--keep-going")
                self.assertEqual(code, 64)
                self.assertIn(error, replies[2]["error"])
                self.assertTrue(replies[3]["ok"])
                self.assertNotIn("restarts", replies[3])

    def test_stopped_nodes_are_replaced(self):
        before = self.answers([*SCENE, "digest"])[-1]["result"]
        for role, program in ROLES.items():
            with self.subTest(role=role), subprocess.Popen(
                    [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run",
                     *TWO_OF_EACH, "--set", "heartbeat.interval_ms=100", "--set",
                     "heartbeat.misses=20", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL, text=True) as host:
                host.stdin.write("\n".join(SCENE) + "\n")
                host.stdin.flush()
                for _ in SCENE:
                    self.assertTrue(json.loads(host.stdout.readline())["ok"])
                children = children_of(host.pid)
                victim = next(pid for pid in children if name_of(pid) == program)
                os.kill(victim, signal.SIGSTOP)
                host.stdin.write("digest\n")
                host.stdin.close()
                answer = json.loads(host.stdout.readline())
                self.assertEqual(answer["result"], before)
                self.assertIn("does not answer", answer["restarts"][0]["cause"])
                self.assertEqual(host.wait(LIMIT_S), 0)
                for pid in children:
                    self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())


if __name__ == "__main__":
    unittest.main()
