#!/usr/bin/env python3
"""Time to start a machine on several computers by Slurm, beside that on one computer.

usage: cluster_start.py PXPL5 [--topology NAME] [--computers N] [--runs N] [--check]

The computers are those of tests/cluster: see the README there. All use this computer's processors.
Runs alternate: one computer, then the nodes of an allocation (without and with CURVE), then a new
allocation by salloc. A start ends with the answer to the first command. Prints a Markdown table:
medians, and pairwise ratios to one computer. --check: exit code 1 if the ratio in an allocation is
above 2.5. SKIPPED where no cluster can be.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import time
from typing import Callable, Dict, List

import figures
import session

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cluster"))
from cluster import Cluster, missing  # noqa: E402

LIMIT_S = 600
FIRST = "activity"
SLURM = ["--engine", "slurm"]
IN_ALLOCATION = {"one computer": [], "in an allocation": [*SLURM, "--insecure-tcp"],
                 "in an allocation, CURVE": SLURM}
BY_SALLOC = "with salloc, CURVE"
LIMITS = {place: 2.5 for place, words in IN_ALLOCATION.items() if words}


def start_s(popen: Callable[..., subprocess.Popen], command: List[str]) -> float:
    """Seconds from the start of a program to its answer to the first command."""
    begin_s = time.perf_counter()
    machine = popen([*command, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE, text=True)
    session.run_line(machine, FIRST)
    taken_s = time.perf_counter() - begin_s
    machine.communicate(timeout=LIMIT_S)
    return taken_s


def command_of(words: argparse.Namespace, more: List[str]) -> List[str]:
    return [str(words.program), "run", "--json", "--record", "off", "--run-folder", "runs",
            "--topology", words.topology, *more]


def samples_in_allocation(words: argparse.Namespace) -> Dict[str, List[float]]:
    """Runs in the command of salloc."""
    found: Dict[str, List[float]] = {place: [] for place in IN_ALLOCATION}
    for _ in range(words.runs):
        for place, more in IN_ALLOCATION.items():
            found[place].append(start_s(subprocess.Popen, command_of(words, more)))
    return found


def samples_on(cluster: Cluster, words: argparse.Namespace) -> Dict[str, List[float]]:
    allocate = ["salloc", "--quiet", f"-N{words.computers}", f"-n{words.computers}"]
    inner = cluster.login([*allocate, "python3", "-B", str(pathlib.Path(__file__).resolve()),
                           str(words.program), "--topology", words.topology, "--runs",
                           str(words.runs), "--inside"], timeout=LIMIT_S)
    found = json.loads(inner.stdout.splitlines()[-1])
    cluster.wait_until_idle()
    found[BY_SALLOC] = []
    for _ in range(words.runs):
        def popen(command, **pipes):
            return cluster.popen("login", [*allocate, *command], **pipes)
        found[BY_SALLOC].append(start_s(popen, command_of(words, SLURM)))
        cluster.wait_until_idle()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--topology", default="paper-1993")
    parser.add_argument("--computers", type=int, default=3)
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    words = parser.parse_args()
    if words.inside:
        print(json.dumps(samples_in_allocation(words)))
        return 0
    if reason := missing([words.program.parent]):
        print(f"SKIPPED: {reason}")
        return 0
    with Cluster(computers=words.computers, slots=64, shared=[words.program.parent]) as cluster:
        samples = samples_on(cluster, words)
    local = samples["one computer"]
    ratios = {place: figures.pairwise_ratio(found, local) for place, found in samples.items()}
    print(f"{words.topology}, {words.computers} computers, {words.runs} starts each")
    print(figures.table(["place", "s", "ratio"],
                        [[place, f"{figures.median(found):.3f}", f"{ratios[place]:.2f}"]
                         for place, found in samples.items()]))
    return int(words.check and any(ratios[place] > most for place, most in LIMITS.items()))


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
