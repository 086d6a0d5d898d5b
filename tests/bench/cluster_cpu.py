#!/usr/bin/env python3
"""Processor time per frame of a machine on several computers, beside that on one.

usage: cluster_cpu.py PXPL5 [--topology NAME] [--computers N] [--frames N] [--runs N] [--check]

The computers are those of tests/cluster: see the README there. All use this computer's processors,
so that the difference is the price of TCP and of CURVE. Runs alternate: one computer, several
without and several with CURVE. Prints a Markdown table: medians, and pairwise ratios to one
computer. --check: exit code 1 if a ratio is above 1.5 without or 2 with CURVE. SKIPPED where no
cluster can be.
"""
import argparse
import pathlib
import sys
from typing import Dict, List

import figures
import session
from clusters import Cluster, missing, parser_of

LIMIT_S = 300
SCENE = ["load phantom:pelvis", "surface bone iso=250.5", "size 512x512"]
PLACES = {"one computer": 0.0, "several": 1.5, "several, CURVE": 2.0}  # With the largest ratios.


def arguments_of(place: str, computers: int) -> List[str]:
    if place == "one computer":
        return []
    names = ",".join(f"n{1 + index}" for index in range(computers))
    plain = [] if place.endswith("CURVE") else ["--insecure-tcp"]
    return ["--engine", "ssh", "--computers", names, "--set", "placement=spread", *plain]


def machine_pids(folder: pathlib.Path) -> List[int]:
    """Processes whose programs lie in `folder`, on all computers."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "exe").readlink().parent == folder:
                found.append(int(entry.name))
        except OSError:
            continue  # It has gone.
    return found


def cpu_seconds(pids: List[int]) -> float:
    """Processor time of all threads so far, to the nanosecond: ticks of 10 ms are too coarse."""
    nanoseconds = 0
    for pid in pids:
        for schedstat in pathlib.Path(f"/proc/{pid}/task").glob("*/schedstat"):
            nanoseconds += int(schedstat.read_text(encoding="utf-8").split()[0])
    return nanoseconds / 1e9


def cpu_ms_per_frame(cluster: Cluster, program: pathlib.Path, words: argparse.Namespace,
                     place: str) -> float:
    machine = cluster.popen("login", [str(program), "run", "--json", "--record", "off",
                                      "--topology", words.topology,
                                      *arguments_of(place, words.computers), "-"],
                            stdin=-1, stdout=-1, stderr=-1, text=True)
    for line in [*SCENE, f"orbit {words.frames}"]:
        session.run_line(machine, line)
    pids = machine_pids(program.parent)
    before = cpu_seconds(pids)
    session.run_line(machine, f"orbit {words.frames}")
    used = cpu_seconds(pids) - before
    machine.communicate(timeout=LIMIT_S)
    cluster.wait_until_idle()
    return 1000 * used / words.frames


def main() -> int:
    parser = parser_of(__doc__, runs=3)
    parser.add_argument("--frames", type=int, default=60)
    words = parser.parse_args()
    if reason := missing([words.program.parent]):
        print(f"SKIPPED: {reason}")
        return 0
    samples: Dict[str, List[float]] = {place: [] for place in PLACES}
    with Cluster(computers=words.computers, slots=64, shared=[words.program.parent]) as cluster:
        for _ in range(words.runs):
            for place, found in samples.items():
                found.append(cpu_ms_per_frame(cluster, words.program, words, place))
    ratios = {place: figures.pairwise_ratio(found, samples["one computer"])
              for place, found in samples.items()}
    print(f"{words.topology}, {words.computers} computers, {words.runs} runs of {words.frames} "
          "frames")
    print(figures.table(["place", "CPU ms per frame", "ratio"],
                        [[place, f"{figures.median(found):.1f}", f"{ratios[place]:.2f}"]
                         for place, found in samples.items()]))
    return int(words.check and any(most and ratios[place] > most
                                   for place, most in PLACES.items()))


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
