#!/usr/bin/env python3
"""Measures the whole machine: how long a person waits, and how many frames a second there are.

usage: machine.py PXPL5 [--topology default,one-of-each,paper-1993] [--size 512x512,1280x1024]
                  [--data FOLDER|phantoms] [--loads skin,head] [--runs N] [--count N]
                  [--only stages,loads,big,memory,start,recording | --only all] [--check]

Prints one JSON line: where and of what, medians and 95th percentiles by figure; goals.py says how
figures are named. With --check each goal follows on standard error, and the exit code is 1 if one
is missed. Times on a computer that does other work say little: load_average tells.
"""
import argparse
import json
import sys

import goals
import loads
import measure
import session

PARTS = ("stages", "loads", "big", "memory", "start", "recording")
STARTS = 3


def parse(arguments):
    """The command line. Ends the program if it is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", help="path of pxpl5")
    parser.add_argument("--topology", default="default", help="names, separated by commas")
    parser.add_argument("--size", default="512x512,1280x1024", help="sizes of pictures")
    parser.add_argument("--data", default="", help="folder of real volumes, or: phantoms")
    parser.add_argument("--loads", default="", help="only these: skin,muscle,bone,ultrasound,head")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--count", type=int, default=60, help="changes, and frames, of each run")
    parser.add_argument("--only", default="loads", help=f"of {','.join(PARTS)}; or: all")
    parser.add_argument("--check", action="store_true", help="exit code 1 if a goal is missed")
    args = parser.parse_args(arguments)
    args.parts = PARTS if args.only == "all" else args.only.split(",")
    for part in args.parts:
        if part not in PARTS:
            parser.error(f"--only: there is no {part}; there are {', '.join(PARTS)}")
    if args.runs < 1:
        parser.error(f"--runs is 1 or more; it is {args.runs}")
    measure.check_count(parser, args.count)
    return args


def measure_topology(args, topology: str, wanted, out: measure.Figures):
    """All parts that were asked for, on one machine."""
    program = args.program
    if "loads" in args.parts:
        for _ in range(args.runs):
            for size in args.size.split(","):
                measure.measure_loads(program, topology, size, wanted, args.count, out)
    if "big" in args.parts:
        with measure.generated_volume(program, measure.BIG) as path:
            for _ in range(args.runs):
                measure.measure_big(program, topology, path, max(5, args.count // 6), out)
    if "memory" in args.parts:
        out.add_one(f"memory_mib/{topology}",
                    measure.memory_mib(program, topology, wanted[0]))
    if "start" in args.parts:
        out.add(f"first_picture_s/{topology}",
                [measure.first_picture_s(program, topology) for _ in range(STARTS)])
    if "recording" in args.parts:
        measure.measure_recording(program, topology, wanted[0], args.runs, out)


def tell(medians, check: bool) -> int:
    """Prints the goals' verdicts if asked. Returns the exit code."""
    if not check:
        return 0
    verdicts = goals.judge(medians)
    for verdict in verdicts:
        print(goals.text_of(verdict), file=sys.stderr)
    if not verdicts:
        print("no goal is about what was measured", file=sys.stderr)
    return 0 if verdicts and all(verdict.met for verdict in verdicts) else 1


def main() -> int:
    args = parse(sys.argv[1:])
    kind, wanted = loads.chosen_loads(args.program, args.data, args.loads)
    out = measure.Figures()
    line = measure.origin(kind)
    if "stages" in args.parts:
        measure.measure_stages(measure.tool(args.program, "stage_bench"), line["vector_target"],
                               args.runs, out)
    for topology in args.topology.split(","):
        measure_topology(args, topology, wanted, out)
    medians = out.over_runs()
    line.update({"topology": args.topology, "runs": args.runs, "count": args.count,
                 "medians": medians, "p95": out.p95_over_runs()})
    print(json.dumps(line))
    return tell(medians, args.check)


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
