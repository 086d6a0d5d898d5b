"""What the programs share that measure machines on the test cluster: see tests/cluster."""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cluster"))
from cluster import Cluster, missing  # noqa: E402, F401


def parser_of(documentation: str, runs: int) -> argparse.ArgumentParser:
    """The options of a program that compares several computers with one.

    documentation  Of the program; its first line describes the program.
    runs           By default, of each place.
    """
    parser = argparse.ArgumentParser(description=documentation.splitlines()[0])
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--topology", default="paper-1993")
    parser.add_argument("--computers", type=int, default=3)
    parser.add_argument("--runs", type=int, default=runs)
    parser.add_argument("--check", action="store_true")
    return parser
