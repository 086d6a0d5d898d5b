"""A generated case: pixels, the program that model.py runs on them, and its text."""
import random

import model

HEAD = "; Written by generate.py; do not edit.\n"
INSIDE = [(x, 63) for x in range(60, 68)]
CORNERS = [(0, 0), (127, 0), (0, 127), (127, 127)]
WATCH = "60..67,63 0,0 127,0 0,127 127,127"
ELSEWHERE = (100, 20)  # Stands for the pixels that are not watched: cleared, enabled with all.


class Instruction:
    """A row with its operands and coefficients; k of CALL and SKIPIFNONE is a label."""

    def __init__(self, row, a=0, b=0, n=0, k=(), label=None):
        self.row, self.a, self.b, self.n, self.k, self.label = row, a, b, n, list(k), label

    def text(self):
        syntax = model.SYNTAX.get(self.row, "").format(a=self.a, b=self.b, n=self.n)
        parts = [self.row, syntax, *map(str, self.k), self.label or ""]
        return " ".join(part for part in parts if part)


class Case:
    """Pixels, a program and what comes of it."""

    def __init__(self, seed, dropped=None):
        self.random, self.dropped = random.Random(seed), dropped
        self.pixels = [model.Pixel(x, y) for x, y in INSIDE + CORNERS + [ELSEWHERE]]
        self.watched = self.pixels[:-1]
        self.columns, self.facts, self.lines = [], [], []
        self.flag, self.signals = True, []

    def give(self, name, values):
        """Adds a column: its value at each watched pixel."""
        self.columns.append((name, values))
        for pixel, value in zip(self.watched, values):
            set_state(pixel, name, value)

    def run(self, *args, **named):
        """Adds an instruction in which pixels take part, and runs it."""
        instruction = Instruction(*args, **named)
        self.note(instruction)
        self.execute(instruction)

    def note(self, instruction):
        self.lines.append("  " + instruction.text())

    def execute(self, o):
        for pixel in self.pixels if o.row != self.dropped else []:
            model.ROWS[o.row](pixel, o, o.k)

    def any_enabled(self):
        return any(pixel.enable for pixel in self.pixels)

    def text(self, title, results):
        before = [dict(zip([name for name, _ in self.columns], row))
                  for row in zip(*[values for _, values in self.columns])]
        changed = [name for name in results
                   if any(state(p, name) != b.get(name, 0) for p, b in zip(self.watched, before))]
        out = HEAD + f"title {title}\nwatch {WATCH}\n"
        names = [name for name, _ in self.columns]
        if names:
            out += table("given", self.watched, names, [[b[n] for n in names] for b in before])
        out += "run\n" + "".join(line + "\n" for line in self.lines)
        if changed:
            out += table("expect", self.watched, changed,
                         [[state(p, name) for name in changed] for p in self.watched])
        if self.signals:
            out += "signals " + " ".join(map(str, self.signals)) + "\n"
        if not self.flag:
            out += "flag 0\n"
        return out + "".join(fact + "\n" for fact in self.facts)


def set_state(pixel, name, value):
    if name.startswith("m"):
        a, n = map(int, name[1:].split(":"))
        pixel.set_field(a, n, value)
    elif name.startswith("bs"):
        pixel.blocks[int(name[2:])] = value
    else:
        setattr(pixel, name, bool(value))


def state(pixel, name):
    if name.startswith("m"):
        a, n = map(int, name[1:].split(":"))
        return pixel.field(a, n)
    if name.startswith("bs"):
        return pixel.blocks.get(int(name[2:]), 0)
    return int(getattr(pixel, name))


def table(section, pixels, names, rows):
    """A section, its columns in line."""
    cells = [[section, *names]]
    for pixel, row in zip(pixels, rows):
        cells.append([f"  {pixel.x},{pixel.y}"] + [number(value) for value in row])
    widths = [max(len(line[i]) for line in cells) for i in range(len(cells[0]))]
    return "".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() + "\n"
                   for line in cells)


def number(value):
    return str(value) if value < 10 else hex(value)
