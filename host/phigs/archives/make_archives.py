#!/usr/bin/env python3
"""Writes the three archives of this folder: molecule, room and tree.

usage: make_archives.py [FOLDER]
"""
import math
import pathlib
import sys

NUMBER = "{:.4f}"


def numbers(values):
    """Short decimals, without the minus sign of zero."""
    return " ".join(NUMBER.format(v + 0.0).rstrip("0").rstrip(".").replace("-0", "0", 1)
                    if abs(v) < 5e-5 else NUMBER.format(v).rstrip("0").rstrip(".") for v in values)


def color(kind, rgb, spec=(255, 255, 255, 30), back=None):
    """One color block: front and back, diffuse and specular."""
    front, behind = numbers(rgb), numbers(back or rgb)
    gloss = numbers(spec)
    return (f"  color {kind} {{ diff {front} 255  {behind} 255   "
            f"spec {gloss}  {gloss} }};")


def structure(name, lines, posted=False):
    """A structure's text."""
    head = f"structure {name} posted {{" if posted else f"structure {name} {{"
    return "\n".join([head, *lines, "};", ""])


def polygon(corners, normals=None):
    """A polygon; with normals, one for each corner."""
    rows = [numbers(c) + ("" if normals is None else "  " + numbers(normals[i])) + ";"
            for i, c in enumerate(corners)]
    return f"  polygon {len(corners)} {{ " + " ".join(rows) + " };"


# --- molecule: caffeine ----------------------------------------------------------------------

ELEMENTS = {  # color; van der Waals radius in angstrom (Bondi 1964), drawn at RADIUS_SCALE
    "C": ((92, 96, 104), 1.70),
    "N": ((62, 98, 232), 1.55),
    "O": ((226, 48, 40), 1.52),
    "H": ((236, 238, 240), 1.20),
}
RADIUS_SCALE = 0.72


def ring(start, other, count):
    """A regular polygon counter-clockwise on the edge start -> other: all its corners."""
    corners, p, step = [start], start, other - start
    for _ in range(count - 1):
        p += step
        corners.append(p)
        step *= complex(math.cos(math.tau / count), math.sin(math.tau / count))
    return corners


def caffeine():
    """Element and place in angstrom: regular rings, usual bond lengths, tetrahedral methyls."""
    bond = 1.39
    c4, c5 = complex(0, -bond / 2), complex(0, bond / 2)
    _, _, c6, n1, c2, n3 = ring(c4, c5, 6)       # Six-ring, to the left of c4 -> c5.
    _, _, n9, c8, n7 = ring(c5, c4, 5)           # Five-ring, to the right.
    six = sum((c4, c5, c6, n1, c2, n3)) / 6
    five = sum((c5, c4, n9, c8, n7)) / 5

    def outward(p, center, length):
        return p + (p - center) / abs(p - center) * length

    atoms = [("C", p) for p in (c2, c4, c5, c6, c8)] + [("N", p) for p in (n1, n3, n7, n9)]
    atoms += [("O", outward(c6, six, 1.22)), ("O", outward(c2, six, 1.22)),
              ("H", outward(c8, five, 1.08))]
    result = [(e, (p.real, p.imag, 0.0)) for e, p in atoms]
    for n, center in ((n1, six), (n3, six), (n7, five)):
        carbon = outward(n, center, 1.46)
        axis = (carbon - n) / abs(carbon - n)
        result.append(("C", (carbon.real, carbon.imag, 0.0)))
        for k in range(3):                       # 109.5 degrees from the bond, 120 apart.
            turn = math.tau * k / 3 + math.pi / 2
            along, off = 1.09 * math.cos(math.radians(70.5)), 1.09 * math.sin(math.radians(70.5))
            side = axis * complex(0, 1) * off * math.cos(turn)
            p = carbon + axis * along + side
            result.append(("H", (p.real, p.imag, off * math.sin(turn))))
    return result


def molecule():
    lines = []
    atoms = caffeine()
    for element, (rgb, radius) in ELEMENTS.items():
        lines.append(color("sphere", rgb, (255, 255, 255, 40)))
        lines += [f"  sphere {numbers(place)} {numbers([radius * RADIUS_SCALE])};"
                  for e, place in atoms if e == element]
    return ("/* Caffeine, C8H10N4O2, in angstrom: idealised rings, usual bond lengths. */\n"
            + structure("caffeine", lines, posted=True))


# --- room ------------------------------------------------------------------------------------

def box(low, high, skip=""):
    """The faces of a box, counter-clockwise from outside; skip names sides to leave out."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    faces = {
        "l": ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
        "r": ((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
        "d": ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
        "u": ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
        "b": ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
        "f": ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
    }
    return [polygon(corners) for side, corners in faces.items() if side not in skip]


def execute(name, *matrices):
    """A structure of one's own around an execute, so that the matrices end with it."""
    return structure("place_" + name[0], [f"  matrix Pre {m};" for m in matrices]
                     + [f"  execute {name[1]};"])


def floor_tiles(size, count):
    """A chequered floor, one block of color for each of two colors."""
    lines, step = [], size / count
    for color, odd in (((206, 190, 160), 0), ((150, 120, 90), 1)):
        lines.append(color("polygon", color, (60, 60, 60, 20)))
        for i in range(count):
            for k in range(count):
                if (i + k) % 2 == odd:
                    x, z = i * step, k * step
                    lines.append(polygon(((x, 0, z), (x, 0, z + step), (x + step, 0, z + step),
                                          (x + step, 0, z))))
    return lines


def culled(corners, rgb):
    """A polygon5 that shows its front only, so that one looks into the room through its walls."""
    return (f"  polygon5 {len(corners)} 131 diff {numbers(rgb)} 255 {{ "
            + " ".join(numbers(c) + ";" for c in corners) + " };")


def walls():
    w, h, wall, side = 4, 2.6, (196, 206, 214), (180, 192, 204)
    lines = ["  /* The back wall is concave: a window is cut out of its upper edge. */",
             culled(((0, 0, 0), (w, 0, 0), (w, h, 0), (2.9, h, 0), (2.9, 1.1, 0), (1.5, 1.1, 0),
                     (1.5, h, 0), (0, h, 0)), wall),
             culled(((0, 0, w), (0, 0, 0), (0, h, 0), (0, h, w)), side),
             culled(((w, 0, 0), (w, 0, w), (w, h, w), (w, h, 0)), side),
             color("polygon", (240, 240, 236)), *box((1.5, 1.06, -0.08), (2.9, 1.1, 0.16)),
             *box((2.17, 1.1, -0.04), (2.23, 2.6, 0.0)), *box((1.5, 1.82, -0.04), (2.9, 1.86, 0.0)),
             color("polygon", (126, 176, 226), (0, 0, 0, 1)),
             culled(((1.5, 1.1, -0.3), (2.9, 1.1, -0.3), (2.9, 2.6, -0.3), (1.5, 2.6, -0.3)),
                    (126, 176, 226))]
    return lines


def chair():
    lines = [color("polygon", (176, 92, 60), (90, 90, 90, 20))]
    lines += box((-0.22, 0.42, -0.22), (0.22, 0.47, 0.22))
    lines += box((-0.22, 0.47, -0.22), (0.22, 0.95, -0.18))
    for x in (-0.2, 0.16):
        for z in (-0.2, 0.16):
            lines += box((x, 0, z), (x + 0.04, 0.42, z + 0.04), "u")
    return lines


def table():
    lines = [color("polygon", (150, 96, 52), (120, 120, 120, 24))]
    lines += box((-0.7, 0.7, -0.45), (0.7, 0.75, 0.45))
    for x in (-0.64, 0.58):
        for z in (-0.4, 0.34):
            lines += box((x, 0, z), (x + 0.06, 0.7, z + 0.06), "u")
    lines += [color("sphere", (210, 40, 44)), "  sphere -0.25 0.83 0.1 0.08;",
              color("sphere", (236, 150, 40)), "  sphere -0.1 0.82 0.16 0.07;",
              color("sphere", (120, 176, 60)), "  sphere -0.14 0.83 0.02 0.08;"]
    return lines


def shelf():
    lines = [color("polygon", (120, 78, 46), (60, 60, 60, 16))]
    for y in (0, 0.5, 1.0, 1.5):
        lines += box((0, y, 0), (0.3, y + 0.04, 1.2))
    lines += box((0, 0, -0.04), (0.3, 1.54, 0)) + box((0, 0, 1.2), (0.3, 1.54, 1.24))
    books = ((178, 52, 48), (52, 92, 150), (60, 124, 84), (206, 166, 70), (110, 70, 130))
    for shelf_at in (0, 1, 2):
        z = 0.04
        for k in range(9):
            width = 0.06 + 0.02 * ((k * 7 + shelf_at * 3) % 4)
            height = 0.3 + 0.04 * ((k * 5 + shelf_at) % 4)
            low = 0.04 + 0.5 * shelf_at
            lines.append(color("polygon", books[(k * 3 + shelf_at) % 5], (40, 40, 40, 10)))
            lines += box((0.02, low, z), (0.24, low + height, z + width), "dl")
            z += width + 0.005
    return lines


def lamp():
    return [color("line", (60, 60, 66)), "  line 2 { 0 0.3 0; 0 0 0; };",
            color("sphere", (255, 240, 190), (255, 255, 255, 60)), "  sphere 0 -0.12 0 0.14;"]


def picture():
    return [color("polygon", (58, 60, 78)), *box((-0.5, -0.35, 0), (0.5, 0.35, 0.02), "b"),
            color("line", (240, 214, 120)),
            "  line 5 { -0.4 -0.25 0.03; 0.4 -0.25 0.03; 0.4 0.25 0.03; -0.4 0.25 0.03; "
            "-0.4 -0.25 0.03; };",
            "  line 6 { -0.3 -0.15 0.03; -0.12 0.12 0.03; -0.02 -0.05 0.03; 0.1 0.15 0.03; "
            "0.2 -0.1 0.03; 0.32 0.05 0.03; };"]


PLACES = (("table", "table", "translate 2.1 0 1.9"),
          ("chair_1", "chair", "translate 1.5 0 1.2", "rotate y 10"),
          ("chair_2", "chair", "translate 2.6 0 1.15", "rotate y -6"),
          ("chair_3", "chair", "translate 2.2 0 2.75", "rotate y 172"),
          ("shelf", "shelf", "translate 0.02 0 0.7"),
          ("lamp", "lamp", "translate 2.1 2.3 1.9"),
          ("picture", "picture", "translate 0.75 1.8 0.01"))


def room():
    parts = {"floor": floor_tiles(4, 8), "walls": walls(), "table": table(), "chair": chair(),
             "shelf": shelf(), "lamp": lamp(), "picture": picture()}
    text = "/* A room in meters; walls are seen from inside only (polygon5, flags 131). */\n"
    text += "".join(structure(name, lines) for name, lines in parts.items())
    text += "".join(execute(place[:2], *place[2:]) for place in PLACES)
    names = ["floor", "walls"] + ["place_" + place[0] for place in PLACES]
    return text + structure("room", [f"  execute {name};" for name in names], posted=True)


# --- tree ------------------------------------------------------------------------------------

DEPTH = 6
TAPER = 0.7


def branch_polygons(sides=8, low=0.09, high=0.065):
    """A cone's stump from y 0 to 1, with smooth normals."""
    rows, slope = [], (low - high) / 1.0
    for k in range(sides):
        a, b = math.tau * k / sides, math.tau * (k + 1) / sides
        corners, normals = [], []
        for angle, radius, y in ((b, low, 0), (a, low, 0), (a, high, 1), (b, high, 1)):
            corners.append((radius * math.cos(angle), y, radius * math.sin(angle)))
            normals.append((math.cos(angle), slope, math.sin(angle)))
        rows.append(polygon(corners, normals))
    return rows


def tree():
    text = "/* A tree of nested structures: each branch executes three smaller ones. */\n"
    text += structure("wood", [color("polygon", (124, 84, 54), (40, 40, 40, 8)),
                               color("sphere", (124, 84, 54), (40, 40, 40, 8)),
                               *branch_polygons(), "  sphere 0 1 0 0.066;"])
    text += structure("leaf", [color("sphere", (92, 168, 64), (50, 70, 40, 8)),
                               "  sphere 0 0.35 0 0.55;"])
    text += structure("young_leaf", [color("sphere", (150, 198, 76), (50, 70, 40, 8)),
                                     "  sphere 0 0.3 0 0.42;"])
    for level in range(DEPTH, 0, -1):
        lines = ["  execute wood;"]
        for k in range(3):
            if level < DEPTH:
                child = f"branch_{level + 1}"
            else:
                child = "young_leaf" if k == 0 else "leaf"
            name = f"fork_{level}_{k}"
            matrices = ["translate 0 1 0", f"rotate y {120 * k + 40 * level + 25}",
                        f"rotate z {30 + 5 * ((level + k) % 3)}",
                        f"scale {TAPER} {TAPER} {TAPER}"]
            text += structure(name, [f"  matrix Pre {m};" for m in matrices]
                              + [f"  execute {child};"])
            lines.append(f"  execute {name};")
        text += structure(f"branch_{level}", lines)
    ground = [(2.1 * math.cos(math.tau * k / 24), 0, -2.1 * math.sin(math.tau * k / 24))
              for k in range(24)]
    text += structure("tree", [color("polygon", (108, 132, 74), (20, 20, 20, 4)), polygon(ground),
                               "  execute branch_1;"], posted=True)
    return text


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    for name, text in (("molecule", molecule()), ("room", room()), ("tree", tree())):
        (folder / f"{name}.phigs").write_text(text)


main()
