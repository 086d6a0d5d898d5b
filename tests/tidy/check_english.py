"""Plain English in comments, documents and the product's texts; CONTRIBUTING.md has the rules."""
import pathlib
import re
from typing import List

import tree

MAX_COLUMNS = 100
# Names in code keep their spelling: text in backticks, and code before a comment.
NAMES = re.compile(r"`[^`]*`|@\w+ \{.*?\} (?:\[?\w+)?")
CODE = re.compile(r"^.*?(?=//)")
# Lines that may be longer: tables, drawings, and links that do not break.
LONG = re.compile(r"^\s*\||https?:|^(?: {4}|\t)|\]\(")
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
COMMENT = re.compile(r"^\s*(?:///?<?|\*|/\*\*|#|;)\s|///<|\s//\s")
RULES = {
    r"///<?\s+(Of|As|What|Who|To|That|Those|Else)\s": "begin a doc comment with its subject",
    r"^//\s+(Of|As|What|Who|Those)\s": "begin a comment with its subject",
    r"(?i)\b(nobody|somebody|noone)\b": "name the person or the program",
    r"(?<!\w )(?<!\w, )\b[Ww]ho (has|is|wants|reads|asks|does|needs|looks)\b":
        "name the person or the program",
    r"\b[Tt]ells? (how|what|who|which|whether|why|that)\b": "use print, report or show",
    r"\banew\b": "write 'again'",
}
BRITISH = re.compile(
    r"\b(\w*[Cc]olou?r(?<=our)\w*|[Cc]entr(?:e|es|ed)|\w*[Mm]etres?|[Gg]rey\w*|\w*[Nn]ormalis\w+"
    r"|[Oo]ptimis\w+|[Rr]ecognis\w+|[Ll]abell\w+|[Cc]ancell(?:ed|ing)|[Bb]ehaviour\w*"
    r"|[Nn]eighbour\w*|[Ll]icence[sd]?|[Ii]nitialis\w+|[Ss]ynchronis\w+|[Mm]inimis\w+"
    r"|[Mm]aximis\w+|[Vv]isualis\w+|[Ss]ummaris\w+)\b")
# In code: identifiers, too. `labelledby` and others are names of the web's own.
IDENTIFIER = re.compile(
    r"\w*([Cc]olour|[Cc]entre|(?<![a-z])[Gg]rey|[Nn]eighbour|[Nn]ormalis[ei]|[Oo]ptimis[ei]"
    r"|[Rr]ecognis|[Bb]ehaviour|[Ii]nitialis|[Vv]ectoris|[Mm]inimis[ei]|[Mm]aximis[ei]"
    r"|[Cc]ancell[ei])\w*")


def literals_in(line: str) -> str:
    """The texts of a line of C++ that a person may read: literals with a space and no markup."""
    if line.lstrip().startswith("#"):
        return ""
    return " ".join(m[1] for m in LITERAL.finditer(line) if " " in m[1] and "<" not in m[1])


def errors_in(place: str, text: str, prose: str) -> List[str]:
    """The errors of a line. `prose` is its part whose spelling counts: no code, no names."""
    errors = []
    for pattern, advice in RULES.items():
        for match in re.finditer(pattern, text):
            errors.append(f"{place}: '{match[0].strip()}': {advice}")
    match = BRITISH.search(NAMES.sub("", prose))
    if match:
        errors.append(f"{place}: '{match[0]}': American spelling")
    return errors


def errors_of(path: pathlib.PurePath, text: str) -> List[str]:
    errors = []
    is_document = path.suffix == ".md"
    for number, line in enumerate(text.splitlines(), 1):
        place = f"{path}:{number}"
        if is_document and len(line) > MAX_COLUMNS and not LONG.search(line):
            errors.append(f"{place}: {len(line)} columns, at most {MAX_COLUMNS}")
        if path.suffix in tree.CPP | {".def"} and path.parts[0] != "tests":
            literals = literals_in(line)
            errors += errors_in(place, literals, literals)
        identifier = None if is_document else IDENTIFIER.search(line)
        if identifier:
            errors.append(f"{place}: '{identifier[0]}': American spelling")
        elif is_document or COMMENT.search(line):
            errors += errors_in(place, line, line if is_document else CODE.sub("", line))
    return errors


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for path in tree.files_of(root):
        text = path.suffix in tree.CPP | {".md", ".js", ".def", ".fbs", ".pxasm"}
        is_english = path.parts[:2] != ("tests", "tidy") and not tree.is_translation(path)
        if text and is_english:
            errors += errors_of(path, tree.read(root, path))
    return errors
