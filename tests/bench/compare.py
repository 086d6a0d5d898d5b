#!/usr/bin/env python3
"""Measures pxpl5 and what people would use instead, one after the other in one session, and
prints a markdown table: work, ours, peer, ratio, goal, met.

usage: compare.py PXPL5 [--data FOLDER|phantoms] [--loads skin,head] [--size 512x512,1280x1024]
                  [--topology default,paper-1993] [--runs N] [--count N] [--big] [--json FILE]

Peers: VTK (Debian's python3-vtk9, under xvfb-run), and egl_peer if it was built; README.md says
what to install. Every run measures ours, then the peers; medians over the runs are compared. Peers
draw with one thread and with one for each core that they may use, and the better counts; flying
edges has all cores. "(statement)" marks what no peer measured: a figure of another computer.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
from typing import Dict, List, NamedTuple

import figures
import goals
import loads
import measure
import session

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "peers"))
import volume_file  # noqa: E402  The folder above is no package.

SCREEN = "-screen 0 1280x1024x24"
CORES = len(os.sched_getaffinity(0))
THREADS = sorted({1, CORES})
TRIANGLES_DIFFER = 0.01
PYTHON = "/usr/bin/python3"  # Debian's own: no other one on the path has its VTK.


def peer_answer(command: List[str], threads: int) -> dict:
    """A peer's description of itself. Raises MeasureError with its last output if it fails."""
    environment = dict(os.environ, LP_NUM_THREADS=str(threads))
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=environment, check=False)
    if done.returncode != 0:
        raise session.MeasureError(f"{' '.join(command)}: exit code {done.returncode}: "
                                   f"{done.stderr.strip()[-400:]}")
    return json.loads(done.stdout.splitlines()[-1])


def has_vtk() -> bool:
    """Whether Debian's VTK and a screen for it are installed."""
    if not os.path.exists(PYTHON) or shutil.which("xvfb-run") is None:
        return False
    return subprocess.run([PYTHON, "-c", "import vtk"], stderr=subprocess.DEVNULL,
                          check=False).returncode == 0


class Peers:
    """The peers that are installed, and their figures in ms."""

    def __init__(self, args):
        self.args = args
        self.vtk = [PYTHON, "-B", str(HERE / "peers" / "vtk_peer.py")] if has_vtk() else []
        egl = measure.tool(args.program, "egl_peer")
        self.egl = egl if os.path.exists(egl) else ""
        self.runs = measure.Figures()
        for name, there in (("VTK", self.vtk), ("egl_peer", self.egl)):
            if not there:
                print(f"{name} is left out: README.md says what to install", file=sys.stderr)

    def vtk_work(self, work: str, load: loads.Load, threads: int, size: str = "512x512") -> dict:
        """VTK's samples. Drawing needs a screen."""
        screen = [] if work == "extraction" else ["xvfb-run", "-a", "-s", SCREEN]
        return peer_answer(screen + self.vtk + [
            work, load.volume, str(load.isovalue), "--threads", str(threads), "--size", size,
            "--count", str(self.args.count)], threads)

    def keep_best(self, name: str, answers: List[dict]):
        """Keeps the answer with the least median among the numbers of threads."""
        best = min(answers, key=lambda answer: figures.median(answer["ms"]))
        self.runs.add(name, best["ms"])
        self.runs.add_one(name.replace("_ms/", "_cpu_ms/", 1), best["cpu_ms"])

    def extraction(self, load: loads.Load, name: str, triangles: int):
        """Flying edges on all cores. Raises MeasureError if its surface is another than ours."""
        if not self.vtk:
            return
        answer = self.vtk_work("extraction", load, CORES)
        require_same_work(name, triangles, answer["triangles"])
        self.runs.add(f"vtk_extraction_ms/{name}", answer["ms"])

    def pictures(self, load: loads.Load, mesh: "Mesh", size: str):
        """Frames of all peers, and VTK's loop where a goal asks for it."""
        works = ["draw", "loop"] if size == goals.SMALL else ["draw"]
        for work in works if self.vtk else []:
            self.keep_best(f"vtk_{work}_ms/{size}/{load.key}",
                           [self.vtk_work(work, load, threads, size) for threads in THREADS])
        if self.egl:
            command = [self.egl, mesh.path, size, *map(str, mesh.sphere), str(self.args.count)]
            self.keep_best(f"egl_draw_ms/{size}/{load.key}",
                           [peer_answer(command, threads) for threads in THREADS])


def require_same_work(name: str, ours: int, theirs: int):
    """Triangle counts differ a little where faces are ambiguous; more is another surface."""
    if abs(ours - theirs) > TRIANGLES_DIFFER * max(ours, theirs):
        raise session.MeasureError(f"{name}: pxpl5 makes {ours} triangles, the peer {theirs}: "
                                   "that is not the same work")


def sphere_around(info: dict) -> List[float]:
    """Center and radius, mm, of the sphere around a volume whose axes are the patient's."""
    half = [(count - 1) * spacing / 2 for count, spacing in zip(info["dims"], info["spacing_mm"])]
    center = [origin + side for origin, side in zip(info["origin_mm"], half)]
    return center + [math.hypot(*half)]


def file_of(program: str, load: loads.Load, folder: str) -> str:
    """The load's volume as a file that VTK reads."""
    if not load.volume.startswith("phantom:"):
        return volume_file.convert(load.volume, folder)
    info = json.loads(subprocess.run([program, "info", load.volume, "--json"], check=True,
                                     stdout=subprocess.PIPE, text=True).stdout)["result"]
    path = str(pathlib.Path(folder) / (load.volume.split(":")[1] + ".mhd"))
    tool = measure.tool(program, "bench_volume")
    dims = [str(int(count)) for count in info["dims"]]
    subprocess.run([tool, load.volume, *dims, "0", "1", path], check=True)
    return path


class Mesh(NamedTuple):
    """A load's mesh as pxpl5 writes it, and the sphere around its volume."""
    path: str
    sphere: List[float]
    triangles: int


def export(program: str, load: loads.Load, folder: str) -> Mesh:
    """The load's mesh in a file."""
    path = str(pathlib.Path(folder) / f"{load.key}.ply")
    with session.Session(program) as machine:
        info = machine.run(f"load {load.volume}")
        surface = machine.run(f"surface {load.surface} iso={load.isovalue}")
        machine.run(f"export {path}")
    return Mesh(path, sphere_around(info), surface["triangles"])


NAMES = {"vtk": "VTK", "egl": "OpenGL"}


def peer_of(figure: str) -> str:
    """The measured program: "VTK" for "vtk_draw_ms/512x512/skin"."""
    return NAMES[figure.split("_", 1)[0]]


def row_of(verdict: goals.Verdict, peers: Dict[str, float]) -> List[str]:
    """One row of the table. Ratios above 1 are ours being better."""
    goal, value, limit, met = verdict
    peer = peers.get(goal.peer) if goal.peer else None
    baseline = goal.baseline if peer is None else peer if goal.at_most else 1000 / peer
    ratio = baseline / value if goal.at_most else value / baseline
    source = peer_of(goal.peer) if peer else "statement"
    return [goal.figure, f"{value:.4g}", f"{baseline:.4g} ({source})", f"{ratio:.2f}",
            f"{'at most' if goal.at_most else 'at least'} {limit:.4g} = {goal.factor:g} x",
            "yes" if met else "**no**"]


def other_rows(ours: Dict[str, float], peers: Dict[str, float]) -> List[List[str]]:
    """Figures without a goal: frame rates beside plain OpenGL, and the CPU time of a frame."""
    rows = []
    for name, peer in sorted(peers.items()):
        work, place = name.split("/", 1)
        figure = f"frames_per_s/default/{place}"
        if work == "egl_draw_ms" and figure in ours:
            rows.append([figure, f"{ours[figure]:.4g}", f"{1000 / peer:.4g} ({peer_of(work)})",
                         f"{ours[figure] * peer / 1000:.2f}", "-", "-"])
        figure = f"cpu_ms_per_frame/default/{place}"
        if work in ("vtk_draw_cpu_ms", "egl_draw_cpu_ms") and figure in ours:
            rows.append([figure, f"{ours[figure]:.4g}", f"{peer:.4g} ({peer_of(work)})",
                         f"{peer / ours[figure]:.2f}", "-", "-"])
    return rows


def threads_text() -> str:
    """The threads of the peers: "1 or 2 threads"."""
    return " or ".join(map(str, THREADS)) + (" thread" if CORES == 1 else " threads")


def tables(ours: Dict[str, float], peers: Dict[str, float]) -> str:
    """All that was measured, against its goals."""
    rows = [row_of(verdict, peers) for verdict in goals.judge(ours, peers)]
    return figures.table(["work", "ours", f"peer ({threads_text()}) or limit",
                          "times as good", "goal", "met"],
                         rows + other_rows(ours, peers))


def measure_load(args, load: loads.Load, peers: Peers, prepared, ours: measure.Figures):
    """One run of one load: ours at a size, then the peers at it; extraction last."""
    file, mesh = prepared
    for size in args.size.split(","):
        for topology in args.topology.split(","):
            if topology == "default" or size == goals.SMALL:
                measure.measure_loads(args.program, topology, size, [load], args.count, ours)
        peers.pictures(file, mesh, size)
    peers.extraction(file, load.key, mesh.triangles)


def measure_big(args, peers: Peers, ours: measure.Figures):
    """512x512x300."""
    with measure.generated_volume(args.program, measure.BIG) as path:
        count = max(5, args.count // 6)
        triangles = measure.measure_big(args.program, "default", path, count, ours)
        peers.extraction(loads.Load("big", path, "bone", measure.BIG_ISOVALUE), "512x512x300",
                         triangles)


def measure_all(args, wanted: List[loads.Load], folder: str):
    """Ours and the peers', alternately. Returns both medians."""
    ours, peers = measure.Figures(), Peers(args)
    prepared = {load.key: (load._replace(volume=file_of(args.program, load, folder)),
                           export(args.program, load, folder)) for load in wanted}
    for _ in range(args.runs):
        for load in wanted:
            measure_load(args, load, peers, prepared[load.key], ours)
        if args.big:
            measure_big(args, peers, ours)
    return ours.over_runs(), peers.runs.over_runs()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", help="path of pxpl5")
    parser.add_argument("--data", default="", help="folder of real volumes, or: phantoms")
    parser.add_argument("--loads", default="", help="only these: skin,muscle,bone,ultrasound,head")
    parser.add_argument("--size", default="512x512,1280x1024")
    parser.add_argument("--topology", default="default")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--big", action="store_true", help="512x512x300, too")
    parser.add_argument("--json", default="", help="file for the figures")
    args = parser.parse_args()
    measure.check_count(parser, args.count)
    kind, wanted = loads.chosen_loads(args.program, args.data, args.loads)
    with tempfile.TemporaryDirectory(prefix="pxpl5-bench-") as folder:
        ours, peers = measure_all(args, wanted, folder)
    line = measure.origin(kind)
    print(", ".join(f"{key} {value}" for key, value in line.items()) + "\n")
    print(tables(ours, peers))
    if args.json:
        line.update({"medians": ours, "peers": peers})
        pathlib.Path(args.json).write_text(json.dumps(line) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
