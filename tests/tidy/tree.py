"""The files of the repository, and C++ text without what is not code."""
import pathlib
import re
import subprocess
from typing import List

CODE = {".hpp", ".cpp", ".h", ".def", ".fbs", ".py", ".sh", ".cmake", ".js", ".css"}
CPP = {".hpp", ".cpp", ".h"}


def files_of(root: pathlib.Path) -> List[pathlib.Path]:
    """Tracked files and new ones that are not ignored, as paths below root. Without git: all."""
    try:
        listing = subprocess.run(
            ["git", "-C", str(root), "ls-files", "-co", "--exclude-standard", "-z"],
            check=True, capture_output=True, text=True).stdout.split("\0")
        names = [name for name in listing if name]
    except (OSError, subprocess.CalledProcessError):
        names = [str(p.relative_to(root)) for p in root.rglob("*") if p.is_file()]
    return sorted({pathlib.Path(n) for n in names if (root / n).is_file()})


def is_code(path: pathlib.Path) -> bool:
    return path.suffix in CODE or path.name == "CMakeLists.txt"


def is_table(path: pathlib.Path) -> bool:
    """Pure tables are exempt from lengths: rows of instructions, of fields, of cases."""
    return path.suffix in {".def", ".fbs"} or bool(re.search(r"_tables?\.[ch]pp$", path.name))


def is_translation(path: pathlib.Path) -> bool:
    """The page's texts in another language: one text a line, however long."""
    return path.parts[:4] == ("host", "serve", "page", "texts") and len(path.parts) > 5


def read(root: pathlib.Path, path: pathlib.Path) -> str:
    return (root / path).read_text(encoding="utf-8", errors="replace")


_NOT_CODE = re.compile(
    r'R"(?P<mark>[^()\\ ]{0,16})\(.*?\)(?P=mark)"'  # raw string
    r'|//(?:[^\n\\]|\\.|\\\n)*'                     # line comment
    r'|/\*.*?\*/'                                   # block comment
    r'|"(?:[^"\\\n]|\\.)*"'                         # string
    r"|(?<![0-9A-Fa-f])'(?:[^'\\\n]|\\.)+'"         # character; not 1'000
    r'|^[ \t]*#(?:[^\n\\]|\\.|\\\n)*',              # preprocessor line
    re.S | re.M)


def bare_code(text: str) -> str:
    """C++ `text`, comments, literals and preprocessor lines blanked; lines stay in place."""
    return _NOT_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
