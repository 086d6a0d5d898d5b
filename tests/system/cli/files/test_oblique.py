#!/usr/bin/env python3
"""Oblique slices at the prompt: test_oblique.py BIN_DIR."""
import array
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))
from png_pixels import rows_of  # pylint: disable=wrong-import-position

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 120
# The built-in ball, as host/phantom describes it. Its values are millimeters from its surface.
CENTER, RADIUS_MM, ISOVALUE = (0.3, -0.7, 0.45), 30, 0.5
COMMAND_ERROR = 64
SIDE = 128  # Pixels of the pictures.


def plus(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def times(vector, number):
    return [each * number for each in vector]


def write_floats(path, dims, spacing, value_at):
    """A volume of float32, as an NRRD file."""
    head = ["NRRD0004", "type: float", "dimension: 3", "sizes: {} {} {}".format(*dims),
            "space: left-posterior-superior",
            "space directions: ({},0,0) (0,{},0) (0,0,{})".format(*spacing),
            "space origin: (0,0,0)", "endian: little", "encoding: raw", "", ""]
    values = (value_at(x, y, z) for z in range(dims[2]) for y in range(dims[1])
              for x in range(dims[0]))
    path.write_bytes("\n".join(head).encode() + array.array("f", values).tobytes())


class Oblique(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def replies(self, *lines, code=0):
        """The replies to the lines, after the ball is loaded."""
        script = ["load phantom:sphere", f"surface ball iso={ISOVALUE}", "overlay off",
                  f"size {SIDE}x{SIDE}", *lines, ""]
        run = subprocess.run([BIN / "pxpl5", "run", "--json", "--topology", "one-of-each",
                              "--run-folder", self.folder / "run", "-"], input="\n".join(script),
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             timeout=LIMIT_S)
        self.assertEqual(run.returncode, code, run.stdout[-2000:] + run.stderr)
        return [json.loads(line) for line in run.stdout.splitlines()][4:]

    def test_the_picture_of_a_ball_is_a_disc_where_the_reply_says(self):
        for tilt, turn, place in ((0, 0, (4, 5, 12)), (25, -40, (0, 0, 0)), (90, 90, (-9, 2, 1)),
                                  (-130, 15, (3, -4, -8))):
            with self.subTest(tilt=tilt, turn=turn):
                file = self.folder / f"{tilt}{turn}.png"
                at = ",".join(map(str, place))
                said, = self.replies(f"oblique {tilt} {turn} {file} at={at} window=0.001 "
                                     f"level={ISOVALUE}")
                plane = said["result"]
                self.assertEqual(plane["size"][0], plane["size"][1])
                # Millimeters of a pixel of the picture.
                pixel_mm = plane["pixel_mm"] * plane["size"][0] / SIDE
                rows = rows_of(file)
                self.assertEqual((len(rows), len(rows[0])), (SIDE, SIDE))
                inside = 0
                for y, row in enumerate(rows):
                    for x, color in enumerate(row):
                        p = plus(plane["center_mm"],
                                 times(plane["right"], (x - (SIDE - 1) / 2) * pixel_mm),
                                 times(plane["down"], (y - (SIDE - 1) / 2) * pixel_mm))
                        off = math.dist(p, CENTER) - RADIUS_MM
                        if abs(off) > 1:
                            self.assertEqual(color, (255,) * 3 if off < 0 else (0,) * 3, (x, y, p))
                        inside += off < 0
                self.assertGreater(inside, 1000)
                self.assertGreater(plane["contours"], 100)

    def test_planes_along_the_axes_have_the_letters_of_slices(self):
        slices = self.replies("slice z 20", "slice y 20", "slice x 20")
        planes = self.replies("oblique 0 0", "oblique 90 0", "oblique 90 90")
        self.assertEqual([each["result"]["letters"] for each in planes],
                         [each["result"]["letters"] for each in slices])

    def test_the_picture_shows_the_whole_volume_at_the_size_that_the_reply_says(self):
        """The outermost voxels, too: beside them lies nothing to interpolate with."""
        info, probe = self.replies("info", "oblique 0 0")
        side = probe["result"]["size"][0]
        across, down, _ = [(count - 1) * step for count, step in
                           zip(info["result"]["dims"], info["result"]["spacing_mm"])]
        for size in (side, 300):
            with self.subTest(size=size):
                file = self.folder / f"{size}.png"
                said, = self.replies(f"size {size}x{size}", f"oblique 0 0 {file} window=1e-6 "
                                     "level=-100000")[1:]
                self.assertEqual(said["result"]["picture_size"], [size, size])
                rows = rows_of(file)
                white = [sum(color == (255,) * 3 for color in row) for row in rows]
                scale = size / side / said["result"]["pixel_mm"]
                self.assertAlmostEqual(max(white), across * scale, delta=1.5 * scale)
                self.assertAlmostEqual(sum(map(bool, white)), down * scale, delta=1.5 * scale)

    def test_without_a_place_the_plane_goes_through_the_middle_of_the_volume(self):
        info, first, second = self.replies("load phantom:sphere crop=0:30,0:20,0:10",
                                           "oblique 30 10", "oblique 30 10 at=-20,-20,-20")
        result = first["result"]
        size, step = info["result"]["dims"], info["result"]["spacing_mm"]
        whole = [(count - 1) * mm for count, mm in zip(size, step)]
        self.assertLess(max(result["through_mm"]), 0)
        self.assertAlmostEqual(math.dist(result["center_mm"], result["through_mm"]), 0)
        self.assertAlmostEqual(result["pixel_mm"], min(step))
        self.assertEqual(result["size"], [math.ceil(math.hypot(*whole) / min(step)) + 1] * 2)
        self.assertEqual(second["result"]["through_mm"], [-20, -20, -20])

    def test_a_volume_thinner_than_a_pixel_and_voxels_without_a_value(self):
        thin = self.folder / "thin.nrrd"
        write_floats(thin, (300, 300, 2), (0.5, 0.5, 0.01), lambda x, y, z: x)
        hollow = self.folder / "hollow.nrrd"
        write_floats(hollow, (8, 8, 9), (1, 1, 1), lambda x, y, z: math.nan if z == 4 else x)
        for line in (f"load {thin}", f"load {hollow}"):
            angles = "90 0" if "thin" in line else "0 0"
            with self.subTest(line=line):
                error = self.replies(line, f"oblique {angles}", code=COMMAND_ERROR)[-1]["error"]
                self.assertRegex(error, "^oblique: no pixel of the plane through .* has a value")

    def test_what_cannot_be_shown_is_refused(self):
        for line, sentence in (
                ("oblique 0 0 at=0,0,900", "oblique: the plane through (0.00, 0.00, 900.00) mm "
                 "does not meet the volume, whose middle is at (0.00, 0.00, 0.00) mm"),
                ("oblique 0 0 at=0,0", "at: '0,0' is not three numbers, as 1,2,3"),
                ("oblique steep 0", "oblique: TILT: 'steep' is not a number"),
                ("oblique 0 0 out.bmp", "oblique: 'out.bmp' must end in .png, ")):
            with self.subTest(line=line):
                error = self.replies(line, code=COMMAND_ERROR)[-1]["error"]
                self.assertTrue(error.startswith(sentence), error)


if __name__ == "__main__":
    unittest.main()
