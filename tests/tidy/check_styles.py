"""Style sheets of the page use the colors, sizes of letters, distances and corners of tokens.css,
and canvases its letters."""
import pathlib
import re
from typing import Iterator, List, Tuple

import tree

PAGE = pathlib.PurePath("host/serve/page")
TOKENS = {PAGE / "tokens.css", PAGE / "light.css"}  # Names for colors and sizes.
CANVAS = PAGE / "elements" / "canvas.js"
HEADSET = PAGE / "headset"  # Its letters are parts of a room, with sizes of their own.

_DECLARATION = re.compile(r"(?<![\w-])([\w-]+)\s*:\s*([^;{}]+)(?=[;}])")
_COLOR = re.compile(r"#[0-9a-fA-F]{3,8}\b|\b(?:rgb|hsl|hwb|lab|lch|oklab|oklch)a?\(|"
                    r"(?<![\w-])(?:white|black|red|green|blue|gray|silver|yellow)(?![\w-])")
_SPACE = re.compile(r"(?:0|auto|var\(--space-\w+\)|calc\(-1 \* var\(--space-\w+\)\))"
                    r"(?: !important)?")
_SPACED = re.compile(r"(?:padding|margin)(?:-\w+)*|(?:row-|column-)?gap")
_SIZE = re.compile(r"inherit|(?:\d00 )?var\(--type-\w+\)(?:/[\d.]+)? ?(?:var\(--(?:font|mono)\))?")
_RADIUS = re.compile(r"0|var\(--radius(?:-\w+)?\)|inherit")
_LETTERS = re.compile(r"[\d}]px (?:system-ui|sans-serif)")


def declarations_of(text: str) -> Iterator[Tuple[int, str, str]]:
    """Line, property and value of each declaration of CSS `text`."""
    bare = re.sub(r"/\*.*?\*/", lambda match: re.sub(r"[^\n]", " ", match[0]), text, flags=re.S)
    for block in re.finditer(r"\{([^{}]*)\}", bare):
        for match in _DECLARATION.finditer(block[1] + ";"):
            line = bare.count("\n", 0, block.start(1) + match.start()) + 1
            yield line, match[1], " ".join(match[2].split())


def _parts(value: str) -> List[str]:
    """The parts of a value that spaces divide, but for those in brackets."""
    return re.findall(r"(?:[^\s()]+(?:\((?:[^()]|\([^()]*\))*\))?|\([^()]*\))", value)


def fault_of(name: str, value: str) -> str:
    """What is wrong with a declaration outside of tokens.css; '' if nothing."""
    if _COLOR.search(value):
        return "a color that tokens.css does not name"
    if name in {"font", "font-size"} and not _SIZE.fullmatch(value):
        return "a size of letters other than var(--type-*)"
    if _SPACED.fullmatch(name) and not all(_SPACE.fullmatch(part) for part in _parts(value)
                                           if part != "!important"):
        return "a distance other than var(--space-*)"
    if name == "border-radius" and not _RADIUS.fullmatch(value):
        return "a corner other than var(--radius*)"
    return ""


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for path in tree.files_of(root):
        if PAGE not in path.parents:
            continue
        text = tree.read(root, path)
        if path.suffix == ".css" and path not in TOKENS:
            errors += [f"{path}:{line}: {name}: {value}: {fault}"
                       for line, name, value in declarations_of(text)
                       if (fault := fault_of(name, value))]
        if path.suffix == ".js" and path != CANVAS and HEADSET not in path.parents:
            errors += [f"{path}:{number}: a font with a size of its own; use letterFont()"
                       for number, line in enumerate(text.splitlines(), 1)
                       if _LETTERS.search(line)]
    return errors
