#!/usr/bin/env python3
"""Runs one checker over the repository: tidy.py CHECK ROOT; CHECKS has
the names."""
import importlib
import pathlib
import sys

CHECKS = ("includes", "lengths", "layout", "folders", "words", "english", "links",
          "decisions", "definitions", "unused", "vocabulary", "walks", "styles", "format")


def main(arguments) -> int:
    if len(arguments) != 2 or arguments[0] not in CHECKS:
        print(__doc__, file=sys.stderr)
        return 64
    checker = importlib.import_module("check_" + arguments[0])
    try:
        errors = checker.check(pathlib.Path(arguments[1]).resolve())
    except Exception as error:  # Only "Skipped" is no failure.
        if type(error).__name__ != "Skipped":
            raise
        print(f"SKIPPED: {error}")
        return 0
    for error in errors:
        print(error)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
