#!/usr/bin/env python3
"""The work of pxpl5 done by VTK, on volumes that both read: one process a measurement.

usage: /usr/bin/python3 vtk_peer.py WORK FILE.mhd ISOVALUE [--threads N] [--size WxH] [--count N]
                                    [--picture FILE.png]

WORK     extraction  isovalue changed -> vtkFlyingEdges3D's surface with normals
         draw        view changed -> picture in memory: Phong per pixel, depth test, one sample
         loop        isovalue changed -> picture of it in memory
threads  Of flying edges (TBB); how many llvmpipe uses is the environment's LP_NUM_THREADS.

Prints one JSON line: triangles, the samples and the CPU time of one, in ms. Drawing needs an X
server; xvfb-run serves.
"""
import argparse
import json
import math
import sys
import time

import vtk

HALF_ANGLE = math.radians(15)  # Of our camera: it stands off so that a sphere fills this angle,
FILL = 1.3                     # and then fills the picture so much more.
STEP_DEG = 3.6
NUDGE = 0.25
WARM_UP = 10


def surface_of(path: str, isovalue: float):
    """Reader and flying edges, with normals, as a picture needs them. Both are to be kept: a
    reader that goes frees memory, which leaves the filter with quicker pages than usual."""
    reader = vtk.vtkMetaImageReader()
    reader.SetFileName(path)
    reader.Update()
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputConnection(reader.GetOutputPort())
    edges.ComputeNormalsOn()
    edges.ComputeGradientsOff()
    edges.ComputeScalarsOff()
    edges.SetValue(0, isovalue)
    edges.Update()
    return reader, edges


class Picture:
    """A window off the screen that shows the surface as our camera would."""

    def __init__(self, image, edges, width: int, height: int):
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputConnection(edges.GetOutputPort())
        mapper.ScalarVisibilityOff()
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        self._look(actor.GetProperty())
        self.renderer = vtk.vtkRenderer()
        self.renderer.AddActor(actor)
        self.renderer.SetBackground(18 / 255, 22 / 255, 30 / 255)
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(width, height)
        self.window.AddRenderer(self.renderer)
        self.pixels = vtk.vtkUnsignedCharArray()
        self.last = (width - 1, height - 1)
        self._place_camera(image, width / height)

    @staticmethod
    def _look(look):
        look.SetInterpolationToPhong()
        look.SetColor(0.93, 0.89, 0.78)
        look.SetAmbient(0.16)
        look.SetDiffuse(0.84)
        look.SetSpecular(0.25)
        look.SetSpecularPower(24)

    def _place_camera(self, image, aspect: float):
        """Anterior, at the distance from which the volume's sphere fills our picture."""
        bounds = image.GetBounds()
        center = [(bounds[2 * axis] + bounds[2 * axis + 1]) / 2 for axis in range(3)]
        radius = math.dist(center, (bounds[0], bounds[2], bounds[4]))
        distance = radius / math.sin(HALF_ANGLE)
        camera = self.renderer.GetActiveCamera()
        camera.SetFocalPoint(*center)
        camera.SetPosition(center[0], center[1] - distance, center[2])
        camera.SetViewUp(0, 0, 1)
        tangent = math.tan(HALF_ANGLE) / FILL / min(aspect, 1)
        camera.SetViewAngle(2 * math.degrees(math.atan(tangent)))
        camera.SetClippingRange(distance - 1.02 * radius, distance + 1.02 * radius)

    def turn(self):
        """Turns to the next view."""
        self.renderer.GetActiveCamera().Azimuth(STEP_DEG)

    def take(self):
        """Draws, and reads the pixels back."""
        self.window.Render()
        self.window.WaitForCompletion()
        self.window.GetRGBACharPixelData(0, 0, *self.last, 0, self.pixels)

    def backend(self) -> str:
        """Which OpenGL draws."""
        lines = self.window.ReportCapabilities().splitlines()
        return next((line for line in lines if "renderer string" in line), "unknown")

    def write(self, path: str):
        """Keeps what is shown, so that a person can compare it with ours."""
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputConnection(grab.GetOutputPort())
        writer.Write()


def times_ms(count: int, action) -> dict:
    """Samples of action(number), WARM_UP more left out, and the CPU time of one, of all threads."""
    samples = []
    for number in range(-WARM_UP, count):
        if number == 0:
            cpu_start = time.process_time()
        start = time.perf_counter()
        action(number)
        samples.append((time.perf_counter() - start) * 1000)
    return {"ms": samples[WARM_UP:], "cpu_ms": (time.process_time() - cpu_start) * 1000 / count}


def measure(args) -> dict:
    """The result of one measurement."""
    vtk.vtkSMPTools.SetBackend("TBB")
    vtk.vtkSMPTools.Initialize(args.threads)
    reader, edges = surface_of(args.volume, args.isovalue)

    def change(number):
        edges.SetValue(0, args.isovalue + (NUDGE if number % 2 else -NUDGE))

    result = {"work": args.work, "threads": args.threads,
              "triangles": edges.GetOutput().GetNumberOfPolys()}
    if args.work == "extraction":
        result.update(times_ms(args.count, lambda number: (change(number), edges.Update())))
        return result
    width, height = (int(side) for side in args.size.split("x"))
    picture = Picture(reader.GetOutput(), edges, width, height)
    picture.take()
    result["backend"] = picture.backend()
    if args.picture:
        picture.write(args.picture)
    if args.work == "draw":
        result.update(times_ms(args.count, lambda _: (picture.turn(), picture.take())))
    else:
        result.update(times_ms(args.count, lambda number: (change(number), picture.take())))
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("work", choices=("extraction", "draw", "loop"))
    parser.add_argument("volume")
    parser.add_argument("isovalue", type=float)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--picture", default="")
    print(json.dumps(measure(parser.parse_args())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
