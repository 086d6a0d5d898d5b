#!/usr/bin/env python3
"""Slices and picks of a volume that the GPs read from its file: test_slices_by_gps.py BIN_DIR."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 280
# More than the 64 MiB that the host keeps of a volume, so that its copy is reduced by 2.
ACROSS, DOWN, SLICES = 256, 250, 560
HEAD = f"""NRRD0005
type: short
dimension: 3
space: RAS
sizes: {ACROSS} {DOWN} {SLICES}
endian: little
encoding: raw
space directions: (1,0,0) (0,1.5,0) (0,0,2)

"""
# No two neighbors along any axis are equal, so that a slice of the copy differs from the slice.
ROW = [(7 * x + x * x % 11) % 300 for x in range(ACROSS)]
PICTURES = [f"slice {axis} {index} {{}}/{axis}{index}.png window=900 level=250"
            for axis, index in (("x", 101), ("y", 33), ("z", 277), ("z", 559))]


def write_volume(path):
    """Waves along x, shifted with y and z, in a ball that is brighter."""
    twice = ROW + ROW
    with path.open("wb") as file:
        file.write(HEAD.encode())
        for z in range(SLICES):
            values = bytearray()
            for y in range(DOWN):
                shift = (3 * y + 5 * z) % ACROSS
                row = twice[shift:shift + ACROSS]
                room = 80 ** 2 - (y - 125) ** 2 - (z - 280) ** 2
                half = int(max(room, 0) ** 0.5)
                row[128 - half:128 + half] = [v + 400 for v in row[128 - half:128 + half]]
                values += b"".join(v.to_bytes(2, "little") for v in row)
            file.write(values)


class SlicesByGps(unittest.TestCase):
    """Who reads the file changes no pixel of a slice and no number of a pick."""

    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        cls.folder = pathlib.Path(cls.kept.name)
        write_volume(cls.folder / "waves.nrrd")

    @classmethod
    def tearDownClass(cls):
        cls.kept.cleanup()

    def replies(self, out, read, *lines, options=()):
        """Runs the lines after the file is loaded. Returns the replies, parsed."""
        place = self.folder / out
        place.mkdir()
        script = [f"load {self.folder}/waves.nrrd read={read}", *lines, ""]
        run = subprocess.run(
            [BIN / "pxpl5", "run", "--json", *options, "--run-folder", self.folder / "run", "-"],
            input="\n".join(script).format(*[place] * 9), stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, timeout=LIMIT_S)
        self.assertEqual(run.returncode, 0, run.stdout[-2000:] + run.stderr)
        return [json.loads(line) for line in run.stdout.splitlines()]

    def pictures(self, out):
        """The bytes of the slices' pictures, by name."""
        return {path.name: path.read_bytes() for path in (self.folder / out).iterdir()}

    def told(self, reply):
        """A reply without what differs between two runs."""
        drop = ("ms", "file", "line", "command")
        return {key: value for key, value in reply["result"].items()
                if not key.endswith(drop)}

    def test_pictures_and_picks_are_the_same_whether_host_or_gps_read(self):
        lines = ["surface ball iso=450", *[line.format("{}") for line in PICTURES],
                 "pick 250 250", "pick 256 256"]
        answers = {}
        for read in ("host", "gps"):
            replies = self.replies(read, read, *lines)
            self.assertEqual(replies[0]["result"]["reduction"], 2 if read == "gps" else 1)
            answers[read] = [self.told(reply) for reply in replies[2:]]
            for reply in replies[2:]:
                self.assertEqual(reply["warnings"], [], reply)
        self.assertEqual(answers["host"], answers["gps"])
        for pick in answers["gps"][-2:]:
            self.assertIsInstance(pick.get("value"), (int, float), pick)
        pictures = self.pictures("gps")
        self.assertEqual(len(set(pictures.values())), len(PICTURES))
        self.assertEqual(pictures, self.pictures("host"))

    def test_a_slice_after_the_death_of_a_gp_is_the_same(self):
        self.replies("before", "gps", *PICTURES)
        self.replies("after", "gps", PICTURES[0], "kill gp-0", *PICTURES)
        self.assertEqual(self.pictures("after"), self.pictures("before"))

    def test_smooth_gradients_are_the_same_whether_host_or_gps_read_and_after_a_death(self):
        lines = ["surface ball iso=450", "digest", "kill gp-0", "digest"]
        digests = []
        for read in ("host gradient=smooth", "gps gradient=smooth", "gps gradient=central"):
            replies = self.replies("of " + read, read, *lines)
            self.assertEqual(replies[0]["result"]["gradient"],
                             "smooth" if "smooth" in read else "central")
            digests.append([reply["result"]["frame"] for reply in replies
                            if reply["command"] == "digest"])
        host, gps, central = digests
        self.assertEqual(len(set(host)), 1, host)
        self.assertEqual(gps, host)
        self.assertNotEqual(central[0], host[0])

    def test_the_automatic_window_of_an_unknown_kind_is_named_as_that_of_the_copy(self):
        reply = self.replies("window", "gps", "slice z 277 {}/z.png")[1]
        self.assertIn("the window follows from the values of one voxel in 2", json.dumps(reply))


if __name__ == "__main__":
    unittest.main()
