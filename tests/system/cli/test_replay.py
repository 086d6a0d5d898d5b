#!/usr/bin/env python3
"""Recorded runs, replayed, compared and shrunk: real processes, whole and killed, right and wrong.

usage: test_replay.py BIN_DIR PLANTED_DIR [unittest arguments]

PLANTED_DIR holds a pxpl5-renderer that is wrong on purpose.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
PLANTED = pathlib.Path(sys.argv.pop(1)).resolve()
LIMIT_S = 280
MUSCLE = "load phantom:pelvis; surface muscle; "


def replay_lines(text):
    """(frame, executor, regions, compared, differ, digest) of each line of `trace replay`."""
    pattern = (r"frame +(\d+) +(\w+) +regions +(\d+), compared +(\d+), differ +(\d+) .*"
               r"digest (of the whole frame unknown|[0-9a-f]{16})")
    return re.findall(pattern, text)


class Replay(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="pxpl5-replay-")
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def pxpl5(self, *arguments, binaries=BIN):
        return subprocess.run([binaries / "pxpl5", *arguments], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=self.folder.name)

    def record(self, name, commands, topology="one-of-each", binaries=BIN):
        """Runs commands with --record full: the run's folder, and its digests of frames."""
        done = self.pxpl5("run", "--record", "full", "--topology", topology, "--run-folder",
                          self.path(name), "-c", commands, binaries=binaries)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs = list(pathlib.Path(self.path(name)).iterdir())
        self.assertEqual(len(runs), 1)
        return runs[0], re.findall(r"^frame ([0-9a-f]{16})$", done.stdout, re.MULTILINE)

    def planted_binaries(self):
        """The program with the wrong Renderer beside it."""
        folder = pathlib.Path(self.path("wrong-bin"))
        folder.mkdir()
        shutil.copy(BIN / "pxpl5", folder)  # A link would lead back to the right ones.
        for name in ("pxpl5-gp", "pxpl5-framebuffer", "pxpl5-io"):
            if (BIN / name).exists():
                (folder / name).symlink_to(BIN / name)
        (folder / "pxpl5-renderer").symlink_to(PLANTED / "pxpl5-renderer")
        return folder

    def test_muscle_on_the_paper_machine_gives_its_hashes_again(self):
        run, digests = self.record("muscle", MUSCLE + "digest; view 40 10; digest",
                                   topology="paper-1993")
        self.assertEqual(len(digests), 2)
        self.assertNotEqual(*digests)
        done = self.pxpl5("trace", "replay", str(run), "--executor", "both")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        lines = replay_lines(done.stdout)
        for line in lines:
            self.assertEqual(line[2:5], ("16", "16", "0"), done.stdout)
        for executor in ("reference", "fast"):
            self.assertEqual([line[5] for line in lines if line[1] == executor], digests)

    def test_a_small_picture_gives_its_hash_again_on_both_executors(self):
        run, digests = self.record(
            "small", "size 160x150; load phantom:pelvis; surface bone; digest")
        done = self.pxpl5("trace", "replay", str(run), "--executor", "both", "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        report = json.loads(done.stdout)
        self.assertTrue(report["agrees"])
        found = {(f["executor"], f["digest"], f["recorded"]) for f in report["frames"][-2:]}
        self.assertEqual(found, {(e, digests[-1], digests[-1]) for e in ("reference", "fast")})

    def test_a_killed_run_is_replayed_up_to_the_cut(self):
        started = subprocess.Popen(
            [BIN / "pxpl5", "run", "--record", "full", "--topology", "one-of-each", "--run-folder",
             self.path("killed"), "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            cwd=self.folder.name, start_new_session=True)
        self.addCleanup(started.stdout.close)
        self.addCleanup(started.stdin.close)
        started.stdin.write("size 200x200\nload phantom:pelvis\nsurface bone\n" +
                            "".join(f"view {20 * i} 5\ndigest\n" for i in range(12)))
        started.stdin.flush()
        digests = []
        while len(digests) < 12:
            digests += re.findall(r"^frame ([0-9a-f]{16})$", started.stdout.readline())
        os.killpg(started.pid, signal.SIGKILL)  # All processes of the machine at once.
        started.wait()
        run = next(pathlib.Path(self.path("killed")).iterdir())
        for trace in (run / "traces").iterdir():
            trace.write_bytes(trace.read_bytes()[:-7])  # The disk was full, too.
        done = self.pxpl5("trace", "replay", str(run))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("not recorded: ", done.stdout)
        known = [line[5] for line in replay_lines(done.stdout) if "whole" not in line[5]]
        self.assertGreater(len(known), 0, done.stdout)
        self.assertTrue(set(known) <= set(digests), done.stdout)

    def test_machines_of_other_sizes_do_not_differ_and_other_pictures_do(self):
        commands = "size 200x200; load phantom:sphere; surface ball iso=100; digest"
        one, _ = self.record("one", commands)
        many, _ = self.record("many", commands, topology="default")
        same = self.pxpl5("trace", "diff", str(one), str(many))
        self.assertEqual(same.returncode, 0, same.stdout + same.stderr)
        self.assertIn("no difference", same.stdout)
        other, _ = self.record("other", commands.replace("=100", "=101"))
        differs = self.pxpl5("trace", "diff", str(one), str(other))
        self.assertEqual(differs.returncode, 1, differs.stdout + differs.stderr)
        self.assertIn("isovalue is 100 in A, isovalue is 101 in B", differs.stdout)

    def test_a_wrong_renderer_is_found(self):
        commands = "size 200x200; load phantom:pelvis; surface muscle; digest"
        right, right_digest = self.record("right", commands)
        wrong, wrong_digest = self.record("wrong", commands, binaries=self.planted_binaries())
        self.assertNotEqual(right_digest, wrong_digest)
        differs = self.pxpl5("trace", "diff", str(right), str(wrong))
        self.assertEqual(differs.returncode, 1, differs.stdout + differs.stderr)
        self.assertIn("the programs are the same, the pixels differ", differs.stdout)
        self.assertIn("B is wrong: renderer-0", differs.stdout)
        self.assertIn("of this program agree on the region", differs.stdout)
        replayed = self.pxpl5("trace", "replay", str(wrong))
        self.assertEqual(replayed.returncode, 1, replayed.stdout)
        healthy = self.pxpl5("trace", "diff", str(wrong), "--executors", "reference,fast")
        self.assertEqual(healthy.returncode, 0, healthy.stdout)

    def test_a_pixel_of_a_run_shrinks_to_files_that_say_the_same(self):
        run, _ = self.record(
            "pixel", "size 200x200; load phantom:sphere; surface ball iso=100; digest")
        done = self.pxpl5("trace", "shrink", str(run), "--pixel", "100,100", "--field", "surface",
                          "-o", self.path("shrunk"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        again = self.pxpl5("trace", "shrink", self.path("shrunk.pxasm"), "--pixel", "100,100",
                           "--field", "surface", "--is", "1")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        instructions = [line for line in again.stdout.splitlines() if not line.startswith(";")]
        self.assertLessEqual(len(instructions), 3, again.stdout)
        nothing = self.pxpl5("trace", "shrink", self.path("shrunk.pxasm"))
        self.assertEqual(nothing.returncode, 1)
        self.assertIn("reference and fast leave the same", nothing.stderr)

    def test_wrong_command_lines_are_refused(self):
        for arguments, code, text in (
                (("trace", "diff", "nowhere"), 64, "a second run"),
                (("trace", "replay", "nowhere"), 65, "nowhere"),
                (("trace", "replay", "nowhere", "--executor", "slow"), 64, "executor 'slow'"),
                (("trace", "shrink", "nowhere", "--executors", "fast"), 64, "give two executors")):
            done = self.pxpl5(*arguments)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(text, done.stderr)


if __name__ == "__main__":
    unittest.main()
