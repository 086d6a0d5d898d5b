#!/usr/bin/env python3
"""Runs every command of README.md's first part, as a reader pastes them: test_readme.py BIN_DIR."""
import math
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import pages

BIN = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else None
FIRST_LINES = 60


class Readme(unittest.TestCase):
    def setUp(self):
        self.text = (pages.ROOT / "README.md").read_text()
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        pages.write_nifti(self.folder / "scan.nii.gz", 24, 8)
        (self.folder / "scans").mkdir()
        for number, radius in enumerate((6, 9)):
            pages.write_nifti(self.folder / "scans" / f"patient{number}.nii", 24, radius)

    def paste(self, commands: str) -> str:
        done = pages.paste(commands, self.folder, BIN)
        self.assertEqual(done.returncode, 0, f"{commands}\n{done.stdout}\n{done.stderr}")
        self.assertNotIn("failed:", done.stdout)
        return done.stdout

    def test_the_first_lines_hold_all_commands(self):
        first = self.text.splitlines()[:FIRST_LINES]
        for needed in ("host/launch.sh", "pxpl5 render", "pxpl5 info", "pxpl5 serve", "export bone",
                       "pxpl5 why", "pxpl5 exec", "pxpl5 model", "scans/*"):
            self.assertTrue(any(needed in line for line in first), f"{needed}: not in the first "
                            f"{FIRST_LINES} lines of README.md")
        self.assertTrue((pages.ROOT / "host/launch.sh").exists())

    def test_every_block_runs_and_makes_its_files(self):
        output = ""
        for language, block in pages.FENCED.findall(self.text):
            if language == "asm":
                name = re.search(r"; (\S+\.pxasm)", block)[1]
                (self.folder / name).write_text(block)
            elif language == "sh":
                output += self.paste(block)
        self.assertIn("shows surface", output)  # The answer of `why`.
        for name in ("pelvis.png", "bone.png"):
            self.assertEqual(pages.png_size(self.folder / name), (512, 512))
        self.assertEqual(pages.png_size(self.folder / "disc.png"), (128, 128))
        self.assertIn("wrote disc.png (128x128)\n", output)
        for name in ("bone.stl", "patient0.nii.stl", "patient1.nii.stl"):
            self.assertGreater((self.folder / name).stat().st_size, 1000, name)
        # The balls of radius 6 and 9 voxels enclose 0.9 and 3.1 ml.
        row = re.compile(r"^patient\d\.nii\.stl\t(\d+\.\d+)$", re.M)
        volumes = [float(volume) for volume in row.findall(output)]
        for measured, radius in zip(volumes, (6, 9)):
            truth = 4 / 3 * math.pi * radius ** 3 / 1000
            self.assertAlmostEqual(measured / truth, 1, delta=0.15)
        self.assertEqual(len(volumes), 2, output)


if __name__ == "__main__":
    if BIN is None:
        sys.exit(__doc__)
    unittest.main()
