#!/usr/bin/env python3
"""Prints which share of the product's lines the tests executed: coverage.py BUILD.

BUILD is a folder of preset dev in which the tests ran. The details are in BUILD/coverage.json.
"""
import collections
import json
import os
import pathlib
import subprocess
import sys

PRODUCT = ("isa", "ringbus", "gp_firmware", "renderer_firmware", "host")


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 64
    root = pathlib.Path(__file__).resolve().parents[1]
    build = pathlib.Path(arguments[0]).resolve()
    report = build / "coverage.json"
    subprocess.run(
        ["gcovr", "--root", root, "-j", str(len(os.sched_getaffinity(0))), "--json-summary", report,
         "--gcov-executable", "llvm-cov-19 gcov",
         "--gcov-ignore-parse-errors",  # Threads can make the counters of branches negative.
         *(word for folder in PRODUCT for word in ("--filter", f"{root}/{folder}/")),
         *(build / folder for folder in PRODUCT)],
        check=True)
    lines = collections.defaultdict(lambda: [0, 0])
    for file in json.loads(report.read_text())["files"]:
        for name in ("total", file["filename"].split("/")[0]):
            lines[name][0] += file["line_covered"]
            lines[name][1] += file["line_total"]
    percent = {name: 100 * covered / total for name, (covered, total) in lines.items()}
    folders = ", ".join(f"{folder} {percent[folder]:.1f}" for folder in PRODUCT)
    print(f"coverage: {percent['total']:.1f} % of {lines['total'][1]} lines ({folders})")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
