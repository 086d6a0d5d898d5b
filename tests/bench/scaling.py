#!/usr/bin/env python3
"""How cost grows with the machine, the volume and the picture, and what bounds each.

usage: scaling.py PXPL5 [--only machines,volumes,pictures] [--frames N] [--long]

Prints markdown tables. Shares are of all cores' time while frames are drawn: GP, Renderer, frame
buffer and host, ZeroMQ's threads of all of them as 'io'; cores without work are 'idle', and what is
left went to 'others', which have no place on a computer that measures. --long goes to 36 x 16
nodes, 512^3 voxels and 2048 x 2048 pixels.
"""
import argparse
import os
import sys
from typing import Dict, List, NamedTuple

import figures
import loads
import measure
import processes
import session

MACHINES = [(1, 1), (2, 1), (1, 2), (2, 2), (4, 4)]
MACHINES_LONG = [(gps, renderers) for gps in range(1, 5) for renderers in range(1, 5)] + [(36, 16)]
VOLUMES, VOLUMES_LONG = (64, 128, 256), (64, 128, 256, 512)
PICTURES, PICTURES_LONG = (256, 512, 1024), (256, 512, 768, 1024, 1536, 2048)
PARTS = ("machines", "volumes", "pictures")
USUAL = loads.Load("head", "phantom:head", "skin", 70.5)
GENERATED_ISOVALUE = 290.5  # Bone of the pelvis that bench_volume samples.
CHANGES = 9
KINDS = {"pxpl5": "host", "pxpl5-gp": "GP", "pxpl5-renderer": "Renderer",
         "pxpl5-framebuff": "frame buffer"}  # The kernel keeps 15 letters of a name.
NO_BOUND = 0.35  # Shares below this, of the largest, name nothing.


class Row(NamedTuple):
    """One machine on one volume and picture."""
    triangles: int
    extraction_ms: float
    frame_ms: float
    shares: Dict[str, float]


def by_kind(parts: Dict[str, float]) -> Dict[str, float]:
    """Shares of threads put together by what they do."""
    kinds: Dict[str, float] = {}
    for name, share in parts.items():
        kind = "io" if name.endswith(" io") else KINDS.get(name, name)
        kinds[kind] = kinds.get(kind, 0.0) + share
    return kinds


def bound_by(shares: Dict[str, float]) -> str:
    """The kind of the largest share, or 'nothing alone' if it is small."""
    kind = max(shares, key=shares.get)
    return kind if shares[kind] >= NO_BOUND else "nothing alone"


def share_text(shares: Dict[str, float]) -> str:
    """'GP 40 %, Renderer 30 %': from 5 % up, the largest first."""
    shown = sorted((item for item in shares.items() if item[1] >= 0.05),
                   key=lambda item: -item[1])
    return ", ".join(f"{kind} {share * 100:.0f} %" for kind, share in shown)


def measure_row(args, load: loads.Load, size: str, settings: List[str]) -> Row:
    """A row on a machine of its own."""
    with session.Session(args.program, settings=settings) as machine:
        machine.run(f"size {size}")
        at = measure.Load(machine, load)
        extraction_ms = figures.median(at.extraction(CHANGES))
        at.rate(measure.WARM_UP)
        pids = processes.family(machine.process.pid)
        before = processes.usage(pids)
        rate = machine.run(f"orbit {args.frames}")["frames_per_s"]
        parts = processes.shares(before, processes.usage(pids), os.cpu_count())
    return Row(at.triangles, extraction_ms, 1000 / rate, by_kind(parts))


def table_of(names: List[str], rows: List[Row]) -> str:
    """A markdown table, a row a line."""
    head = ["", "triangles", "isovalue -> surface, ms", "frame, ms", "bound by", "shares"]
    return figures.table(head, [
        [name, str(row.triangles), f"{row.extraction_ms:.1f}", f"{row.frame_ms:.1f}",
         bound_by(row.shares), share_text(row.shares)] for name, row in zip(names, rows)])


def of_machines(args) -> str:
    wanted = MACHINES_LONG if args.long else MACHINES
    rows = [measure_row(args, USUAL, "512x512", [f"gp.count={gps}", f"renderer.count={renderers}"])
            for gps, renderers in wanted]
    return table_of([f"GP {gps}, Renderer {renderers}" for gps, renderers in wanted], rows)


def of_volumes(args) -> str:
    wanted, rows = VOLUMES_LONG if args.long else VOLUMES, []
    for side in wanted:
        with measure.generated_volume(args.program, (side, side, side)) as path:
            load = loads.Load("bone", path, "bone", GENERATED_ISOVALUE)
            rows.append(measure_row(args, load, "512x512", []))
    return table_of([f"{side}^3 voxels" for side in wanted], rows)


def of_pictures(args) -> str:
    wanted = [f"{side}x{side}" for side in (PICTURES_LONG if args.long else PICTURES)]
    return table_of(wanted, [measure_row(args, USUAL, size, []) for size in wanted])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", help="path of pxpl5")
    parser.add_argument("--only", default=",".join(PARTS))
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--long", action="store_true")
    args = parser.parse_args()
    tables = {"machines": of_machines, "volumes": of_volumes, "pictures": of_pictures}
    unknown = sorted(set(args.only.split(",")) - set(tables))
    if unknown:
        parser.error(f"--only: there is no {unknown[0]}; there are {', '.join(PARTS)}")
    print(", ".join(f"{key} {value}" for key, value in measure.origin("built in").items()))
    for part in args.only.split(","):
        print("\n" + tables[part](args), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(session.told_errors(main))
