#!/usr/bin/env python3
"""What two views and depths cost, against one view in the same run.

usage: stereo.py PXPL5 [--data FOLDER|phantoms] [--topology default] [--size 512x512,1024x1024]
                 [--rounds N] [--frames N] [--check]

Prints a markdown table. In each round, the machine draws the same views in four ways: one view, one
view with depths, two views, two views with depths. Then the server's work on a picture is measured:
the depths reduced (lean_depths), packed, and for comparison the picture as JPEG. A ratio is the
median over the rounds of a way's time over that of one view in the same round. One frame is in
flight. CPU is the processor time of all processes of the machine. With --check the verdicts on
the goals follow on standard error, and the exit code is 1 if one is missed.
"""
import argparse
import json
import pathlib
import subprocess
import sys
from typing import Dict, List, NamedTuple

import figures
import goals
import machine
import measure
import session

ROWS = (("view", "one view"), ("view_depths", "one view, depths"), ("pair", "two views"),
        ("pair_depths", "two views, depths"), ("lean", "server: lean depths"),
        ("pack", "server: pack them"), ("jpeg", "server: JPEG"))
BASE = ROWS[0][0]
USUAL_DATA = pathlib.Path(__file__).resolve().parents[3] / "shared" / "data"


class Scene(NamedTuple):
    """A volume and its surfaces."""
    key: str
    commands: List[str]


def scenes_of(data: str) -> List[Scene]:
    """The built-in pelvis, and the chest CT if `data`, a folder, has it."""
    scenes = [Scene("pelvis", ["load phantom:pelvis", "surface bone"])]
    if data != "phantoms":
        path = (pathlib.Path(data) if data else USUAL_DATA) / "ct/torso_3mm.nii.gz"
        if path.is_file():
            scenes.append(Scene("chest", [f"load {path.resolve()} resample=512x512x275",
                                          "surface bone iso=150"]))
        elif data:
            raise session.MeasureError(f"{path}: not there; --data names the folder of volumes")
    return scenes


def samples_of(args, scene: Scene) -> dict:
    """All samples of one scene. Raises MeasureError with what stereo_bench complained about."""
    command = [measure.tool(args.program, "stereo_bench"), args.topology, args.size,
               str(args.rounds), str(args.frames), *scene.commands]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          check=False)
    if done.returncode != 0:
        raise session.MeasureError(f"{scene.key}: stereo_bench: {done.stderr.strip()[-400:]}")
    return json.loads(done.stdout.splitlines()[-1])


def ratios_of(samples: dict, row: str) -> Dict[str, float]:
    """A row's wall and processor time over those of one view."""
    return {clock: figures.pairwise_ratio(samples[row][clock], samples[BASE][clock])
            for clock in ("wall_ms", "cpu_ms")}


def figures_of(samples: dict, place: str) -> Dict[str, float]:
    """By the names of goals. place  As "default/512x512/pelvis"."""
    named = {}
    for row in ("view_depths", "pair", "pair_depths"):
        ratios = ratios_of(samples, row)
        named[f"{row}_ratio/{place}"] = figures.rounded(ratios["wall_ms"])
        named[f"{row}_cpu_ratio/{place}"] = figures.rounded(ratios["cpu_ms"])
    return named


def table_of(samples: dict) -> str:
    """A markdown table, a row a line."""
    rows = []
    for row, name in ROWS:
        ratios = ratios_of(samples, row)
        cells = [f"{figures.median(samples[row][clock]):.2f}" for clock in ("wall_ms", "cpu_ms")]
        rows.append([name, *cells, f"{ratios['wall_ms']:.3f}", f"{ratios['cpu_ms']:.3f}"])
    return figures.table(["", "ms", "CPU ms", "of one view", "CPU of one view"], rows)


def parse(arguments):
    """The command line. Ends the program if it is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", help="path of pxpl5")
    parser.add_argument("--data", default="", help="folder of real volumes, or: phantoms")
    parser.add_argument("--topology", default="default")
    parser.add_argument("--size", default="512x512,1024x1024", help="sizes of one view")
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--frames", type=int, default=8, help="of each way in each round")
    parser.add_argument("--check", action="store_true", help="exit code 1 if a goal is missed")
    args = parser.parse_args(arguments)
    for name in ("rounds", "frames"):
        if getattr(args, name) < 1:
            parser.error(f"--{name} is 1 or more; it is {getattr(args, name)}")
    return args


def main() -> int:
    args = parse(sys.argv[1:])
    scenes, named = scenes_of(args.data), {}
    print(", ".join(f"{key} {value}" for key, value in
                    measure.origin("pelvis built in, chest real").items()))
    for scene in scenes:
        measured = samples_of(args, scene)
        for size in args.size.split(","):
            samples = measured["sizes"][size]
            place = f"{args.topology}/{size}/{scene.key}"
            print(f"\n{place}: {measured['triangles']} triangles, packed depths "
                  f"{samples['packed_bytes']} bytes\n\n{table_of(samples)}", flush=True)
            named.update(figures_of(samples, place))
    return machine.tell(named, args.check)


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
