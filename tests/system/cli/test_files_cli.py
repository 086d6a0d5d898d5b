#!/usr/bin/env python3
"""Meshes, charts and animations as files: real processes, read back by other programs.

usage: test_files_cli.py BIN_DIR [unittest arguments]
"""
import json
import os
import pathlib
import shutil
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


if __name__ == "__main__":
    unittest.main()
