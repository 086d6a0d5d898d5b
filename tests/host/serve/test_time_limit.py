#!/usr/bin/env python3
"""The end of a job: test_time_limit.py FOLDER_OF_BINARIES [words].

`pxpl5 serve` warns before something ends it, saves the session, and opens it again.
"""
import calendar
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "system/cli"))
import test_serve  # noqa: E402

LIMIT_S, POLL_S = 60, 0.05
ENDS = re.compile(r"warning: This session ends (at (\S+Z)|soon): (.+)\.\n")
# A busy computer may hold up a process of the machine for some seconds.
SLOW = re.compile(r"warning: \S+ \(process \d+\) has not answered for .*\n")
SAVED = re.compile(r"note: the session is saved in (\S+)\. "
                   r"Open it again with: pxpl5 serve --session (\S+)\n")


def stop(program, by=signal.SIGINT):
    """Its exit code, and what it complained of, without the warnings of a busy computer."""
    code, complaint = program.stop(by)
    return code, SLOW.sub("", complaint)


class TimeLimit(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pxpl5-limit-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        for name in ("SLURM_JOB_ID", "SLURM_JOB_END_TIME"):
            os.environ.pop(name, None)

    def serve(self, *words, env=()):
        os.environ.update(env)
        program = test_serve.Program(self.folder / "runs", *words)
        for name, _ in env:
            if name.startswith("SLURM"):
                os.environ.pop(name)
        self.addCleanup(program.end)
        return program

    def viewer(self, program, url=None):
        viewer = test_serve.Viewer(url or program.url)
        self.addCleanup(viewer.socket.close)
        return viewer

    def warned(self, viewer):
        """The first state with a saved session."""
        return viewer.until(lambda message: (message.get("state", {}).get("end") or {})
                            .get("open"))["state"]["end"]

    def wait_for_words(self, program, file, words):
        """Reads the file until it has the words, while the program runs."""
        end = time.monotonic() + LIMIT_S
        while words not in file.read_text():
            self.assertLess(time.monotonic(), end, file.read_text())
            with contextlib.suppress(subprocess.TimeoutExpired):
                program.process.wait(POLL_S)
                self.fail(f"ended without '{words}' in {file}")

    def test_a_session_is_saved_before_its_end_and_opens_again(self):
        program = self.serve("phantom:sphere")
        viewer, watcher = self.viewer(program), self.viewer(program, program.watch_url)
        self.assertTrue(viewer.do("surface ball iso=0.3 color=red")["ok"])
        viewer.do("size 120x100")
        reply = viewer.do("view 30 20 zoom=1.5")
        before = viewer.resting(reply["revision"])["digest"]
        program.process.send_signal(signal.SIGUSR1)
        ends = self.warned(viewer)
        self.assertEqual((ends["at"], ends["why"]), ("", "the program has received SIGUSR1"))
        self.assertEqual(self.warned(watcher), ends)
        # What follows the warning is saved, too.
        reply = viewer.do("background white")
        after = viewer.resting(reply["revision"])["digest"]
        self.assertNotEqual(after, before)
        saved = pathlib.Path(ends["open"].removeprefix("pxpl5 serve --session "))
        run, = self.folder.glob("runs/2*")
        self.assertEqual(saved, self.folder / "runs/saved" / f"{run.name}.pxpl5")
        self.wait_for_words(program, saved, "background")
        self.assertEqual(stat.S_IMODE(saved.parent.lstat().st_mode), 0o700)
        shown = subprocess.run(
            [test_serve.BINARIES / "pxpl5", "sessions", "show", "latest", "--json",
             "--run-folder", self.folder / "runs"],
            capture_output=True, text=True, timeout=LIMIT_S, check=True)
        self.assertEqual(json.loads(shown.stdout)["saved"], str(saved))
        code, complaint = stop(program, signal.SIGTERM)
        self.assertEqual(code, 0)
        self.assertEqual(stat.S_IMODE(saved.lstat().st_mode), 0o600)
        self.assertEqual(ENDS.match(complaint)[3], ends["why"])
        self.assertEqual(SAVED.search(complaint).groups(), (str(saved), str(saved)))
        # A slow computer says which nodes still run, too.
        told = [line for line in complaint.splitlines() if not line.startswith("still running")]
        self.assertEqual(len(told), 2, complaint)
        again = self.serve("--session", str(saved))
        viewer = self.viewer(again)
        self.assertEqual(viewer.resting(0)["digest"], after)
        self.assertTrue(viewer.do("load phantom:sphere")["ok"])
        self.assertEqual(stop(again), (0, ""))

    def test_the_user_names_the_limit(self):
        before = time.time()
        program = self.serve("phantom:sphere", "--time-limit", "1:30")
        viewer = self.viewer(program)
        ends = self.warned(viewer)
        self.assertEqual(ends["why"], "--time-limit is reached")
        self.assertEqual(program.stop()[0], 0)
        at = calendar.timegm(time.strptime(ends["at"], "%Y-%m-%dT%H:%M:%SZ"))
        self.assertLessEqual(before + 89, at)
        self.assertLessEqual(at, time.time() + 90)
        wrong = subprocess.run([test_serve.BINARIES / "pxpl5", "serve", "--time-limit", "soon"],
                               capture_output=True, text=True, timeout=LIMIT_S, check=False)
        self.assertEqual(wrong.returncode, 64)
        self.assertIn("--time-limit 'soon' is no duration", wrong.stderr)

    def test_slurm_names_the_limit(self):
        """In the environment, or by its own command."""
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "scontrol").write_text(
            '#!/bin/sh\n[ "$*" = "show job 77" ] && echo "   EndTime=2001-02-03T04:05:06 x"\n')
        (tools / "scontrol").chmod(stat.S_IRWXU)
        path = ("PATH", f"{tools}:{os.environ['PATH']}")
        local = time.mktime(time.strptime("2001-02-03T04:05:06", "%Y-%m-%dT%H:%M:%S"))
        told = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(local))
        for env, at in (((("SLURM_JOB_END_TIME", "1000000000"),), "2001-09-09T01:46:40Z"),
                        ((path,), told)):
            program = self.serve("phantom:sphere", env=(("SLURM_JOB_ID", "77"), *env))
            ends = self.warned(self.viewer(program))
            self.assertEqual((ends["at"], ends["why"]), (at, "job 77 reaches its time limit"))
            self.assertEqual(program.stop()[0], 0)

    def test_a_session_that_cannot_be_saved_is_told_of(self):
        program = self.serve("phantom:sphere")
        (self.folder / "runs/saved").write_text("in the way")
        viewer = self.viewer(program)
        program.process.send_signal(signal.SIGUSR1)
        note = viewer.until(lambda message: "cannot be saved" in str(message.get("note")))["note"]
        self.assertEqual(note["level"], "error")
        self.assertIn("saved", note["text"])
        code, complaint = program.stop()
        self.assertEqual(code, 0)
        self.assertRegex(complaint, "warning: The session cannot be saved: .*saved")

    def test_a_folder_that_others_may_use_gets_no_session(self):
        """In a shared --run-folder, another user may make the folder or a link first."""
        runs, other = self.folder / "runs", self.folder / "other"
        runs.mkdir()
        other.mkdir()
        for make, reason in ((lambda: (runs / "saved").symlink_to(other), "it is a link or a file"),
                             (lambda: ((runs / "saved").mkdir(), (runs / "saved").chmod(0o770)),
                              "it has mode 0770, so others may use it; it must have 0700. Run: ")):
            make()
            program = self.serve("phantom:sphere")
            viewer = self.viewer(program)
            program.process.send_signal(signal.SIGUSR1)
            viewer.until(lambda message: "cannot be saved" in str(message.get("note")))
            code, complaint = program.stop()
            self.assertEqual(code, 0)
            self.assertIn(f"cannot use the folder {runs / 'saved'}: {reason}", complaint)
            self.assertEqual((list(other.iterdir()), list((runs / "saved").iterdir())), ([], []))
            if (runs / "saved").is_symlink():
                (runs / "saved").unlink()

    def test_a_saved_session_needs_no_volume_beside_it(self):
        file = self.folder / "s.pxpl5"
        file.write_text("load phantom:sphere\n")
        for words in (("phantom:sphere",), ("--surface", "ball=0.2")):
            done = subprocess.run([test_serve.BINARIES / "pxpl5", "serve", "--session", file,
                                   *words], capture_output=True, text=True, timeout=LIMIT_S,
                                  check=False)
            self.assertEqual(done.returncode, 64, done.stderr)
            self.assertRegex(done.stderr, "excludes --session|--session excludes")

    def opened(self, file):
        """The program after it has opened a session and ended."""
        return subprocess.run([test_serve.BINARIES / "pxpl5", "serve", "--session", file,
                               "--topology", "one-of-each", "--run-folder",
                               self.folder / "runs"], capture_output=True, text=True,
                              timeout=LIMIT_S, check=False)

    def test_a_session_of_a_stranger_writes_no_file(self):
        file, inner = self.folder / "s.pxpl5", self.folder / "inner.pxpl5"
        inner.write_text(f"history {self.folder}/.bashrc\n")
        for line in (f"history {self.folder}/.bashrc", f"snapshot {self.folder}/x.png",
                     f"export {self.folder}/x.ply", f"orbit 2 {self.folder}/x{{}}.png",
                     f"play {inner}"):
            file.write_text(f"load phantom:sphere\nsurface ball iso=0.2\n{line}\n")
            done = self.opened(file)
            self.assertEqual(done.returncode, 64, done.stderr)
            self.assertRegex(done.stderr, rf"{file}, line 3, '{re.escape(line)}': .*would write "
                                          rf"{self.folder}/.*, but a session that is opened")
        for line in ("computers invite", "computers use n1", "kill gp-0", "scale gp=2"):
            file.write_text(f"load phantom:sphere\n{line}\n")
            done = self.opened(file)
            self.assertEqual(done.returncode, 64, done.stderr)
            self.assertRegex(done.stderr, rf"{file}, line 2, '{re.escape(line)}': .*acts on the "
                                          "machine, but a session that is opened")
        self.assertEqual(sorted(os.listdir(self.folder)), ["inner.pxpl5", "runs", "s.pxpl5"])
        self.assertEqual(list(self.folder.rglob("join.key")), [])


if __name__ == "__main__":
    test_serve.BINARIES = pathlib.Path(sys.argv.pop(1))
    unittest.main()
