#!/usr/bin/env python3
"""Meshes, charts and animations as files: real processes, read back by other programs.

usage: test_files_cli.py BIN_DIR [unittest arguments]
"""
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 240
VTK_PYTHON = "/usr/bin/python3"

# Prints triangles and bounds of a mesh file, as VTK's reader for its suffix gives them.
VTK_PROGRAM = """
import json, sys, vtk
reader = {".stl": vtk.vtkSTLReader, ".ply": vtk.vtkPLYReader, ".obj": vtk.vtkOBJReader,
          ".vtp": vtk.vtkXMLPolyDataReader}[sys.argv[1][-4:]]()
reader.SetFileName(sys.argv[1])
reader.Update()
mesh = reader.GetOutput()
print(json.dumps({"triangles": mesh.GetNumberOfPolys(), "bounds": mesh.GetBounds()}))
"""


def fnv1a(data):
    value = 0xcbf29ce484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    return value


def has_vtk():
    return subprocess.run([VTK_PYTHON, "-c", "import vtk"], capture_output=True,
                          check=False).returncode == 0


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def run_commands(self, *commands, gps=2):
        """The commands' JSON answers; each must have succeeded."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--set",
             f"gp.count={gps}", "--run-folder", self.path("run"), "-c", "\n".join(commands)],
            capture_output=True, text=True, timeout=LIMIT_S, cwd=self.folder.name, check=False)
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        for answer in answers:
            self.assertTrue(answer["ok"], answer)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [answer["result"] for answer in answers]

    def test_meshes_open_elsewhere(self):
        """Counts and bounds are those of the certificate; RAS is half a turn of LPS."""
        names = [f"{axes}.{suffix}" for axes in ("LPS", "RAS")
                 for suffix in ("stl", "ply", "obj", "vtp", "glb")]
        results = self.run_commands(
            "load phantom:letters", "surface letters iso=500.5",
            *[f"export {name} axes={name[:3]}" for name in names], "certificate")
        certificate = results[-1]["certificates"][0]
        low, high = certificate["low_mm"], certificate["high_mm"]
        lps = [value for pair in zip(low, high) for value in pair]
        ras = [-lps[1], -lps[0], -lps[3], -lps[2], lps[4], lps[5]]
        for name, result in zip(names, results[2:-1]):
            self.assertEqual(result["triangles"], certificate["triangles"], name)
            if name.endswith("glb"):
                if shutil.which("assimp"):
                    told = subprocess.run(["assimp", "info", self.path(name)], text=True,
                                          capture_output=True, timeout=LIMIT_S, check=True)
                    self.assertIn(f"Faces:              {certificate['triangles']}", told.stdout)
            elif has_vtk():
                told = json.loads(subprocess.run(
                    [VTK_PYTHON, "-c", VTK_PROGRAM, self.path(name)], text=True,
                    capture_output=True, timeout=LIMIT_S, check=True).stdout)
                self.assertEqual(told["triangles"], certificate["triangles"], name)
                for got, wanted in zip(told["bounds"], lps if name[0] == "L" else ras):
                    self.assertAlmostEqual(got, wanted, delta=1e-3, msg=name)
        if not has_vtk():
            print("SKIPPED in part: VTK's Python module is not installed")

    def test_the_certificate_is_that_of_the_file(self):
        """Capped, cut and decimated: what is said of a file is what its reader finds in it."""
        results = self.run_commands(
            "load phantom:pelvis", "surface bone iso=300", "export open.stl",
            "certificate open.stl", "export a.stl cap=yes", "certificate a.stl", "clip L 0",
            "clip S -20", "export b.ply cap=yes keep=0.3", "certificate b.ply",
            "export c.vtp axes=RAS", "certificate c.vtp")
        for name, written, read, is_closed in (
                ("open.stl", results[2], results[3], False),
                ("a.stl", results[4], results[5], True),
                ("b.ply", results[8], results[9], True),
                ("c.vtp", results[10], results[11], False)):
            with self.subTest(name):
                beside = json.loads(pathlib.Path(self.path(written["certificate"])).read_text())
                said, found = beside["surfaces"][0]["certificate"], read["certificates"][0]
                for key in ("triangles", "vertices", "edges", "closed", "manifold", "oriented",
                            "holes", "components"):
                    self.assertEqual(said[key], found[key], key)
                self.assertAlmostEqual(said["area_mm2"] / found["area_mm2"], 1, delta=1e-6)
                self.assertEqual(found["closed"], is_closed)
                self.assertTrue(found["manifold"] and found["oriented"], found)
                self.assertEqual(written["closed"], is_closed)
                self.assertEqual(beside["volume"]["file"], "phantom:pelvis")
                self.assertRegex(beside["volume"]["digest"], "^fnv1a:[0-9a-f]{16}$")
        self.assertGreater(results[5]["certificates"][0]["volume_ml"],
                           results[9]["certificates"][0]["volume_ml"])

    def test_a_smoothed_mesh_keeps_its_volume_and_says_how_far_it_has_moved(self):
        exact, smooth, few, capped = self.run_commands(
            "load phantom:pelvis", "surface bone iso=300", "export exact.ply cap=yes",
            "export smooth.ply smoothing=20", "export few.ply smoothing=20 error=0.2",
            "export capped.ply smoothing=20 cap=yes")[2:]
        self.assertNotIn("smoothing", exact["surfaces"][0])
        self.assertEqual(capped["triangles"], exact["triangles"])
        told = smooth["surfaces"][0]["smoothing"]
        self.assertLess(told["mean_mm"], told["farthest_mm"])
        self.assertLess(told["farthest_mm"], 4)  # A voxel is 4 mm long.
        volumes = [json.loads(pathlib.Path(self.path(each["certificate"])).read_text())
                   ["surfaces"][0]["certificate"]["volume_ml"] for each in (exact, capped)]
        self.assertAlmostEqual(volumes[1] / volumes[0], 1, delta=0.03)
        self.assertAlmostEqual(volumes[1] - volumes[0], told["volume_change_ml"], delta=0.5)
        self.assertTrue(capped["closed"])
        self.assertLess(few["triangles"], 0.8 * smooth["triangles"])
        self.assertLessEqual(few["surfaces"][0]["moved_mm"], 0.2)
        self.assertEqual(few["surfaces"][0]["smoothing"], told)
        beside = json.loads(pathlib.Path(self.path(few["certificate"])).read_text())
        self.assertEqual((beside["smoothing"], beside["error_mm"]), (20, 0.2))
        self.assertEqual(beside["surfaces"][0]["smoothing"], told)
        self.assertEqual(beside["surfaces"][0]["moved_mm"], few["surfaces"][0]["moved_mm"])

    def test_each_mesh_has_its_own_certificate(self):
        results = self.run_commands(
            "load phantom:sphere", "surface a iso=0.5", "surface none iso=5000",
            "surface all iso=-5000", "clip L -5", "certificate a", "export c.stl", "export c.ply",
            "clip off", "export c.glb surfaces=none,a", "components a min_ml=0.001",
            "certificate a", "export c.obj keep=0.5")
        for empty in results[2:4]:
            self.assertEqual(empty["triangles"], 0)
            self.assertNotIn("volume_ml", empty)
        cut, whole = results[5]["certificates"][0], results[11]["certificates"][0]
        self.assertEqual((cut["of"], cut["clips"]), ("whole surface", ["L -5"]))
        self.assertEqual((whole["clips"], whole["drawn_components"]), ([], "min_ml=0.001"))
        for name, is_closed in (("c.stl", False), ("c.ply", False), ("c.glb", True),
                                ("c.obj", True)):
            with self.subTest(name):
                beside = json.loads(pathlib.Path(self.path(name + ".certificate.json")).read_text())
                mesh = pathlib.Path(self.path(name)).read_bytes()
                self.assertEqual(beside["file"], name)
                self.assertEqual(beside["mesh_bytes"], len(mesh))
                self.assertEqual(beside["mesh_digest"], f"fnv1a:{fnv1a(mesh):016x}")
                [surface] = beside["surfaces"]
                self.assertEqual(surface["name"], "a")
                self.assertEqual(surface["certificate"]["closed"], is_closed)
                self.assertEqual("volume_ml" in surface["certificate"], is_closed)
                self.assertEqual("moved_mm" in surface, name == "c.obj")
        self.assertLess(0, surface["moved_mm"])

    def test_picks_name_their_values(self):
        """A pick's isovalue is the surface's, and a surface that it sets meets the place."""
        results = self.run_commands(
            "load phantom:pelvis", "surface bone iso=300.5", "size 256x256",
            "pick 128 100 set=t", "pick 128 100 surface=t")
        first, second = results[3:]
        self.assertEqual(first["isovalue"], 300.5)
        self.assertAlmostEqual(first["set"]["isovalue"], first["value_between"], delta=1e-3)
        self.assertLess(math.dist(first["p_mm"], second["p_mm"]), 1)

    def test_meshes_do_not_depend_on_the_machine(self):
        files = {}
        for gps in (1, 3):
            self.run_commands("load phantom:fetus", "surface face", f"export {gps}.ply",
                              f"export {gps}.glb keep=0.2", gps=gps)
            for suffix in ("ply", "glb"):
                files.setdefault(suffix, set()).add(
                    pathlib.Path(self.path(f"{gps}.{suffix}")).read_bytes())
        self.assertEqual([len(same) for same in files.values()], [1, 1])

    def test_atlas_and_animation(self):
        results = self.run_commands(
            "load phantom:sphere", "surface sphere iso=0.5", "size 160x120", "atlas chart.png",
            "orbit 5 turn.gif", "snapshot plain.png", "overlay off", "snapshot bare.png")
        rows = results[3]["rows"]
        self.assertEqual(len(rows), 256)
        middle = min(rows, key=lambda row: abs(row["isovalue"] - results[1]["isovalue"]))
        self.assertAlmostEqual(middle["area_mm2"] / results[1]["area_mm2"], 1, delta=0.05)
        self.assertEqual(middle["components"], 1)
        self.assertTrue(pathlib.Path(self.path("chart.png")).read_bytes().startswith(b"\x89PNG"))
        gif = pathlib.Path(self.path("turn.gif")).read_bytes()
        self.assertTrue(gif.startswith(b"GIF89a"))
        self.assertEqual(gif.count(b"\x21\xf9\x04"), 5)  # One graphic control block a frame.
        self.assertNotEqual(pathlib.Path(self.path("plain.png")).read_bytes(),
                            pathlib.Path(self.path("bare.png")).read_bytes())

    def test_sweep(self):
        results = self.run_commands(
            "load phantom:sphere", "surface sphere iso=0.5", "size 100x100",
            "sweep sphere 0 1500 4 iso-{}.png", "surface sphere", "orbit 3 inflight=1")
        sweep, surface, orbit = results[3:]
        self.assertEqual([sweep["changes"], sweep["written"]], [4, 4])
        pictures = {pathlib.Path(self.path(f"iso-{k:04}.png")).read_bytes() for k in range(4)}
        self.assertEqual(len(pictures), 4)
        self.assertGreater(sweep["picture_ms"]["median"], sweep["extraction_ms"]["median"])
        self.assertEqual(surface["isovalue"], 0.5)
        self.assertEqual(orbit["inflight"], 1)
        self.assertGreaterEqual(orbit["latency_ms"]["p95"], orbit["latency_ms"]["median"])

    def test_cropped_and_resampled(self):
        results = self.run_commands(
            "load phantom:sphere", "surface sphere iso=0.5",
            "load phantom:sphere resample_mm=2,2,2",
            "surface sphere iso=0.5", "info phantom:sphere crop=10:29,0:19,5:24")
        self.assertAlmostEqual(results[3]["volume_ml"] / results[1]["volume_ml"], 1, delta=0.03)
        self.assertEqual(results[4]["dims"], [20, 20, 20])

    def test_each_volume_of_a_time_series(self):
        size, radii_mm = 24, (4, 6, 8)
        values = b"".join(
            bytes(200 if math.dist((x, y, z), (11.5,) * 3) < radius else 0
                  for z in range(size) for y in range(size) for x in range(size))
            for radius in radii_mm)
        head = ("NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\n"
                f"sizes: {size} {size} {size} {len(radii_mm)}\nencoding: raw\n"
                "space directions: (1,0,0) (0,1,0) (0,0,1) none\nspace origin: (0,0,0)\n\n")
        pathlib.Path(self.path("beat.nrrd")).write_bytes(head.encode() + values)
        for number, radius in enumerate(radii_mm, 1):
            loaded, surface, _ = self.run_commands(
                f"load beat.nrrd frame={number}", "surface ball iso=100",
                f"export ball{number}.stl")
            self.assertEqual(loaded["dims"], [size] * 3)
            sphere_ml = 4 / 3 * math.pi * radius ** 3 / 1000
            self.assertAlmostEqual(surface["volume_ml"] / sphere_ml, 1, delta=0.06)
            beside = pathlib.Path(self.path(f"ball{number}.stl.certificate.json"))
            told = json.loads(beside.read_text())
            self.assertEqual(told["volume"]["read_as"]["frame"], number)
        done = subprocess.run([BIN / "pxpl5", "info", "beat.nrrd"], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=self.folder.name, check=False)
        self.assertEqual(done.returncode, 65, done)
        self.assertIn("select a volume with frame=N, 1 to 3", done.stderr)

    def write_series(self):
        """beat.nii: four volumes 50 ms apart, in which a wall moves; 12 x 12 x 12 voxels."""
        size = 12
        header = bytearray(352)
        struct.pack_into("<i", header, 0, 348)
        struct.pack_into("<8h", header, 40, 4, size, size, size, 4, 1, 1, 1)
        struct.pack_into("<2h", header, 70, 2, 8)
        struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 50, 0, 0, 0)
        struct.pack_into("<f", header, 108, 352)
        header[123] = 2 | 16
        header[344:347] = b"n+1"
        values = b"".join(bytes([10 * frame + 5 * x for x in range(size)] * size * size)
                          for frame in range(4))
        path = pathlib.Path(self.path("beat.nii"))
        path.write_bytes(bytes(header) + values)
        return path

    def start_prompt(self):
        """A running program, and a function that gives it a line and returns the result."""
        process = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder",
             self.path("run"), "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            cwd=self.folder.name)
        self.addCleanup(process.stdout.close)

        def ask(line):
            process.stdin.write(line + "\n")
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
            self.assertTrue(answer["ok"], answer)
            return answer["result"]

        return process, ask

    def test_volumes_that_come_next_are_read_with_the_wanted_one(self):
        path = self.write_series()
        process, ask = self.start_prompt()
        ask("load beat.nii")
        ask("surface wall iso=42")
        alone = [ask(line)["frame"] for line in ("time 4", "digest")]
        self.assertEqual(ask("time 2")["kept"], 3)  # 1 and 4, which were shown, and 3.
        path.unlink()
        ask("time 3")
        self.assertEqual([ask(line)["frame"] for line in ("time 4", "digest")], alone)
        process.stdin.close()
        self.assertEqual(process.wait(LIMIT_S), 0)

    def test_a_second_turn_of_a_series_reads_no_file(self):
        path = self.write_series()
        process, ask = self.start_prompt()
        ask("load beat.nii")
        ask("surface wall iso=42")
        first = [ask(line)["frame"] for number in range(1, 5)
                 for line in (f"time {number}", "digest")]
        curve = ask("curve table.csv")
        path.unlink()
        self.assertEqual(ask("time 1")["kept"], 3)
        again = [ask(line)["frame"] for number in range(1, 5)
                 for line in (f"time {number}", "digest")]
        self.assertEqual(again, first)
        self.assertEqual(len(set(first)), 8)
        process.stdin.close()
        self.assertEqual(process.wait(LIMIT_S), 0)
        rows = pathlib.Path(self.path("table.csv")).read_text().splitlines()
        self.assertEqual(rows[0], "surface,frame,time_ms,triangles,area_mm2,volume_ml")
        self.assertEqual([row.split(",")[:3] for row in rows[1:]],
                         [['"wall"', str(number), str(50 * (number - 1))]
                          for number in range(1, 5)])
        # The wall is at x = (42 - 10 * frame) / 5, and the inside at its right.
        walls = [(11 - (42 - 10 * frame) / 5) * 11 * 11 / 1000 for frame in range(4)]
        for row, wall_ml in zip(curve["rows"], walls):
            self.assertAlmostEqual(row["volume_ml"], wall_ml, delta=1e-4)

    def test_a_volume_that_is_no_longer_there_is_named(self):
        path = self.write_series()
        half = path.read_bytes()[:352 + 2 * 12 ** 3]
        path.write_bytes(half)
        done = self.ends("run", "-c", "load beat.nii; surface wall iso=42; time 2; time 3")
        self.assertEqual(done.returncode, 65, done)
        self.assertIn("volume 2 of 4", done.stdout)  # Though one that was read ahead failed.
        self.assertIn("volume 3 of 4 ends after", done.stderr)
        path.unlink()

    def ends(self, *arguments):
        """The program's end for a machine of one node of each kind."""
        return subprocess.run(
            [BIN / "pxpl5", *arguments, "--topology", "one-of-each", "--run-folder",
             self.path("run")],
            capture_output=True, text=True, timeout=LIMIT_S, cwd=self.folder.name, check=False)

    def test_render_gives_the_options_of_a_picture_to_its_picture(self):
        pictures = []
        for name, options in (("plain.png", []), ("bare.png", ["--ground", "transparent"])):
            done = self.ends("render", "phantom:sphere", *options, "-o", name)
            self.assertEqual(done.returncode, 0, done)
            pictures.append(pathlib.Path(self.path(name)).read_bytes())
        self.assertNotEqual(*pictures)
        done = self.ends("render", "phantom:sphere", "--rate", "5", "-o", "x.png")
        self.assertEqual(done.returncode, 64, done)
        self.assertIn("--rate needs --orbit N before it", done.stderr)

    def test_a_film_of_a_sweep_names_all_its_isovalues(self):
        scene = "load phantom:sphere; surface s iso=0; size 64x64; sweep s -300 400.5 3"
        done = self.ends("run", "-c", f"{scene} sweep.webm")
        self.assertEqual(done.returncode, 0, done)
        self.assertIn(b"surface s isovalues -300 to 400.5",
                      pathlib.Path(self.path("sweep.webm")).read_bytes())
        done = self.ends("run", "-c", f"{scene} n-{{}}.gif")
        self.assertEqual(done.returncode, 64, done)
        self.assertIn("is one file, but has {}", done.stderr)


if __name__ == "__main__":
    unittest.main()
