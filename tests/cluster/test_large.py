#!/usr/bin/env python3
"""A volume of 4 GiB on three computers that have 1.5 GiB of memory each.

usage: test_large.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, without namespaces, or
without control groups.
"""
import collections
import contextlib
import itertools
import pathlib
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import memory_limit  # noqa: E402
from cluster import missing  # noqa: E402
from memory_limit import MemoryLimit  # noqa: E402
from on_cluster import BIN, NAMES, SSH, OnACluster, new_cluster  # noqa: E402

SIZE = (1024, 1024, 2048)
COMPUTER_MIB = 1536
HOST_MIB = 400
LOAD_S = 420
FILE = "/home/ada/boxes.nrrd"
MACHINE = ("--set", "gp.count=6", "--set", "gp.memory_mib=400", "--set", "renderer.count=3",
           "--set", "placement=spread")
HEAD = """NRRD0005
type: short
dimension: 3
space: left-posterior-superior
sizes: {} {} {}
endian: little
encoding: raw
space directions: (1,0,0) (0,1,0) (0,0,1)
space origin: (0,0,0)

""".format(*SIZE).encode()

Box = collections.namedtuple("Box", "first size")
# Voxels of these boxes are 1, all others 0. Along z they cross the slabs of all GPs. No two meet.
BOXES = [Box((10, 20, 3), (60, 50, 120)), Box((200, 300, 100), (40, 70, 900)),
         Box((900, 5, 300), (100, 90, 31)), Box((1, 1, 400), (2, 2, 1600)),
         Box((300, 800, 1500), (33, 44, 55)), Box((600, 950, 1900), (80, 60, 140))]


def pair_sum(size, less):
    """Sum over the three pairs of sides, each shorter by `less`, of their products."""
    return sum((a - less) * (b - less) for a, b in itertools.combinations(size, 2))


def expected():
    """Certificate of the boxes at 0.5, by arithmetic: the surface runs half a voxel outside.

    A cell has 2 triangles at a face and at an edge of a box, and 1 at a corner.
    """
    lengths = [sum(box.size) - 3 for box in BOXES]
    return {
        "triangles": sum(4 * pair_sum(box.size, 1) + 8 * length + 8
                         for box, length in zip(BOXES, lengths)),
        "vertices": sum(2 * pair_sum(box.size, 0) for box in BOXES),
        "area_mm2": sum(2 * pair_sum(box.size, 1) + 4 * length * 0.5 ** 0.5 + 3 ** 0.5
                        for box, length in zip(BOXES, lengths)),
        "volume_ml": sum((box.size[0] - 1) * (box.size[1] - 1) * (box.size[2] - 1) +
                         pair_sum(box.size, 1) + length / 2 + 1 / 6
                         for box, length in zip(BOXES, lengths)) / 1000}


def write_volume(path):
    """The zeros need no memory: the file has holes there."""
    with path.open("wb") as file:
        file.truncate(len(HEAD) + 2 * SIZE[0] * SIZE[1] * SIZE[2])
        file.write(HEAD)
        for first, size in BOXES:
            row = struct.pack("<h", 1) * size[0]
            for z, y in itertools.product(range(first[2], first[2] + size[2]),
                                          range(first[1], first[1] + size[1])):
                file.seek(len(HEAD) + 2 * ((z * SIZE[1] + y) * SIZE[0] + first[0]))
                file.write(row)


def peak_mib(pid):
    """The most memory that a process has used so far."""
    words = pathlib.Path(f"/proc/{pid}/status").read_text().split()
    return int(words[words.index("VmHWM:") + 1]) // 1024


class Large(OnACluster):
    @classmethod
    def setUpClass(cls):
        cls.stack = cls.enterClassContext(contextlib.ExitStack())
        cluster = new_cluster()
        cls.limits = {}
        # The groups can only be removed after the cluster has ended.
        cls.stack.callback(lambda: [limit.__exit__() for limit in cls.limits.values()])
        cls.cluster = cls.stack.enter_context(cluster)
        for name in NAMES.split(","):
            cls.limits[name] = MemoryLimit(cluster, name, COMPUTER_MIB).__enter__()

    def test_a_volume_that_no_computer_can_hold(self):
        write_volume(self.cluster.path("login", FILE))  # All computers share /home.
        machine = self.dialog(*SSH, *MACHINE)
        loaded = machine.result(f"load {FILE} read=gps", LOAD_S)
        self.assertEqual(loaded["dims"], list(SIZE))
        machine.result("surface boxes iso=0.5", LOAD_S)
        told, = machine.result("certificate boxes")["certificates"]
        self.assertTrue(told["closed"] and told["manifold"] and told["oriented"], told)
        self.assertEqual(told["components"], len(BOXES))
        for name, value in expected().items():
            self.assertAlmostEqual(told[name] / value, 1, delta=1e-6, msg=name)
        digests = set()
        for line in ("view 30 20", "view 40 20", "surface boxes iso=0.25", "surface boxes iso=0.5"):
            machine.result(line, LOAD_S)
            digests.add(machine.result("digest")["frame"])
        self.assertEqual(len(digests), 3, digests)
        peaks = {one.argv[0].rsplit("/", 1)[-1] + f" on {one.computer}": peak_mib(one.pid)
                 for one in self.programs("pxpl5")}
        host = {name: peak for name, peak in peaks.items() if name.endswith("on login")}
        self.assertTrue(host)
        self.assertLess(max(host.values()), HOST_MIB, peaks)
        for name, limit in self.limits.items():
            with self.subTest(name):
                self.assertEqual(limit.kills(), 0)
                self.assertGreater(limit.peak_mib(), 50)  # The limit counts the nodes.
        code, said = machine.end()
        self.assertEqual(code, 0, said)
        self.cluster.wait_until_idle()


if __name__ == "__main__":
    if reason := missing([BIN]) or memory_limit.missing():
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
