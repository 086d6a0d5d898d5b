#!/usr/bin/env python3
"""A user who may start few threads: a machine that does not fit is refused, and no process aborts.

usage: test_few_threads.py BIN    BIN is the folder of pxpl5
"""
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

USER = 64321  # A user without other processes.
UNAVAILABLE = 69
LIMIT_S = 60
SCENE = "load phantom:sphere; surface s iso=0; snapshot a.png; export a.stl"


@unittest.skipUnless(os.geteuid() == 0, "only root can run a program as another user")
class FewThreads(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.programs = pathlib.Path(holder.name) / "programs"
        self.folder = pathlib.Path(holder.name) / "home"
        os.chmod(holder.name, 0o755)
        self.programs.mkdir()
        for program in BIN.glob("pxpl5*"):
            shutil.copy(program, self.programs)
        self.folder.mkdir()
        os.chown(self.folder, USER, USER)

    def run_with(self, soft, hard, *flags, script=SCENE):
        def set_limit():
            resource.setrlimit(resource.RLIMIT_NPROC, (soft, hard))
        names = ("HOME", "TMPDIR", "XDG_STATE_HOME", "XDG_RUNTIME_DIR")
        return subprocess.run(
            [self.programs / "pxpl5", "run", *flags, "-c", script], cwd=self.folder,
            env={**os.environ, **{name: str(self.folder) for name in names}}, user=USER,
            group=USER, extra_groups=[], preexec_fn=set_limit, capture_output=True, text=True,
            timeout=LIMIT_S)

    def needed(self, *flags):
        """The limit that the refusal of a machine asks for."""
        done = self.run_with(5, 10, *flags)
        self.assertEqual(done.returncode, UNAVAILABLE, done.stderr)
        said = re.search(r"needs (\d+) threads, but the limit of this user is 10, and 1 threads "
                         r"run already\. Raise the limit to (\d+) \(ulimit -Hu\)", done.stderr)
        self.assertTrue(said, done.stderr)
        self.assertEqual(int(said[2]), int(said[1]) + 1)
        self.assertEqual(list(self.folder.glob("pxpl5-??????")), [])  # No sockets are left.
        return int(said[2])

    def test_the_named_limit_suffices_and_the_soft_limit_is_raised(self):
        for flags in (["--topology", "one-of-each"],
                      ["--topology", "one-of-each", "--set", "ring.transport=tcp"]):
            needed = self.needed(*flags)
            done = self.run_with(5, needed, *flags)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertTrue((self.folder / "a.png").exists())
            self.assertEqual(self.run_with(5, needed - 1, *flags).returncode, UNAVAILABLE)

    def test_a_large_machine_needs_more(self):
        small = self.needed("--topology", "one-of-each")
        large = self.needed("--topology", "paper-1993")
        self.assertEqual(large - small, 4 * (54 - 4))


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop()).resolve()
    unittest.main()
