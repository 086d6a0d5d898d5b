#!/usr/bin/env python3
"""`pxpl5 model --cluster` beside a machine on several computers with slow links.

usage: cluster_model.py PXPL5 WIRE [--check] [--rate MBIT] [--delay MS] [--frames N]

The computers are those of tests/cluster, with WIRE as their switch: see the README there. GPs run
on n1 and Renderers on n2, so that a frame's bins cross one link, and the link is the limit, not the
cores of the one computer on which everything runs. Prints a Markdown table of measured and modelled
figures. --check: exit code 1 if one differs by more than 20 %. SKIPPED where no cluster can be.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
from typing import Dict, List, NamedTuple

import figures
import session
from clusters import Cluster, missing

LIMIT_S = 300
MOST_ERROR = 0.20
SCENE = ["load phantom:pelvis", "surface bone iso=250.5", "size 512x512"]
NODES = ["--set", "gp.count=2", "--set", "renderer.count=2"]
PLACES = ["--set", "gp.computer=n1", "--set", "renderer.computer=n2"]
ENGINE = ["--engine", "ssh", "--computers", "n1:8,n2:8"]
RECORDED_FRAMES = 4
ALWAYS = 1_000_000
ISOVALUES = "sweep bone 250.25 250.75"
SWEPT = 10


class Case(NamedTuple):
    """A setting of the links and of the machine."""
    name: str
    rate_mbit: int
    delay_ms: float
    curve: bool
    compressed: bool = False


def cases(rate_mbit: int, delay_ms: float) -> List[Case]:
    return [Case("encrypted", rate_mbit, delay_ms, True),
            Case("half the rate", rate_mbit // 2, delay_ms, True),
            Case("plain", rate_mbit, delay_ms, False),
            Case("compressed", rate_mbit // 2, delay_ms, True, True)]


def modelled(program: str, run: str, case: Case) -> Dict[str, float]:
    """The model's figures, as means over the recorded frames."""
    sums: Dict[str, float] = {}
    for frame in range(RECORDED_FRAMES):
        # A packet passes two cables there, and two back.
        answer = subprocess.run(
            [program, "model", run, "--json", "--frame", str(frame), "--cluster", "2",
             "--host-apart", "--link-mbit", str(case.rate_mbit), *PLACES,
             "--cluster-set", f"link.round_trip_us={4000 * case.delay_ms}",
             "--cluster-set", f"curve={int(case.curve)}",
             "--cluster-set", f"compress={int(case.compressed)}"],
            stdout=subprocess.PIPE, text=True, check=True).stdout
        point = json.loads(answer)["computers"][0]
        for name in ("frame_ms", "latency_ms", "isovalue_ms", "network_mb"):
            sums[name] = sums.get(name, 0) + point[name] / RECORDED_FRAMES
    return {"frames/s": 1000 / sums["frame_ms"], "one at a time, ms": sums["latency_ms"],
            "isovalue to picture, ms": sums["isovalue_ms"]}


def measured(cluster: Cluster, program: str, case: Case, frames: int) -> Dict[str, float]:
    cluster.link(rate_mbit=case.rate_mbit, delay_ms=case.delay_ms)
    plain = [] if case.curve else ["--insecure-tcp"]
    compress = ["--set", f"compress_below_mb_s={ALWAYS if case.compressed else 0}"]
    machine = cluster.popen("login", [program, "run", "--json", "--record", "off", *ENGINE, *NODES,
                                      *PLACES, *plain, *compress, "-"], stdin=-1, stdout=-1,
                            stderr=-1, text=True)
    for line in SCENE:
        session.run_line(machine, line)
    session.run_line(machine, f"orbit {frames}")
    rate = session.run_line(machine, f"orbit {frames}")["frames_per_s"]
    latency = session.run_line(machine, f"orbit {frames} inflight=1")["latency_ms"]["median"]
    session.run_line(machine, f"{ISOVALUES} {SWEPT}")
    isovalue = session.run_line(machine, f"{ISOVALUES} {SWEPT}")["picture_ms"]["median"]
    machine.communicate(timeout=LIMIT_S)
    cluster.wait_until_idle()
    return {"frames/s": rate, "one at a time, ms": latency, "isovalue to picture, ms": isovalue}


def record(program: str, folder: str) -> str:
    """A run folder with the traces of some frames of the same orbit."""
    subprocess.run([program, "run", "--record", "full", "--run-folder", folder, *NODES, "-c",
                    "; ".join([*SCENE, f"orbit {RECORDED_FRAMES}"])], check=True,
                   stdout=subprocess.DEVNULL)
    return str(next(pathlib.Path(folder).iterdir()))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("wire")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--rate", type=int, default=1000, help="Mbit/s of each link")
    parser.add_argument("--delay", type=float, default=0.5, help="ms of each cable, one way")
    parser.add_argument("--frames", type=int, default=40)
    words = parser.parse_args()
    program = str(pathlib.Path(words.program).resolve())
    if reason := missing([pathlib.Path(program).parent]):
        print(f"SKIPPED: {reason}")
        return 0
    rows, worst = [], 0.0
    with tempfile.TemporaryDirectory(prefix="pxpl5-bench-") as folder, \
            Cluster(computers=2, slots=64, shared=[pathlib.Path(program).parent],
                    wire=words.wire) as cluster:
        run = record(program, folder)
        for case in cases(words.rate, words.delay):
            expected = modelled(program, run, case)
            found = measured(cluster, program, case, words.frames)
            for name, value in found.items():
                error = expected[name] / value - 1
                worst = max(worst, abs(error))
                rows.append([f"{case.name}, {case.rate_mbit} Mbit/s, {4 * case.delay_ms:g} ms",
                             name, f"{value:.1f}", f"{expected[name]:.1f}",
                             f"{100 * error:+.0f} %"])
    print(figures.table(["link, round trip", "figure", "measured", "modelled", "error"], rows))
    return int(words.check and worst > MOST_ERROR)


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
