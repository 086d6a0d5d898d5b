#!/usr/bin/env python3
"""VTK's readers see what was written: counts, bounds, orientation, normals, colors, texts.

read_meshes_with_vtk.py WRITE_MESHES
"""
import math
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import vtk
except ImportError:
    print("SKIPPED: VTK's Python modules are not installed (python3-vtk9)")
    sys.exit(0)

BONE_TRIANGLES, BONE_POINTS = 4, 4
RINGS, AROUND, RADIUS = 64, 96, 25.0
SKIN_TRIANGLES = 2 * AROUND * (RINGS - 1)
SKIN_POINTS = AROUND * (RINGS - 1) + 2
CENTER = (-40.0, 5.0, 12.0)
BONE, SKIN = (236, 226, 200), (30, 144, 255)
# x: from the ball's left end to the corner at 12; y: the ball's; z: from -30 to the ball's top.
BOUNDS = (-65.0, 12.0, -20.0, 30.0, -30.0, 37.0)
BALL_VOLUME = 4 / 3 * math.pi * RADIUS ** 3


def read(reader, path):
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def read_gltf(path):
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(path)
    reader.Update()
    append = vtk.vtkAppendPolyData()
    blocks = reader.GetOutput().NewIterator()
    while not blocks.IsDoneWithTraversal():
        append.AddInputData(blocks.GetCurrentDataObject())
        blocks.GoToNextItem()
    append.Update()
    return append.GetOutput()


def signed_volume(mesh):
    total = 0.0
    points = vtk.vtkIdList()
    for cell in range(mesh.GetNumberOfCells()):
        mesh.GetCellPoints(cell, points)
        assert points.GetNumberOfIds() == 3
        a, b, c = (mesh.GetPoint(points.GetId(i)) for i in range(3))
        total += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                  + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    return total


def turned(p, axes):
    return p if axes == "LPS" else (-p[0], -p[1], p[2])


def bounds_of(axes):
    x0, x1, y0, y1, z0, z1 = BOUNDS
    return BOUNDS if axes == "LPS" else (-x1, -x0, -y1, -y0, z0, z1)


class Read(unittest.TestCase):
    folder = ""

    def path(self, axes, suffix):
        return os.path.join(self.folder, f"{axes}.{suffix}")

    def near(self, values, expected, error):
        for value, other in zip(values, expected):
            self.assertLess(abs(value - other), error, (values, expected))

    def check_shape(self, mesh, axes):
        self.assertEqual(mesh.GetNumberOfCells(), BONE_TRIANGLES + SKIN_TRIANGLES)
        self.near(mesh.GetBounds(), bounds_of(axes), 0.02)
        volume = signed_volume(mesh)
        self.assertGreater(volume, 0.99 * BALL_VOLUME)
        self.assertLess(volume, BALL_VOLUME + 4)
        corners = {tuple(round(v, 3) for v in mesh.GetPoint(i))
                   for i in range(mesh.GetNumberOfPoints())}
        for corner in ((10, 20, -30), (12, 20, -30), (10, 23, -30), (10, 20, -26)):
            self.assertIn(turned(tuple(map(float, corner)), axes), corners)

    def check_normals(self, mesh, axes):
        normals = mesh.GetPointData().GetNormals()
        self.assertEqual(normals.GetNumberOfTuples(), BONE_POINTS + SKIN_POINTS)
        center = turned(CENTER, axes)
        for index in range(BONE_POINTS, BONE_POINTS + SKIN_POINTS):
            outward = [(p - c) / RADIUS for p, c in zip(mesh.GetPoint(index), center)]
            self.near(normals.GetTuple(index), outward, 1e-5)

    def test_stl(self):
        for axes in ("LPS", "RAS"):
            reader = vtk.vtkSTLReader()
            self.check_shape(read(reader, self.path(axes, "stl")), axes)
            self.assertIn(f"SPACE={axes} UNIT=mm", reader.GetHeader())

    def test_ply(self):
        for axes in ("LPS", "RAS"):
            mesh = read(vtk.vtkPLYReader(), self.path(axes, "ply"))
            self.check_shape(mesh, axes)
            self.check_normals(mesh, axes)
            colors = mesh.GetPointData().GetScalars()
            self.assertEqual(colors.GetTuple(0), BONE)
            self.assertEqual(colors.GetTuple(BONE_POINTS), SKIN)

    def test_obj(self):
        for axes in ("LPS", "RAS"):
            mesh = read(vtk.vtkOBJReader(), self.path(axes, "obj"))
            self.check_shape(mesh, axes)
            self.check_normals(mesh, axes)

    def test_vtp(self):
        for axes in ("LPS", "RAS"):
            mesh = read(vtk.vtkXMLPolyDataReader(), self.path(axes, "vtp"))
            self.check_shape(mesh, axes)
            self.check_normals(mesh, axes)
            colors = mesh.GetCellData().GetScalars()
            surfaces = mesh.GetCellData().GetArray("surface")
            for cell, color, surface in ((0, BONE, 0), (3, BONE, 0), (4, SKIN, 1),
                                          (mesh.GetNumberOfCells() - 1, SKIN, 1)):
                self.assertEqual(colors.GetTuple(cell), color)
                self.assertEqual(surfaces.GetValue(cell), surface)
            texts = mesh.GetFieldData()
            self.assertEqual(texts.GetAbstractArray("SPACE").GetValue(0), axes)
            self.assertEqual(texts.GetAbstractArray("unit").GetValue(0), "millimeter")
            self.assertEqual(texts.GetAbstractArray("description").GetValue(0), "two solids")
            names = texts.GetAbstractArray("surface names")
            self.assertEqual([names.GetValue(i) for i in range(2)], ["bone", "skin of a ball"])

    def test_glb(self):
        """In meters, Y up, the patient's left along X and front along Z, whatever the axes."""
        x0, x1, y0, y1, z0, z1 = (v / 1000 for v in BOUNDS)
        for axes in ("LPS", "RAS"):
            mesh = read_gltf(self.path(axes, "glb"))
            self.assertEqual(mesh.GetNumberOfCells(), BONE_TRIANGLES + SKIN_TRIANGLES)
            self.near(mesh.GetBounds(), (x0, x1, z0, z1, -y1, -y0), 2e-5)
            self.assertGreater(signed_volume(mesh) * 1e9, 0.99 * BALL_VOLUME)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], folder], check=True)
        Read.folder = folder
        unittest.main(argv=sys.argv[:1])
