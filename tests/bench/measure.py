"""The measurements of a whole machine: each asks a session and keeps figures by name."""
import argparse
import collections
import contextlib
import json
import os
import pathlib
import subprocess
import tempfile
import time
from typing import Dict, Iterator, List, Tuple

import figures
import goals
import loads
import processes
import session

WARM_UP = 10  # Frames or changes that are not counted.
COUNTS = range(2, 100001)  # Changes and frames of a run: what pxpl5's sweep takes.
FIRST_FRAMES = 60  # Of a machine, not counted either: they touch the recorders' memory first.
MEMORY_FRAMES = 40
RECORDINGS = ("off", "flight", "full")
RECORDED_FRAMES = 100
BIG = (512, 512, 300)
BIG_ISOVALUE = 290.5


def check_count(parser: argparse.ArgumentParser, count: int):
    """Ends the program unless so many changes can be asked for."""
    if count not in COUNTS:
        parser.error(f"--count is {COUNTS[0]} to {COUNTS[-1]}; it is {count}")


class Figures:
    """Medians and 95th percentiles by name, one of each a run."""

    def __init__(self):
        self.medians: Dict[str, List[float]] = collections.defaultdict(list)
        self.p95s: Dict[str, List[float]] = collections.defaultdict(list)

    def add(self, name: str, samples: List[float]):
        """The samples of one run."""
        self.medians[name].append(figures.median(samples))
        self.p95s[name].append(figures.percentile(samples, 0.95))

    def add_one(self, name: str, value: float):
        """A figure of which a run has one only."""
        self.medians[name].append(value)

    def add_summary(self, name: str, summary: Dict[str, float]):
        """The program's own statistics: {"median": .., "p95": ..}."""
        self.medians[name].append(summary["median"])
        self.p95s[name].append(summary["p95"])

    def over_runs(self) -> Dict[str, float]:
        """The medians over all runs."""
        return {name: figures.rounded(figures.median(values))
                for name, values in sorted(self.medians.items())}

    def p95_over_runs(self) -> Dict[str, float]:
        """The medians over all runs of each run's 95th percentile."""
        return {name: figures.rounded(figures.median(values))
                for name, values in sorted(self.p95s.items())}


class Load:
    """One load on one session: its volume loaded, its surface there."""

    def __init__(self, machine: session.Session, load: loads.Load):
        self.machine, self.load = machine, load
        self.changes = 0
        machine.run(f"load {load.volume}")
        first = machine.run(f"surface {load.surface} iso={load.isovalue}")
        self.first_ms, self.triangles = first["extraction_ms"], first["triangles"]

    def change(self) -> float:
        """Changes the isovalue a little. Returns ms from the command to the last GP's word."""
        self.changes += 1
        by = loads.NUDGE if self.changes % 2 else -loads.NUDGE
        isovalue = self.load.isovalue + by
        return self.machine.run(f"surface {self.load.surface} iso={isovalue}")["extraction_ms"]

    def extraction(self, count: int) -> List[float]:
        for _ in range(WARM_UP):
            self.change()
        return [self.change() for _ in range(count)]

    def isovalue_to_picture(self, count: int) -> Dict[str, float]:
        """ms from a changed isovalue to the picture of it in the host's memory."""
        low, high = self.load.isovalue - loads.NUDGE, self.load.isovalue + loads.NUDGE
        sweep = f"sweep {self.load.surface} {low} {high}"
        self.machine.run(f"{sweep} {WARM_UP}")
        return self.machine.run(f"{sweep} {count}")["picture_ms"]

    def view_to_picture(self, count: int) -> Dict[str, float]:
        """ms from a changed view to its picture in the host's memory, one in flight."""
        self.machine.run(f"orbit {WARM_UP} inflight=1")
        return self.machine.run(f"orbit {count} inflight=1")["latency_ms"]

    def rate(self, frames: int) -> float:
        """Newly drawn views a second, two in flight."""
        self.machine.run(f"orbit {WARM_UP}")
        return self.machine.run(f"orbit {frames}")["frames_per_s"]

    def rate_and_cpu(self, frames: int) -> Tuple[float, float]:
        """The same, and the ms that all processes together worked for a frame."""
        self.machine.run(f"orbit {WARM_UP}")
        pids = processes.family(self.machine.process.pid)
        before = sum(processes.cpu_seconds(pids).values())
        rate = self.machine.run(f"orbit {frames}")["frames_per_s"]
        worked_s = sum(processes.cpu_seconds(pids).values()) - before
        return rate, worked_s * 1000 / frames

    def remove(self):
        self.machine.run(f"remove {self.load.surface}")


def measure_loads(program: str, topology: str, size: str, wanted: List[loads.Load], count: int,
                  out: Figures):
    """One run of all loads on one machine, at one picture size."""
    with session.Session(program, topology) as machine:
        machine.run(f"size {size}")
        for number, load in enumerate(wanted):
            at = Load(machine, load)
            if number == 0:
                at.rate(FIRST_FRAMES)
            name = f"{topology}/{size}/{load.key}"
            if size == goals.SMALL:
                out.add_one(f"first_extraction_ms/{topology}/{load.key}", at.first_ms)
                out.add(f"extraction_ms/{topology}/{load.key}", at.extraction(count))
                out.add_summary(f"isovalue_picture_ms/{name}", at.isovalue_to_picture(count))
            out.add_summary(f"view_picture_ms/{name}", at.view_to_picture(count))
            rate, cpu_ms = at.rate_and_cpu(count)
            out.add_one(f"frames_per_s/{name}", rate)
            out.add_one(f"cpu_ms_per_frame/{name}", cpu_ms)
            at.remove()


def first_picture_s(program: str, topology: str) -> float:
    """Seconds from starting the program to the first picture of a built-in volume."""
    with session.Session(program, topology) as machine:
        for command in ("load phantom:pelvis", "surface bone", "orbit 1"):
            machine.send(command)
        for command in ("load", "surface", "orbit 1"):
            machine.answer(command)
        return time.perf_counter() - machine.started_s


def memory_mib(program: str, topology: str, load: loads.Load) -> float:
    """Peak of the sum of all processes' proportional set sizes, from start to end."""
    with session.Session(program, topology) as machine:
        with processes.PeakMemory(machine.process.pid) as memory:
            machine.run("size 512x512")
            at = Load(machine, load)
            at.change()
            at.rate(MEMORY_FRAMES)
        return memory.peak_kib / 1024


def recorded(program: str, topology: str, load: loads.Load, record: str) -> Tuple[float, float]:
    """Frames/s, and CPU ms for a frame, once the recorder's memory has been used."""
    with session.Session(program, topology, record) as machine:
        machine.run("size 512x512")
        at = Load(machine, load)
        at.rate(RECORDED_FRAMES)
        return at.rate_and_cpu(RECORDED_FRAMES)


def measure_recording(program: str, topology: str, load: loads.Load, runs: int, out: Figures):
    """Ratios to no recording, each run against its neighbor in time; who goes first changes."""
    taken: Dict[str, List[Tuple[float, float]]] = collections.defaultdict(list)
    for run in range(runs):
        first = run % len(RECORDINGS)
        for record in RECORDINGS[first:] + RECORDINGS[:first]:
            taken[record].append(recorded(program, topology, load, record))
    for record in RECORDINGS[1:]:
        for which, name in enumerate(("ratio", "cpu_ratio")):
            ratio = figures.pairwise_ratio([one[which] for one in taken[record]],
                                           [one[which] for one in taken[RECORDINGS[0]]])
            out.add_one(f"{record}_{name}/{topology}", ratio)


@contextlib.contextmanager
def generated_volume(program: str, dims, noise: int = 11, seed: int = 1) -> Iterator[str]:
    """A built-in pelvis sampled at `dims` voxels with seeded noise, in a file while it is used."""
    with tempfile.TemporaryDirectory(prefix="pxpl5-bench-") as folder:
        path = str(pathlib.Path(folder) / "volume.mhd")
        subprocess.run([tool(program, "bench_volume"), "phantom:pelvis", *map(str, dims),
                        str(noise), str(seed), path], check=True)
        yield path


def measure_big(program: str, topology: str, path: str, count: int, out: Figures) -> int:
    """Extraction in a volume of 512x512x300: bone. Returns how many triangles it has."""
    with session.Session(program, topology) as machine:
        at = Load(machine, loads.Load("bone", path, "bone", BIG_ISOVALUE))
        out.add_one(f"first_extraction_ms/{topology}/512x512x300", at.first_ms)
        out.add(f"extraction_ms/{topology}/512x512x300", at.extraction(count))
        return at.triangles


def parse_stages(text: str, target: str) -> Dict[str, float]:
    """The two figures that have goals, from stage_bench's JSON: CPU time, so that other work on
    the computer counts little."""
    to_ns = {"ns": 1.0, "us": 1e3, "ms": 1e6}
    times_ns = {entry["name"]: entry["cpu_time"] * to_ns[entry["time_unit"]]
                for entry in json.loads(text)["benchmarks"]}
    rates = {entry["name"]: entry.get("triangles") for entry in json.loads(text)["benchmarks"]}
    return {"triangles_8px_per_s": rates[f"triangles/8px/{target}"],
            "end_of_region_us": times_ns[f"end_of_region/covered/{target}"] / 1e3}


def measure_stages(tool: str, target: str, runs: int, out: Figures):
    """The Renderer alone: stage_bench's streams of triangles and ends of regions."""
    command = [tool, "--benchmark_format=json", "--benchmark_min_time=0.2",
               f"--benchmark_filter=^(triangles/8px|end_of_region/covered)/{target}$"]
    for _ in range(runs):
        text = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True, check=True).stdout
        for name, value in parse_stages(text, target).items():
            out.add_one(name, value)


def tool(program: str, name: str) -> str:
    """A measuring program of the build that `program` is of."""
    return str(pathlib.Path(program).resolve().parents[1] / "tests" / name)


def vector_target() -> str:
    """The vector instructions that the executors use: as forced, else the best of this machine."""
    forced = os.environ.get("PXPL5_TARGET", "")
    if forced and forced != "best":
        return forced
    flags = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    if {"avx512f", "avx512bw", "avx512dq", "avx512vl"} <= set(flags):
        return "avx512"
    return "avx2" if "avx2" in flags else "sse4"


def cpu_model() -> str:
    """The kernel's name of the processor."""
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


def git(*words: str) -> str:
    """Output of git in the repository of this file; empty without a repository."""
    here = pathlib.Path(__file__).resolve().parent
    answer = subprocess.run(["git", "-C", str(here), *words], stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL, text=True, check=False)
    return answer.stdout.strip()


def origin(kind: str) -> dict:
    """Where and of what a line of figures is."""
    changed = "-changed" if git("status", "--porcelain", "--untracked-files=no") else ""
    return {"commit": git("rev-parse", "--short", "HEAD") + changed,
            "date": git("show", "-s", "--format=%cI"), "cpu": cpu_model(),
            "cores": os.cpu_count(), "vector_target": vector_target(),
            "load_average": os.getloadavg()[0], "volumes": kind}
