"""Decision records are complete and numbered, and each has a row in host/DECISIONS.md."""
import os
import pathlib
import re
from typing import List

import tree

INDEX = pathlib.Path("host/DECISIONS.md")
# "### GP-1 Title (2026-11-21)", "**FB-1. Title** (2026-11-21).", "**ISA-1: title.**"
HEADING = re.compile(r"^(?:#+ |\*\*)(?P<number>[A-Z]{2,5}-\d+)[.:]? (?P<title>.+?)"
                     r"\.?(?:\*\*.*| \(\d{4}-\d\d-\d\d\)\s*)?$", re.M)
PARTS = ("Context", "Decision", "Reason", "Cost")
RECORD = re.compile(r"\*+Decision:\*+")
ROW = re.compile(r"^\| [A-Z]{2,5}-\d+ \|.*$", re.M)


def row_of(path: pathlib.PurePath, heading: re.Match) -> str:
    title = heading["title"][0].upper() + heading["title"][1:]
    link = os.path.relpath(path, INDEX.parent)
    return f"| {heading['number']} | {title} | [{path.parent}]({link}) |"


def errors_of(path: pathlib.PurePath, text: str) -> List[str]:
    errors, headings = [], list(HEADING.finditer(text))
    ends = [heading.start() for heading in headings[1:]] + [len(text)]
    for heading, end in zip(headings, ends):
        missing = [part for part in PARTS if f"*{part}:*" not in text[heading.start():end]]
        if missing:
            errors.append(f"{path}: {heading['number']} has no {', '.join(missing)}")
    records = len(RECORD.findall(text))
    if records > len(headings):
        errors.append(f"{path}: {records} decisions, but {len(headings)} headings with a number: "
                      "write '**GP-1. Title** (date).' before each")
    return errors


def check(root: pathlib.Path) -> List[str]:
    documents = [path for path in tree.files_of(root) if path.suffix == ".md" and path != INDEX]
    errors, rows, first_use = [], set(), {}
    for path in documents:
        text = tree.read(root, path)
        errors += errors_of(path, text)
        for heading in HEADING.finditer(text):
            rows.add(row_of(path, heading))
            first = first_use.setdefault(heading["number"], (path, heading.start()))
            if first != (path, heading.start()):
                errors.append(f"{path}: {heading['number']} is also a decision of {first[0]}")
    index = set(ROW.findall(tree.read(root, INDEX))) if (root / INDEX).is_file() else set()
    errors += [f"{INDEX}: add the row {row}" for row in sorted(rows - index)]
    errors += [f"{INDEX}: remove the row {row}" for row in sorted(index - rows)]
    return errors
