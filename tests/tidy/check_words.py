"""Words that have no place in the tree: unfinished work, sleeps, flags that change results, and
calls of the page that take a text for HTML or a program."""
import pathlib
import re
from typing import List

import tree

# Everywhere but here, where they are spelled out.
HERE = ("tests", "tidy")
PAGE = ("host", "serve", "page")

ANYWHERE = {
    r"\b(TODO|FIXME|XXX)\b": "unfinished work belongs in an issue",
    r"(?i)\b(stub(s|bed)?|placeholders?)\b": "nothing stands in for something else",
    r"(?<![\w.])/w[o]rk/": "a path of one machine",
}
IN_CODE = {
    r"\b(sleep_for|sleep_until|usleep|nanosleep)\b|(?<![\w.])sleep\s*\(": "wait for an event",
    r"-ffast-math|-march=native|-ffp-contract=(fast|on)": "changes results between machines",
    r"\b(MulAdd|NegMulAdd|MulSub|std::fma|fmaf?)\s*\(": "fuses a multiply and an add",
    r"\b__builtin_ia32_vfm": "fuses a multiply and an add",
}
IN_SCRIPTS = {r"\btime\.sleep\b|^\s*sleep\s": "wait for an event"}
# Names of files, patients and surfaces come from strangers.
IN_PAGE = {
    r"\b(innerHTML|outerHTML|insertAdjacentHTML|setHTMLUnsafe|parseHTMLUnsafe|srcdoc|"
    r"createContextualFragment|document\.write(ln)?)\b": "makes elements of a text; use dom.js",
    r"(?<![\w.])(eval|(new\s+)?Function)\s*\(": "runs a text as a program",
}


def _rules_for(path: pathlib.PurePath) -> dict:
    rules = dict(ANYWHERE)
    if path.suffix in tree.CPP | {".def"} or path.name == "CMakeLists.txt":
        rules.update(IN_CODE)
    if path.suffix in {".py", ".sh"}:
        rules.update(IN_SCRIPTS)
    if path.parts[:3] == PAGE and path.suffix in {".js", ".html"}:
        rules.update(IN_PAGE)
    return rules


def errors_of(path: pathlib.PurePath, text: str) -> List[str]:
    errors = []
    for pattern, reason in _rules_for(path).items():
        for match in re.finditer(pattern, text, re.M):
            number = text.count("\n", 0, match.start()) + 1
            errors.append(f"{path}:{number}: '{match[0].strip()}': {reason}")
    return errors


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for path in tree.files_of(root):
        is_text = tree.is_code(path) or path.suffix in {".md", ".json", ".txt", ".html"}
        if path.parts[:2] != HERE and is_text:
            errors += errors_of(path, tree.read(root, path))
    return errors
