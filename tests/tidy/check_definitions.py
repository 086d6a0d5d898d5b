"""A type's name is defined once in its namespace: two would break the one-definition rule."""
import collections
import pathlib
import re
from typing import List

import tree

# Namespaces and types of a namespace begin in the first column: clang-format sees to it.
NAMESPACE = re.compile(r"namespace(?: ([\w:]+))? \{$")
END = re.compile(r"\}  // namespace\b")
TYPE = re.compile(r"(?:struct|class|union|enum(?: class)?) (\w+)(?: final)?(?: :[^{;]*)?\s*\{")


def types_in(path: pathlib.Path, text: str) -> List[str]:
    """The types that a file defines, with their namespaces. Unnamed namespaces have the path."""
    found, around = [], []
    for line in text.splitlines():
        if match := NAMESPACE.match(line):
            around.append(match[1] or f"<{path}>")
        elif END.match(line) and around:
            around.pop()
        elif match := TYPE.match(line):
            found.append("::".join([*around, match[1]]))
    return found


def check(root: pathlib.Path) -> List[str]:
    where = collections.defaultdict(set)
    for path in tree.files_of(root):
        if path.suffix in tree.CPP:
            for name in types_in(path, tree.read(root, path)):
                if "::" in name:  # Programs have types without a namespace of their own.
                    where[name].add(path.as_posix())
    return [f"{paths[-1]}: {name} is defined in {paths[0]}, too: rename one"
            for name, paths in sorted((name, sorted(paths)) for name, paths in where.items())
            if len(paths) > 1]
