"""No folder holds more source files than a reader can take in."""
import collections
import pathlib
from typing import List

import tree

MAX_SOURCES = 30
SOURCES = tree.CPP | {".js", ".py", ".def", ".fbs"}


def check(root: pathlib.Path) -> List[str]:
    counts = collections.Counter(
        path.parent.as_posix() for path in tree.files_of(root) if path.suffix in SOURCES)
    return [f"{folder}: {count} source files, at most {MAX_SOURCES}: divide it into folders"
            for folder, count in sorted(counts.items()) if count > MAX_SOURCES]
