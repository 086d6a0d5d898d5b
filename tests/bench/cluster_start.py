#!/usr/bin/env python3
"""Time to start a machine on several computers by Slurm, beside that on one computer.

usage: cluster_start.py PXPL5 [--topology NAME] [--computers N] [--runs N] [--check]

The computers are those of tests/cluster: see the README there. All use this computer's processors.
Runs alternate: one computer; the nodes of an allocation, without and with CURVE; a new allocation,
whose salloc counts. A start ends with the answer to the first command. Prints a Markdown table:
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
from clusters import Cluster, missing, parser_of

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
    complaint = machine.communicate(timeout=LIMIT_S)[1]
    if machine.returncode != 0:
        raise session.MeasureError(f"exit code {machine.returncode}: {complaint}")
    return taken_s


def command_of(words: argparse.Namespace, more: List[str]) -> List[str]:
    return [str(words.program), "run", "--json", "--record", "off", "--run-folder", "runs",
            "--topology", words.topology, *more]


def sample(cluster: Cluster, words: argparse.Namespace, place: str) -> float:
    """One start on the login computer, alone or as the command of salloc."""
    allocate = ["salloc", "--quiet", f"-N{words.computers}", f"-n{words.computers}"]
    if place == BY_SALLOC:
        def popen(command, **pipes):
            return cluster.popen("login", [*allocate, *command], **pipes)
        taken_s = start_s(popen, command_of(words, SLURM))
    else:  # This program, as the allocation's command, takes the time.
        inner = cluster.login([*allocate, "python3", "-B", str(pathlib.Path(__file__).resolve()),
                               str(words.program), "--topology", words.topology, "--inside",
                               place], timeout=LIMIT_S)
        taken_s = json.loads(inner.stdout.splitlines()[-1])
    cluster.wait_until_idle()
    return taken_s


def main() -> int:
    parser = parser_of(__doc__, runs=7)
    parser.add_argument("--inside", choices=IN_ALLOCATION, help=argparse.SUPPRESS)
    words = parser.parse_args()
    if words.inside:
        print(start_s(subprocess.Popen, command_of(words, IN_ALLOCATION[words.inside])))
        return 0
    if reason := missing([words.program.parent]):
        print(f"SKIPPED: {reason}")
        return 0
    with Cluster(computers=words.computers, slots=64, shared=[words.program.parent]) as cluster:
        samples: Dict[str, List[float]] = {place: [] for place in (*IN_ALLOCATION, BY_SALLOC)}
        for _ in range(words.runs):
            for place, found in samples.items():
                found.append(sample(cluster, words, place))
    local = samples["one computer"]
    ratios = {place: figures.pairwise_ratio(found, local) for place, found in samples.items()}
    print(f"{words.topology}, {words.computers} computers, {words.runs} starts each")
    print(figures.table(["place", "s", "ratio"],
                        [[place, f"{figures.median(found):.3f}", f"{ratios[place]:.2f}"]
                         for place, found in samples.items()]))
    return int(words.check and any(ratios[place] > most for place, most in LIMITS.items()))


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
