#!/usr/bin/env python3
"""Surfaces after all 65,536 of their numbers were used: test_surface_ids.py BIN_DIR."""
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
NUMBERS = 65_536
LIMIT_S = 900
SIZE = 4
BOX = [100 if {1, 2} >= {x, y, z} else 0
       for z in range(SIZE) for y in range(SIZE) for x in range(SIZE)]


class SurfaceIds(unittest.TestCase):
    """The numbers of surfaces are given in turn, and begin again after the last."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "box.raw").write_bytes(struct.pack(f"<{len(BOX)}h", *BOX))

    def digests(self, *lines):
        """What the commands `digest` print."""
        load = f"load {self.folder}/box.raw raw={SIZE}x{SIZE}x{SIZE},int16 spacing=1,1,1"
        script = "\n".join([load, *lines, ""])
        run = subprocess.run(
            [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder",
             self.folder / "run", "-"], input=script, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, timeout=LIMIT_S)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return [line for line in run.stdout.splitlines() if line.startswith(("frame ", "mesh "))]

    def test_a_surface_keeps_its_number_when_they_begin_again(self):
        few = ["surface other iso=20", "remove other"]
        drawn = ["digest", "surface last iso=20", "digest", "remove keep", "digest"]
        expected = self.digests("surface keep iso=50", *few, *drawn)
        self.assertEqual(len(set(expected)), 4, expected)  # Two frames and two surfaces.
        self.assertEqual(self.digests("surface keep iso=50", *(few * NUMBERS), *drawn), expected)


if __name__ == "__main__":
    unittest.main()
