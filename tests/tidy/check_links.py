"""Files that documents name exist."""
import fnmatch
import pathlib
import re
from typing import List, Set

import tree

LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
NAME = re.compile(r"`([\w./*-]+\.(?:cpp|hpp|def|fbs|md|py|sh|h|\*))`")
ELSEWHERE = ("http://", "https://", "mailto:", "../shared/")
MADE_AT_RUN = ("build/", "run/")
FILE_ROW = re.compile(r"^\| (`[^|]*?) \|")  # A row of a table of files names the files first.


def _exists(root: pathlib.Path, folder: pathlib.PurePath, name: str, names: Set[str]) -> bool:
    """Below the document's folder, below the top, or, for a bare name, anywhere."""
    candidates = [(folder / name).as_posix(), name]
    if "*" not in name and any((root / candidate).exists() for candidate in candidates):
        return True
    patterns = candidates + ([f"*/{name}"] if "/" not in name else [f"*/{name}"])
    return any(fnmatch.filter(names, pattern) for pattern in patterns)


def _is_below(folder: pathlib.PurePath, name: str, names: Set[str]) -> bool:
    return any(fnmatch.filter(names, (folder / place / name).as_posix()) for place in ("", "*"))


def check(root: pathlib.Path) -> List[str]:
    files = tree.files_of(root)
    names = {path.as_posix() for path in files}
    errors = []
    for path in (p for p in files if p.suffix == ".md"):
        table = ""  # The first row of the table around the line.
        for number, line in enumerate(tree.read(root, path).splitlines(), 1):
            is_row = line.startswith("|")
            table = (table or line) if is_row else ""
            for target in LINK.findall(line):
                if not target.startswith(ELSEWHERE) and not (root / path.parent / target).exists():
                    errors.append(f"{path}:{number}: links to {target}, which does not exist")
            for name in NAME.findall(line):
                if not name.startswith(ELSEWHERE + MADE_AT_RUN) and \
                        not _exists(root, path.parent, name, names):
                    errors.append(f"{path}:{number}: names {name}, which does not exist")
            row = FILE_ROW.match(line) if table.startswith("| file |") else None
            for name in NAME.findall(row[1]) if row else []:
                if not _is_below(path.parent, name, names):
                    errors.append(f"{path}:{number}: lists {name}, which is not in {path.parent}")
    return errors
