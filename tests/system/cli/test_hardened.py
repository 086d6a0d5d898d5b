#!/usr/bin/env python3
"""The protections of the programs: those of compiler and linker, and the sandbox of pxpl5-io.

usage: test_hardened.py FOLDER_OF_BINARIES [words]
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from processes import children_of, name_of  # noqa: E402

BIN = pathlib.Path()  # From the command line.
PROGRAMS = ["pxpl5", "pxpl5-framebuffer", "pxpl5-gp", "pxpl5-io", "pxpl5-renderer"]


def readelf(option, program):
    return subprocess.run(["readelf", "--wide", option, BIN / program], capture_output=True,
                          text=True, check=True).stdout


class Hardened(unittest.TestCase):
    def test_addresses_are_random(self):
        for program in PROGRAMS:
            self.assertRegex(readelf("-h", program), r"Type:\s+DYN", program)
            self.assertRegex(readelf("-d", program), r"FLAGS_1\)\s+Flags:.*\bPIE\b", program)

    def test_tables_of_the_linker_are_read_only(self):
        for program in PROGRAMS:
            self.assertIn("GNU_RELRO", readelf("-l", program), program)
            self.assertRegex(readelf("-d", program), r"BIND_NOW|FLAGS_1\).*\bNOW\b", program)

    def test_the_stack_is_not_executable(self):
        for program in PROGRAMS:
            self.assertRegex(readelf("-l", program), r"GNU_STACK(\s+0x\w+){5}\s+RW\s", program)

    def test_stack_frames_are_checked(self):
        for program in PROGRAMS:
            self.assertIn("__stack_chk_fail", readelf("--dyn-syms", program), program)

    def test_copies_are_checked(self):
        checked = {program: set(re.findall(r"\b__(\w+)_chk\b", readelf("--dyn-syms", program)))
                   for program in PROGRAMS}
        for program in ("pxpl5", "pxpl5-io"):
            self.assertTrue(checked[program], checked)

    def test_only_the_io_process_has_the_reader_of_archives(self):
        text = b"'scale', 'translate' or 'rotate' behind Pre"
        having = [program for program in PROGRAMS if text in (BIN / program).read_bytes()]
        self.assertEqual(having, ["pxpl5-io"])

    def test_a_process_that_writes_pictures_is_confined_in_every_thread(self):
        if "\nSeccomp:" not in pathlib.Path("/proc/self/status").read_text():
            self.skipTest("this kernel has no seccomp")
        seen = []
        with tempfile.TemporaryDirectory(prefix="pxpl5-hardened-") as folder:
            with subprocess.Popen(
                    [BIN / "pxpl5", "run", "--topology", "one-of-each", "-c",
                     "load phantom:sphere; surface s iso=0; orbit 20 o.gif"], cwd=folder,
                    stdout=subprocess.DEVNULL, env={**os.environ, "XDG_STATE_HOME": folder}) as run:
                while run.poll() is None:
                    for pid in children_of(run.pid):
                        if ("2", "1") in protections_of(pid):
                            # Again: the sandbox may have closed between two threads' readings.
                            seen.append(protections_of(pid))
            self.assertEqual(run.returncode, 0)
            self.assertTrue((pathlib.Path(folder) / "o.gif").exists())
        seen = [threads for threads in seen if threads]  # Empty: it ended meanwhile.
        self.assertTrue(seen)
        for threads in seen:
            self.assertEqual(set(threads), {("2", "1")})
        self.assertGreater(max(map(len, seen)), 3)  # Those of the ring and of libraries, too.


def protections_of(pid):
    """(Seccomp, NoNewPrivs) of each thread of an io process; nothing of another process."""
    found = []
    try:
        if name_of(pid) == "pxpl5-io":
            for thread in pathlib.Path(f"/proc/{pid}/task").iterdir():
                status = (thread / "status").read_text()
                found.append(tuple(re.search(rf"\n{key}:\s*(\d)", status)[1]
                                   for key in ("Seccomp", "NoNewPrivs")))
    except (FileNotFoundError, ProcessLookupError):
        return []  # It ended while we looked.
    return found


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
