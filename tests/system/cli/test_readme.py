#!/usr/bin/env python3
"""Runs every command of README.md's first part, as a reader pastes them: test_readme.py BIN_DIR."""
import gzip
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BIN = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else None
FIRST_LINES = 60
BLOCK = re.compile(r"^```(sh|asm)\n(.*?)^```", re.M | re.S)


def write_nifti(path: pathlib.Path, size: int, radius: float) -> None:
    """A NIfTI-1 file of int16: a ball of 1000 in 0, voxels of 1 mm, place known to scanners."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, size, size, size, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    struct.pack_into("<b", header, 123, 2)
    struct.pack_into("<2h", header, 252, 0, 1)
    for row in range(3):
        struct.pack_into("<4f", header, 280 + 16 * row,
                         *[1.0 if column == row else 0.0 for column in range(4)])
    header[344:348] = b"n+1\0"
    middle = (size - 1) / 2
    values = [1000 if math.dist((x, y, z), (middle,) * 3) < radius else 0
              for z in range(size) for y in range(size) for x in range(size)]
    data = bytes(header) + struct.pack(f"<{len(values)}h", *values)
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)


def png_size(path: pathlib.Path):
    data = path.read_bytes()[:24]
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG file"
    return struct.unpack(">II", data[16:24])


class Readme(unittest.TestCase):
    def setUp(self):
        self.text = (ROOT / "README.md").read_text()
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        write_nifti(self.folder / "scan.nii.gz", 24, 8)
        (self.folder / "scans").mkdir()
        for number, radius in enumerate((6, 9)):
            write_nifti(self.folder / "scans" / f"patient{number}.nii", 24, radius)

    def paste(self, commands: str) -> str:
        path = f"{BIN}:{os.environ['PATH']}"
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", commands], cwd=self.folder,
                              env={**os.environ, "PATH": path}, capture_output=True, text=True,
                              timeout=240)
        self.assertEqual(done.returncode, 0, f"{commands}\n{done.stdout}\n{done.stderr}")
        self.assertNotIn("failed:", done.stdout)
        return done.stdout

    def test_the_first_lines_hold_all_commands(self):
        first = self.text.splitlines()[:FIRST_LINES]
        for needed in ("host/launch.sh", "pxpl5 render", "pxpl5 info", "pxpl5 serve", "export bone",
                       "pxpl5 why", "pxpl5 exec", "pxpl5 model", "scans/*"):
            self.assertTrue(any(needed in line for line in first), f"{needed}: not in the first "
                            f"{FIRST_LINES} lines of README.md")
        self.assertTrue((ROOT / "host/launch.sh").exists())

    def test_every_block_runs_and_makes_its_files(self):
        output = ""
        for language, block in BLOCK.findall(self.text):
            if language == "asm":
                name = re.search(r"; (\S+\.pxasm)", block)[1]
                (self.folder / name).write_text(block)
            else:
                output += self.paste(block)
        self.assertIn("shows surface", output)  # The answer of `why`.
        for name in ("pelvis.png", "bone.png"):
            self.assertEqual(png_size(self.folder / name), (512, 512))
        self.assertEqual(png_size(self.folder / "disc.png"), (128, 128))
        for name in ("bone.stl", "patient0.nii.stl", "patient1.nii.stl"):
            self.assertGreater((self.folder / name).stat().st_size, 1000, name)
        # The balls of radius 6 and 9 voxels enclose 0.9 and 3.1 ml.
        volumes = [float(line) for line in output.splitlines() if re.fullmatch(r"\d+\.\d+", line)]
        for measured, radius in zip(volumes, (6, 9)):
            truth = 4 / 3 * math.pi * radius ** 3 / 1000
            self.assertAlmostEqual(measured / truth, 1, delta=0.15)
        self.assertEqual(len(volumes), 2, output)


if __name__ == "__main__":
    if BIN is None:
        sys.exit(__doc__)
    unittest.main()
