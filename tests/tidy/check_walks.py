"""Each function that a page of walks names is in the file that the page names behind it."""
import pathlib
import re
from typing import Iterator, List, Tuple

import tree

PAGES = "WALKTHROUGHS.md"
STEP = re.compile(r"^\d+\. .*(?:\n[ \t]+\S.*)*", re.M)
# `Class::name()`, or the target of a link.
TOKEN = re.compile(r"`((?:\w+::)*~?\w+)\(\)`|\]\(([^)#\s]+)\)")
SOURCE = (".cpp", ".hpp", ".js")
KEYWORDS = r"(?:return|else|throw|delete|new|using|case|co_\w+|goto|await|if|while|for|switch)\b"


def is_defined(text: str, name: str, suffix: str) -> bool:
    """True if `text` defines or declares the function `name`; a call is not enough."""
    *owner, function = name.split("::")
    if suffix == ".js":
        return re.search(rf"^[ \t]*(?:export )?(?:async )?(?:function )?{function}\([^=>]*\) {{$",
                         text, re.M) is not None
    code = tree.bare_code(text)
    before = rf"^[ \t]*(?!{KEYWORDS})(?:[\w:<>,*&\[\]]+[ \t]+)+[*&]?"  # A type, perhaps attributes.
    if not owner:
        return re.search(rf"{before}{function}\(", code, re.M) is not None
    qualified = rf"\b{owner[-1]}(?:<\w+>)?::{function}\("
    if re.search(rf"(?:{before}|^(?:\w+::)*){qualified}", code, re.M):
        return True
    body = re.search(rf"\b(?:class|struct)\s+(?:\w+::)*{owner[-1]}\b[^;{{]*{{", code)
    return body is not None and is_defined(code[body.end():], function, suffix)


def named_functions(step: str) -> Iterator[Tuple[str, str]]:
    """Functions of a step with the file of each: the next link to code, or else the last one."""
    waiting, target = [], ""
    for function, link in TOKEN.findall(step):
        if function:
            waiting.append(function)
        elif link.endswith(SOURCE):
            target = link
            yield from ((name, target) for name in waiting)
            waiting = []
    yield from ((name, target) for name in waiting)


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for page in (path for path in tree.files_of(root) if path.name == PAGES):
        text = tree.read(root, page)
        for step in STEP.finditer(text):
            place = f"{page}:{text.count(chr(10), 0, step.start()) + 1}"
            names = list(named_functions(step[0]))
            if not names:
                errors.append(f"{place}: the step names no function")
            for name, target in names:
                path = root / page.parent / target
                if not target or not path.is_file():
                    errors.append(f"{place}: {name}() has no file behind it")
                elif not is_defined(path.read_text(encoding="utf-8"), name, path.suffix):
                    errors.append(f"{place}: {name}() is not in {target}")
    return errors
