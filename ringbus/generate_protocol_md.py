#!/usr/bin/env python3
"""Writes PROTOCOL.md from the schema files, or checks that the file is up to date.

usage: generate_protocol_md.py [--write]     without --write: exit code 1 if the file is stale
"""
import pathlib
import re
import sys
import textwrap

import fbs_text
import vocabulary

HERE = pathlib.Path(__file__).parent
FILES = ["common", "control", "volume", "surface", "frame", "scene", "export", "activity",
         "counts", "trace", "vocabulary"]
REWRITE = "python3 ringbus/generate_protocol_md.py --write"


def paragraph(text):
    return textwrap.wrap(text, 100, break_on_hyphens=False) + [""]


def section(schema):
    out = [f"## {schema.head[0]}", ""]
    if schema.head[1:]:
        out += ["```"] + schema.head[1:] + ["```", ""]
    for declared in schema.declarations:
        out += [f"### {declared.name} ({declared.kind})", ""]
        if declared.comment:
            out += paragraph(declared.comment)
        if any(value.comment for value in declared.values):
            out += ["| value | meaning |", "|---|---|"]
            out += [f"| `{v.name}` | {v.comment} |" for v in declared.values] + [""]
        elif declared.values:
            out += paragraph(", ".join(f"`{value.name}`" for value in declared.values))
        elif declared.fields:
            out += ["| field | type | meaning |", "|---|---|---|"]
            out += [f"| `{f.name}` | `{f.declared}` | {f.comment} |" for f in declared.fields]
            out += [""]
    return out


def rules():
    """The rows of senders.def by kind: "host to gp; io to host"."""
    text = (HERE / "senders.def").read_text()
    found = {}
    row = re.compile(r"^MAY_SEND\((\w+), ([\w |]+), ([\w |]+)\)$", re.M)
    for kind, senders, receivers in row.findall(text):
        rule = " to ".join(roles.replace(" | ", ", ") for roles in (senders, receivers))
        found[kind] = f"{found[kind]}; {rule}" if kind in found else rule
    return found


def document():
    out = ["# The protocol of the ring", "",
           *paragraph("Generated from `schema/*.fbs` and `limits.def`; rewrite with "
                      f"`{REWRITE}`."),
           *paragraph("A message has two ZeroMQ parts. The first is the `Header` struct. The "
                      "second is a FlatBuffer whose root is `Message` with one of the tables below "
                      "as its body. The receiver verifies both parts, then checks ranges "
                      "(`ranges.cpp`).")]
    for name in FILES:
        out += section(fbs_text.read(HERE / "schema" / f"{name}.fbs"))
    out += ["## Limits", "", "| name | value | meaning |", "|---|---|---|"]
    out += [f"| `{limit.name}` | {limit.value} | {limit.comment} |"
            for limit in vocabulary.limits()]
    kinds = fbs_text.find(fbs_text.read(HERE / "schema" / "message.fbs"), "Body").values
    out += ["", "## Kinds and lawful senders", "",
            *paragraph("The rules of `senders.def`. A node is a GP, a Renderer or a frame buffer; "
                       "a child is a node or an io process. A receiver drops all other messages."),
            "| kind | body | sender to receiver |", "|---|---|---|"]
    lawful = rules()
    out += [f"| {number} | {kind.name} | {lawful[kind.name]} |"
            for number, kind in enumerate(kinds, 1)]
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
