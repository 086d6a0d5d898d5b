"""C++ is as clang-format leaves it."""
import pathlib
import re
import shutil
import subprocess
from typing import List

import tree

FILES_AT_ONCE = 50


class Skipped(Exception):
    """The tool is not installed."""


def check(root: pathlib.Path) -> List[str]:
    tool = shutil.which("clang-format") or shutil.which("clang-format-14")
    if tool is None:
        raise Skipped("clang-format is not installed")
    paths = [str(p) for p in tree.files_of(root) if p.suffix in tree.CPP]
    errors = []
    for first in range(0, len(paths), FILES_AT_ONCE):
        some = paths[first:first + FILES_AT_ONCE]
        done = subprocess.run([tool, "--dry-run", "--style=file", *some], cwd=root,
                              capture_output=True, text=True)
        lines = re.findall(r"^(\S+?):(\d+):\d+: (?:warning|error): ", done.stderr, re.M)
        for name in dict.fromkeys(name for name, _ in lines):
            number = next(n for other, n in lines if other == name)
            errors.append(f"{name}:{number}: not as clang-format leaves it; run: "
                          f"clang-format -i {name}")
        if done.returncode != 0 and not lines:
            errors.append(f"{tool} failed: {done.stderr.strip()}")
    return errors
