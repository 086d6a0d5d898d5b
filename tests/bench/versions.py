#!/usr/bin/env python3
"""Compares two builds of pxpl5: versions.py OLD NEW [--check].

Both machines run at the same time and work in turns, so that what else the computer does is the
same for both. A ratio is the median over all turns of NEW's figure over OLD's figure beside it.
"""
import argparse
import collections
import contextlib
import math
import sys
from typing import Dict, List

import figures
import loads
import measure
import session

# By how much NEW may be worse than OLD, over all loads.
MOST_LOSS = 0.02
# Whether more is better.
WHAT = {"extraction ms": False, "isovalue to picture ms": False, "frames/s": True,
        "CPU ms/frame": False}


def measure_turn(at: measure.Load, count: int) -> Dict[str, float]:
    """The figures of one machine's turn."""
    rate, cpu_ms = at.rate_and_cpu(count)
    return {"extraction ms": figures.median(at.extraction(count)),
            "isovalue to picture ms": at.isovalue_to_picture(count)["median"],
            "frames/s": rate, "CPU ms/frame": cpu_ms}


def compare(programs: List[str], topology: str, load: loads.Load, rounds: int,
            count: int) -> Dict[str, List[List[float]]]:
    """For each figure, the samples of each program.

    The machine that was started first can be faster as long as both run, as if memory were placed
    better: two equal builds differed by up to 4 %. So half of the rounds use machines that were
    started in the other order.
    """
    samples: Dict[str, List[List[float]]] = collections.defaultdict(lambda: [[], []])
    for started, turns in (((0, 1), rounds - rounds // 2), ((1, 0), rounds // 2)):
        with contextlib.ExitStack() as stack:
            machines = {which: stack.enter_context(session.Session(programs[which], topology))
                        for which in started}
            for machine in machines.values():
                machine.run("size 512x512")
            both = {which: measure.Load(machines[which], load) for which in started}
            for number in range(turns):
                # Who is first changes: the second finds other caches and another clock.
                for which in (started if number % 2 == 0 else started[::-1]):
                    for name, value in measure_turn(both[which], count).items():
                        samples[name][which].append(value)
    return samples


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("old", help="path of pxpl5, the older build")
    parser.add_argument("new", help="path of pxpl5, the newer build")
    parser.add_argument("--topology", default="default")
    parser.add_argument("--data", default="", help="folder of real volumes, or: phantoms")
    parser.add_argument("--loads", default="", help="only these: skin,muscle,bone,ultrasound,head")
    parser.add_argument("--rounds", type=int, default=10, help="turns of each build")
    parser.add_argument("--count", type=int, default=40, help="changes, and frames, of each turn")
    parser.add_argument("--check", action="store_true",
                        help=f"exit code 1 if NEW is worse by more than {MOST_LOSS:.0%}, as the "
                             f"mean of all loads")
    args = parser.parse_args()
    measure.check_count(parser, args.count)
    if args.rounds < 2:
        parser.error(f"--rounds is 2 or more; it is {args.rounds}")
    _, wanted = loads.chosen_loads(args.new, args.data, args.loads)
    rows, logs = [], collections.defaultdict(list)
    for load in wanted:
        samples = compare([args.old, args.new], args.topology, load, args.rounds, args.count)
        row = [load.key]
        for name in WHAT:
            old, new = samples[name]
            ratio = figures.pairwise_ratio(new, old)
            logs[name].append(math.log(ratio))
            row.append(f"{figures.rounded(figures.median(old))} → "
                       f"{figures.rounded(figures.median(new))}: {ratio:.3f}")
        rows.append(row)
    means = {name: math.exp(sum(values) / len(values)) for name, values in logs.items()}
    rows.append(["geometric mean"] + [f"{means[name]:.3f}" for name in WHAT])
    print(figures.table(["load", *WHAT], rows))
    missed = [f"{name} {means[name]:.3f}" for name, is_rate in WHAT.items()
              if (1 / means[name] if is_rate else means[name]) > 1 + MOST_LOSS]
    if missed:
        print(f"worse by more than {MOST_LOSS:.0%}: {', '.join(missed)}")
    return 1 if missed and args.check else 0


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
