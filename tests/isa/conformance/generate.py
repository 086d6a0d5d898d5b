"""Writes the generated conformance cases: python3 generate.py FOLDER | --check | --record.

The cases run each row of the instruction set, at each class of width, on no, some and all pixels,
inside the region and at its edges. model.py computes the expected values. The build writes the
cases to FOLDER. --check compares their digest with generated.sha256; --record writes that file.
"""
import hashlib
import pathlib
import sys

import model
from case import CORNERS, INSIDE, Case, Instruction

RECORDED = pathlib.Path(__file__).resolve().parent / "generated.sha256"

WIDTHS = [(1, 1), (2, 8), (9, 16), (17, 32), (33, 64)]  # Both ends of each class.

MEM_MEM = ("MEMintoMEM MEMandeqMEM MEMoreqMEM MEMxoreqMEM MEMltMEM MEMltMEMsigned MEMeqMEM "
           "MEMpluseqMEM MEMminuseqMEM MEMsatpluseqMEM MEMsatminuseqMEM MULMEM MULMEMsigned "
           "MULCONST DIVMEM").split()
DOUBLE = {"MULMEM", "MULMEMsigned", "MULCONST"}
CONSTANT = ("CONSTintoMEM MEMeqCONST MEMgeCONST MEMltCONST MEMgeCONSTsigned MEMltCONSTsigned "
            "MEMpluseqCONST MULCONST").split()
ONE_FIELD = "IMMintoMEM CLEARMEM NOTMEM NEGMEM ABSMEM SQRTMEM PIXELSTOFB".split()
TREES = [row for row in model.ROWS if "TREE" in row or "QUAD" in row]
N_MAX = {**{row: 32 for row in DOUBLE | {"DIVMEM", "SQRTMEM", "PIXELSTOFB"}},
         "TREEclampintoMEM": 63, "QUADclampintoMEM": 63}
ENABLE_ROWS = ("SETENABS CLRENABS INVENABS ENABintoMEM MEMintoENAB ENABandeqMEM ENABandeqNOTMEM "
               "ENABoreqMEM ENABandeqCARRY ANYENAB").split()


def operand(rng, n):
    """A number of n bits, often an extreme one."""
    top, any_value = 1 << n, rng.getrandbits(n)
    return rng.choice([0, 1, top - 1, top >> 1, (top >> 1) - 1, any_value, any_value,
                       any_value >> rng.randrange(n)]) % top


def near(rng, value, n):
    """value, its neighbors, or any number, in n bits."""
    return rng.choice([value, value, value - 1, value + 1, operand(rng, n)]) % (1 << n)


def constant(rng, n):
    k = rng.choice([0, -1, 1, -2**31, 2**31 - 1, rng.randrange(-2**31, 2**31),
                    1 << min(n, 31) - 1, -(1 << min(n, 32) - 1)])
    return max(-2**31, min(k, 2**31 - 1))


def plane(rng, count, bits):
    """Coefficients of a tree that is near 0 at one of the watched pixels, and needs about `bits`
    bits at the others."""
    x, y = rng.choice(INSIDE + CORNERS)
    slope = 1 << max(0, min(bits - 7, 30))
    k = [rng.randrange(-slope, slope + 1) for _ in range(2)] + [0]
    bend = 1 << max(0, min(bits - 14, 24))
    k += [rng.randrange(-bend, bend + 1) for _ in range(count - 3)]
    k[2] = rng.randrange(-3, 4) - model.tree(model.Pixel(x, y), k)
    k[2] = max(-2**31, min(k[2], 2**31 - 1))
    return k


def coefficients(rng, row, n, b):
    if row in TREES:
        return plane(rng, 6 if "QUAD" in row else 3, n + b)
    return [constant(rng, n)] if row in CONSTANT else []


def fields(row, n, at_end):
    """Addresses a and b, and two bits that neither holds, for masks of pixels."""
    bits_a = 2 * n if row in DOUBLE else n
    if at_end:
        return model.MEMORY_BITS - bits_a, 5, 1, 2
    return 0, bits_a + 3, 206, 207


def mask(rng, at_edge):
    """Which watched pixels take part: some inside; with at_edge corners too."""
    inside = [int(rng.random() < 0.8) for _ in INSIDE]
    inside[rng.randrange(len(inside))] = 0
    inside[inside.index(0) - 1] = 1
    corners = [int(at_edge and rng.random() < 0.7) for _ in CORNERS]
    corners[rng.randrange(len(corners))] = int(at_edge)
    return inside + corners


def give_operands(case, row, o, k):
    """Fields m[a] and m[b], with values that lie at this row's limits."""
    rng, n = case.random, o.n
    if "ZERO" in row:
        return
    bits_a = 2 * n if row in DOUBLE else n
    first = []
    for pixel in case.watched:
        if row in TREES:
            first.append(near(rng, model.tree(pixel, k) >> o.b, n))
        elif row in CONSTANT:
            first.append(near(rng, k[0], n))
        else:
            first.append(operand(rng, n))
    junk = [rng.getrandbits(n) << n if row in DOUBLE else 0 for _ in first]
    case.give(f"m{o.a}:{bits_a}", [p | j for p, j in zip(first, junk)])
    if row in MEM_MEM:
        case.give(f"m{o.b}:{n}", [rng.choice([p, operand(rng, n), operand(rng, n)]) for p in first])


def telling_width_case(row, n, at_end):
    """The first that a row which does nothing would fail; of one bit there may be none."""
    for attempt in range(50):
        name, text = width_case(row, n, at_end, attempt)
        if text != width_case(row, n, at_end, attempt, dropped=row)[1]:
            return name, text
    return width_case(row, n, at_end, 0)


def width_case(row, n, at_end, attempt, dropped=None):
    """On no pixel, then on some inside; or on some at the edges too, then on all."""
    case = Case(f"{row} {n} {at_end} {attempt}", dropped)
    rng = case.random
    a, b, save, some = fields(row, n, at_end)
    if row in TREES and "ZERO" not in row:
        b = rng.choice([0, 1, 8, 16, 63]) if at_end else rng.choice([0, 3])
    elif row == "IMMintoMEM":
        b = rng.choice([0, 255, rng.randrange(256)])
    elif row not in MEM_MEM:
        b = 0
    o = Instruction(row, a, b, n)
    k = coefficients(rng, row, n, b)
    give_operands(case, row, o, k)
    if at_end:
        case.give("enable", mask(rng, True))
        case.run(row, a, b, n, k)
        case.run("ENABintoMEM", save)
        case.run("SETENABS")
    else:
        case.give(f"m{some}:1", mask(rng, False))
        case.run(row, a, b, n, k)
        case.run("ENABoreqMEM", some)
    case.run(row, a, b, n, coefficients(rng, row, n, b) if at_end else k)
    bits_a = 2 * n if row in DOUBLE else n
    results = ["enable", "carry"] + ["readout"] * (row == "PIXELSTOFB")
    results += [f"m{a}:{bits_a}"] * ("ZERO" not in row) + [f"m{save}:1"] * at_end
    states = "some_then_all" if at_end else "none_then_inside"
    title = f"{row} of {n} bits on {states.replace('_', ' ')} pixels"
    return f"{row}_n{n}_{states}", case.text(title, results)


# Rows without a width: the four states of the enables one after the other.

def in_four_states(case, action):
    """Calls action(i) with no pixel enabled, with some inside, with some at the edges, with all."""
    for i, way in enumerate(["CLRENABS", "MEMintoENAB", "MEMintoENAB", "SETENABS"]):
        case.run(way, *([200 + i] if way == "MEMintoENAB" else []))
        action(i)


def give_masks(case):
    case.give("m201:1", mask(case.random, False))
    case.give("m202:1", mask(case.random, True))


def enable_case(row, a):
    case = Case(f"{row} {a}")
    count = len(case.watched)
    give_masks(case)
    case.give(f"m{a}:1", [case.random.getrandbits(1) for _ in range(count)])
    case.give("carry", [case.random.getrandbits(1) for _ in range(count)])

    def action(i):
        if row == "ANYENAB":
            any_enabled(case, i)
        else:
            case.run(row, *([a] if row in model.SYNTAX else []))
        case.run("ENABintoMEM", 100 + i)
        if row == "ENABintoMEM":
            case.run("MEMintoMEM", 110 + i, a, 1)

    in_four_states(case, action)
    results = ["enable", f"m{a}:1", "m100:4", "m110:4"]
    return f"{row}_m{a}", case.text(f"{row} on none, some and all pixels, by m{a}", results)


def any_enabled(case, i):
    """The flag decides whether a SIGNAL is skipped."""
    case.lines += ["  ANYENAB", f"  SKIPIFNONE after{i}", f"  SIGNAL #{10 + i}",
                   f"  after{i}:"]
    case.flag = case.any_enabled()
    case.signals += [10 + i] * case.flag


def backing_case(row, reverse):
    case = Case(f"{row} {reverse}")
    rng, count = case.random, len(case.watched)
    give_masks(case)
    places = list(zip([0, 33, 71, 168], [0, 1, 64, 127]))
    if reverse:
        places = list(zip([103, 5, 136, 40], [127, 126, 2, 63]))
    for a, block in places:
        case.give(f"m{a}:32", [rng.getrandbits(32) for _ in range(count)])
        case.give(f"bs{block}", [operand(rng, 32) for _ in range(count)])

    def action(i):
        a, block = places[i]
        case.run(row, a, block)
        case.lines.append("  BSWAIT")

    in_four_states(case, action)
    results = ["enable"] + [name for a, block in places for name in (f"m{a}:32", f"bs{block}")]
    blocks = "_".join(str(block) for _, block in places)
    return f"{row}_blocks_{blocks}", case.text(f"{row} of blocks {blocks.replace('_', ' ')} on "
                                               "none, some and all pixels", results)


def counted(case, i, times):
    """Runs the counting instruction so often, which the text does by other means."""
    for _ in range(times):
        case.execute(Instruction("MEMpluseqCONST", 8 * i, 0, 8, [1]))


def control_case(row):
    case = Case(row)
    give_masks(case)
    add = "  MEMpluseqCONST m{}:8 1"

    def action(i):
        if row == "LOOP":
            case.lines += [f"  LOOP #{2 + 3 * i}", add.format(8 * i), "  ENDLOOP"]
            counted(case, i, 2 + 3 * i)
        elif row == "CALL":
            case.lines += [f"  CALL add{i}"] * 2
            counted(case, i, 2)
        elif row == "SKIPIFNONE":
            any_enabled(case, i)
        elif row == "SIGNAL":
            case.lines.append(f"  SIGNAL #{85 * i}")
            case.signals.append(85 * i)
        else:
            case.lines.append("  " + row)

    in_four_states(case, action)
    if row == "CALL":
        case.lines.append("  EOR")
        case.lines += [line for i in range(4)
                       for line in (f"  add{i}:", add.format(8 * i), "  RET")]
    if row in {"NOP", "BSWAIT"}:  # Nothing tells of them but their cost.
        case.facts += ["instructions 8", f"cycles {4 * (1 if row == 'NOP' else 16000) + 6}"]
    results = ["enable"] + [f"m{8 * i}:8" for i in range(4)]
    return f"{row}_in_four_states", case.text(f"{row} with none, some and all enabled", results)


def eor_case(i):
    """Words after EOR do not run."""
    case = Case(f"EOR {i}")
    give_masks(case)
    way = ["CLRENABS", "MEMintoENAB", "MEMintoENAB", "SETENABS"][i]
    case.run(way, *([200 + i] if way == "MEMintoENAB" else []))
    case.lines += ["  EOR", "  INVENABS", "  SIGNAL #1"]
    states = ["none", "some_inside", "some_at_edges", "all"]
    return f"EOR_{states[i]}", case.text(f"EOR with {states[i].replace('_', ' ')} enabled",
                                         ["enable"])


def cases():
    rows = [row for row in model.ROWS if row in MEM_MEM + CONSTANT + ONE_FIELD + TREES]
    for row in rows:
        for low, high in WIDTHS:
            if low <= N_MAX.get(row, 64):
                yield telling_width_case(row, low, False)
                yield telling_width_case(row, min(high, N_MAX.get(row, 64)), True)
    for row in ENABLE_ROWS:
        yield enable_case(row, 7)
        yield enable_case(row, 207)
    for row in ["BSREAD", "BSWRITE"]:
        yield backing_case(row, False)
        yield backing_case(row, True)
    for row in ["NOP", "CALL", "LOOP", "SKIPIFNONE", "SIGNAL", "BSWAIT"]:
        yield control_case(row)
    for i in range(4):
        yield eor_case(i)


def digest(written):
    """The number of cases, and the SHA-256 of their names and texts."""
    text = "".join(f"{name}\n{written[name]}" for name in sorted(written))
    return f"{len(written)} {hashlib.sha256(text.encode()).hexdigest()}\n"


def write(folder, written):
    """Makes `folder` hold these cases and no others. Unchanged files keep their time stamp."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {path.name: path.read_text() for path in folder.glob("*.pxt")}
    for name in found.keys() - written.keys():
        (folder / name).unlink()
    for name, text in written.items():
        if found.get(name) != text:
            (folder / name).write_text(text)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 64
    written = {f"{name}.pxt": text for name, text in cases()}
    now = digest(written)
    if sys.argv[1] == "--check":
        recorded = RECORDED.read_text()
        if now != recorded:
            print(f"The cases are {now}{RECORDED} records {recorded}If the change is intended, "
                  f"run: python3 {__file__} --record")
        return int(now != recorded)
    if sys.argv[1] == "--record":
        RECORDED.write_text(now)
    else:
        write(pathlib.Path(sys.argv[1]), written)
    return 0


if __name__ == "__main__":
    sys.exit(main())
