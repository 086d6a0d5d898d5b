#!/usr/bin/env python3
"""Text that is fit for a terminal and a script: test_terminal_text.py FOLDER_OF_BINARIES [words].

Names and contents of files may have control characters.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path()  # From the command line.
LIMIT_S = 120


class TerminalText(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-text-")
        self.addCleanup(folder.cleanup)
        self.work = pathlib.Path(folder.name)

    def pxpl5(self, *words):
        return subprocess.run([BIN / "pxpl5", *words], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=self.work, check=False,
                              env={**os.environ, "XDG_STATE_HOME": str(self.work / "state")})

    def run_commands(self, commands):
        return self.pxpl5("run", "--topology", "one-of-each", "-c", commands)

    def test_control_bytes_of_files_do_not_reach_the_terminal(self):
        (self.work / "e.pxasm").write_bytes(b"\033[31mFOO\n")
        done = self.pxpl5("asm", "e.pxasm")
        self.assertNotEqual(done.returncode, 0)
        self.assertNotIn("\033", done.stderr)
        self.assertIn("[31mFOO", done.stderr)
        (self.work / "no.nrrd").write_bytes(b"NRRD0004\ntype: \033[31mred\n")
        done = self.run_commands("load no.nrrd")
        self.assertEqual(done.returncode, 65, done)
        self.assertNotIn("\033", done.stderr)
        for wrong in (("ru\033[31mn",), ("run", "--ja\033[31mson"), ("run", "-c")):
            done = self.pxpl5(*wrong)
            self.assertEqual(done.returncode, 64, done)
            self.assertNotIn("\033", done.stderr)

    def test_control_bytes_of_a_trace_do_not_reach_the_terminal(self):
        done = self.pxpl5("run", "--record", "full", "--run-folder", "runs", "-c", "stats")
        self.assertEqual(done.returncode, 0, done)
        [traces] = (self.work / "runs").glob("*/traces")
        name = b"pxpl5 "
        for trace in traces.iterdir():
            content = trace.read_bytes()
            self.assertIn(name, content)
            trace.write_bytes(content.replace(name, b"\033[31m "))
        done = self.pxpl5("trace", "ls", str(traces))
        self.assertEqual(done.returncode, 0, done)
        self.assertIn("recorded by ?[31m", done.stdout)
        self.assertNotIn("\033", done.stdout)

    def test_a_name_or_path_has_no_line_break(self):
        done = self.pxpl5("render", "phantom:sphere", "--surface", "a\nb=0.5", "-o", "x.png")
        self.assertEqual(done.returncode, 64, done)
        self.assertIn("control character", done.stderr)
        (self.work / "a\nb.nrrd").write_bytes(b"NRRD0004\n")
        for line in ("load 'a\nb.nrrd'", "load phantom:sphere; snapshot 'a\nb.png'"):
            done = self.pxpl5("run", "-c", line.replace("\n", "\t"))
            self.assertEqual(done.returncode, 64, done)
            self.assertIn("control character", done.stderr)
            self.assertIn("rename the file", done.stderr)
        done = self.pxpl5("info", "a\nb.nrrd")
        self.assertEqual(done.returncode, 64, done)
        self.assertIn("control character", done.stderr)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1))
    unittest.main()
