"""Reads the declarations and comments of a FlatBuffers schema file."""
import pathlib
import re
from typing import List, NamedTuple, Optional


class Value(NamedTuple):
    name: str
    number: int
    comment: str


class Field(NamedTuple):
    name: str
    type: str           # Without default and attributes, for example "[double]".
    attributes: str     # The text in parentheses, or "".
    comment: str
    declared: str       # Type, default and attributes, as the file writes them.


class Declaration(NamedTuple):
    kind: str           # enum, struct, table or union
    name: str
    base: str           # Underlying type of an enum, or "".
    attributes: str     # The text in parentheses, or "".
    comment: str
    values: List[Value]
    fields: List[Field]


class Schema(NamedTuple):
    head: List[str]     # Lines of the comment at the top of the file.
    declarations: List[Declaration]


_HEAD = re.compile(r"^(enum|struct|table|union)\s+(\w+)\s*(?::\s*(\w+))?\s*(?:\((.*?)\))?")


def _values(body: str) -> List[Value]:
    """Values of an enum or a union. A comment behind a value belongs to that value."""
    found: List[Value] = []
    for line in body.splitlines():
        code, _, comment = line.partition("//")
        for name, number in re.findall(r"([A-Za-z_]\w*)\s*(?:=\s*(\d+))?", code):
            after = found[-1].number + 1 if found else 0
            found.append(Value(name, int(number or after), ""))
        if comment.strip() and found:
            last = found[-1]
            found[-1] = last._replace(comment=f"{last.comment} {comment.strip('/ ')}".strip())
    return found


def _fields(body: str) -> List[Field]:
    """Fields of a struct or a table. Comment lines continue the comment of the field above."""
    found: List[Field] = []
    for line in body.splitlines():
        code, _, comment = line.partition("//")
        for name, declared in re.findall(r"(\w+)\s*:\s*([^;]+);", code):
            declared = declared.strip()
            attributes = re.search(r"\((.*)\)", declared)
            kind = re.split(r"[=(]", declared)[0].strip()
            found.append(Field(name, kind, attributes[1] if attributes else "", comment.strip(),
                               declared))
        if not code.strip() and comment.strip() and found:
            last = found[-1]
            found[-1] = last._replace(comment=f"{last.comment} {comment.strip()}".strip())
    return found


def _declaration(match: "re.Match[str]", comment: List[str], body: str) -> Declaration:
    inner = body[body.index("{") + 1:body.rindex("}")]
    has_values = match[1] in ("enum", "union")
    return Declaration(match[1], match[2], match[3] or "", match[4] or "", " ".join(comment),
                       _values(inner) if has_values else [], [] if has_values else _fields(inner))


def parse(text: str) -> Schema:
    lines = text.splitlines()
    head: List[str] = []
    for line in lines:
        if not line.startswith("//") or line.startswith("///"):
            break
        head.append(line[2:].strip())
    declarations, comment, i = [], [], 0
    while i < len(lines):
        match = _HEAD.match(lines[i])
        if lines[i].startswith("///"):
            comment.append(lines[i][3:].strip())
        elif match:
            first = i
            while "}" not in lines[i].partition("//")[0]:
                i += 1
            declarations.append(_declaration(match, comment, "\n".join(lines[first:i + 1])))
            comment = []
        elif not lines[i].strip():
            comment = []
        i += 1
    return Schema(head, declarations)


def read(path: pathlib.Path) -> Schema:
    return parse(path.read_text(encoding="utf-8"))


def find(schema: Schema, name: str) -> Optional[Declaration]:
    return next((d for d in schema.declarations if d.name == name), None)
