"""Every shared enum, limit and rule has one definition."""
import pathlib
import re
from typing import Iterator, List, Tuple

import tree

ENUMS = "ringbus/schema/vocabulary.fbs"
RULES = "ringbus/rules/"
GENERATED = "host/serve/page/link/vocabulary.js"
MIRROR = re.compile(r"static_assert\(\s*static_cast<int>\([\w:]+\)\s*==\s*static_cast<int>\(")
REGION = re.compile(r"\b128 ?\* ?128\b")


def _names(root: pathlib.Path, files: List[pathlib.Path], pattern: str,
           of: str) -> Iterator[Tuple[str, str]]:
    """Names that files of this kind define, each with its file. A second one is a fault, too."""
    for path in files:
        if path.as_posix().startswith(of) or path.name == of:
            for name in re.findall(pattern, tree.read(root, path), re.M):
                yield name, path.as_posix()


def _code(root: pathlib.Path, path: pathlib.Path) -> str:
    text = tree.read(root, path)
    return re.sub(r"//.*", "", text) if path.suffix in {".fbs", ".js"} else tree.bare_code(text)


def _found(path: pathlib.Path, code: str, pattern: str, what: str) -> List[str]:
    return [f"{path}:{code.count(chr(10), 0, match.start()) + 1}: {what}"
            for match in re.finditer(pattern, code)]


def check(root: pathlib.Path) -> List[str]:
    files = tree.files_of(root)
    limits = list(_names(root, files, r"^LIMIT\([^,]+, (\w+)", "limits.def"))
    enums = list(_names(root, files, r"^enum (\w+)", ENUMS))
    rules = list(_names(root, files, r"^struct (\w+)", RULES))
    errors = [f"{path}: {name} is defined in another limits.def, too"
              for i, (name, path) in enumerate(limits)
              if name in [other for other, _ in limits[:i]]]
    for path in files:
        if path.suffix not in tree.CPP | {".fbs", ".js"} or path.parts[0] == "tests" or \
                path.as_posix() == GENERATED:
            continue
        code = _code(root, path)
        for name, home in limits:
            constant = rf"(?:constexpr|const)\s+(?:[\w:<>]+\s+)?(?:\w+ = [^;,]+,\s*)*" \
                       rf"(?:{name}|{name.upper()})\s*(?:=|\{{)"
            errors += _found(path, code, constant, f"{name} is defined in {home}")
        for name, home in enums:
            if path.as_posix() != home:
                errors += _found(path, code, rf"(?<!using )\benum\s+(?:class\s+)?{name}\b",
                                 f"{name} is defined in {home}")
        for name, home in rules:
            if path.as_posix() != home:
                errors += _found(path, code, rf"\bstruct\s+{name}\s*\{{",
                                 f"{name} is defined in {home}")
        if path.suffix in tree.CPP:
            errors += _found(path, code, MIRROR.pattern, "two enums of the same values: use one")
            errors += _found(path, code, REGION.pattern, "write region_pixels")
    return errors
