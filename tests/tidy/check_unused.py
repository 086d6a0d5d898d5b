"""Every header is included, and every function that a header declares is called."""
import collections
import pathlib
import re
from typing import List

import tree

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)
# A declaration or definition: a type at the beginning of a line, then the function's name. A call
# has no type before it.
DECLARED = re.compile(r"^[ \t]*(?!(?:return|else|throw|delete|new|using|case|co_\w+|goto)\b)"
                      r"(?:[A-Za-z_](?:[\w:<>,*&]*[\w>*&])?[ \t]+)+[*&]?(?:\w+::)*([a-z]\w*)\(",
                      re.M)
WORD = re.compile(r"[A-Za-z_]\w*")
# A library or the compiler calls these by their names.
BY_NAME = {"main", "begin", "end"}


def unused_headers(root: pathlib.Path, files: List[pathlib.Path]) -> List[str]:
    included = set()
    for path in files:
        included.update(INCLUDE.findall(tree.read(root, path)))
    return [f"{path}: no file includes it" for path in files
            if path.suffix == ".hpp" and path.as_posix() not in included]


def unused_functions(root: pathlib.Path, files: List[pathlib.Path]) -> List[str]:
    words, declarations = collections.Counter(), collections.Counter()
    declared_in = {}
    for path in files:
        text = tree.read(root, path)
        code = tree.bare_code(text)
        # bare_code() leaves preprocessor lines out, but a macro calls what it names.
        code += "\n".join(re.findall(r"^#define[^\n]*(?:\\\n[^\n]*)*", text, re.M))
        words.update(WORD.findall(text if path.suffix == ".def" else code))
        for match in DECLARED.finditer(code):
            declarations[match[1]] += 1
            if path.suffix == ".hpp":
                declared_in.setdefault(match[1], path)
    return [f"{path}: {name}() is never called" for name, path in sorted(declared_in.items())
            if words[name] <= declarations[name] and name not in BY_NAME]


def check(root: pathlib.Path) -> List[str]:
    files = [path for path in tree.files_of(root)
             if path.suffix in tree.CPP | {".def", ".in"}]
    return unused_headers(root, files) + unused_functions(root, files)
