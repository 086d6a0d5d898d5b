#!/usr/bin/env python3
"""Writes PROTOCOL.md from the schema files, or checks that it is fresh.

usage: generate_protocol_md.py [--write]     without --write: exit code 1 if the file is stale
"""
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).parent
FILES = ["common", "control", "volume", "surface", "frame", "scene", "export", "activity",
         "counts", "trace"]
REWRITE = "python3 ringbus/generate_protocol_md.py --write"


def declarations(lines):
    """Yields (comment, kind, name, body lines) of every enum, struct and table."""
    comment, i = [], 0
    while i < len(lines):
        line = lines[i]
        match = re.match(r"(enum|struct|table) (\w+)", line)
        if line.startswith("///"):
            comment.append(line[3:].strip())
        elif match:
            body = [line]
            while "}" not in body[-1]:
                i += 1
                body.append(lines[i])
            yield " ".join(comment), match[1], match[2], body
            comment = []
        elif not line.strip():
            comment = []
        i += 1


def fields(body):
    """Yields (name, type, comment) of a struct's or table's fields; a comment may go on below."""
    text = "\n".join(body)
    inner = text[text.index("{") + 1:text.rindex("}")]
    found = []
    for line in inner.splitlines():
        code, _, comment = line.partition("//")
        for name, kind in re.findall(r"(\w+)\s*:\s*([^;]+);", code):
            found.append([name, kind.strip(), comment.strip()])
        if not code.strip() and comment and found:
            found[-1][2] += " " + comment.strip()
    return found


def document():
    out = ["# The protocol of the ring", "",
           f"Generated from `schema/*.fbs`; rewrite with `{REWRITE}`.", "",
           "A message is two ZeroMQ parts: the `Header` struct, and a FlatBuffer whose root is "
           "`Message` with one of the tables below as its body. Both are verified before use, then "
           "ranges are checked (`ranges.cpp`).", ""]
    for name in FILES:
        lines = (HERE / "schema" / f"{name}.fbs").read_text().splitlines()
        head = []
        for line in lines:
            if not line.startswith("//") or line.startswith("///"):
                break
            head.append(line[2:].strip())
        out += [f"## {head[0]}", ""]
        if head[1:]:
            out += ["```"] + head[1:] + ["```", ""]
        for comment, kind, declared, body in declarations(lines):
            out += [f"### {declared} ({kind})", ""]
            if comment:
                out += [comment, ""]
            if kind == "enum":
                values = "\n".join(body)
                names = values[values.index("{") + 1:values.rindex("}")].split()
                out += ["`" + " ".join(names) + "`", ""]
            elif fields(body):
                out += ["| field | type | meaning |", "|---|---|---|"]
                out += [f"| {n} | `{t}` | {c} |" for n, t, c in fields(body)] + [""]
    kinds = (HERE / "schema" / "message.fbs").read_text()
    kinds = kinds[kinds.index("union Body {") + 12:]
    names = [kind.strip() for kind in kinds[:kinds.index("}")].split(",")]
    out += ["## Kinds", "", "| kind | body |", "|---|---|"]
    out += [f"| {number} | {kind} |" for number, kind in enumerate(names, 1)]
    return "\n".join(out) + "\n"


def main():
    path = HERE / "PROTOCOL.md"
    if "--write" in sys.argv[1:]:
        path.write_text(document())
        return 0
    if not path.exists() or path.read_text() != document():
        print(f"ringbus/PROTOCOL.md is stale; rewrite it with: {REWRITE}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
