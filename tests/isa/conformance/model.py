"""The instruction set once more, from the sentences of isa/ISA.md, in Python's unbounded integers.

It shares nothing with the executors in C++: neither code nor tables. A pixel's memory is one
integer; each row is one function of a pixel.
"""
import math

MEMORY_BITS = 208


class Pixel:
    """One pixel: its place, its memory as one integer, its bits and its backing store."""

    def __init__(self, x, y):
        self.x, self.y = x, y
        self.memory = 0
        self.enable = self.carry = False
        self.blocks = {}
        self.readout = 0

    def field(self, a, n):
        return self.memory >> a & (1 << n) - 1

    def set_field(self, a, n, value):
        mask = (1 << n) - 1
        self.memory = self.memory & ~(mask << a) | (value & mask) << a

    def write(self, a, n, value):
        """Writes only enabled pixels, as an instruction does."""
        if self.enable:
            self.set_field(a, n, value)

    def keep_where(self, passes):
        """A test clears E where it fails."""
        self.enable = self.enable and bool(passes)

    def set_carry(self, carry):
        if self.enable:
            self.carry = bool(carry)


def signed(value, n):
    """The low n bits of value, as a two's complement number."""
    value &= (1 << n) - 1
    return value - (1 << n) if value >> (n - 1) else value


def unsigned(value, n):
    return value & (1 << n) - 1


def tree(p, k):
    """Q at the pixel: A x + B y + C (+ D x^2 + E x y + F y^2)."""
    q = k[0] * p.x + k[1] * p.y + k[2]
    if len(k) == 6:
        q += k[3] * p.x * p.x + k[4] * p.x * p.y + k[5] * p.y * p.y
    return q


def add(p, a, n, value):
    """Adds the low n bits of value to m[a]; carry is the carry out."""
    total = p.field(a, n) + unsigned(value, n)
    p.write(a, n, total)
    p.set_carry(total >= 1 << n)


def subtract(p, a, n, value):
    """Subtracts the low n bits of value from m[a]; carry is the borrow."""
    difference = p.field(a, n) - unsigned(value, n)
    p.write(a, n, difference)
    p.set_carry(difference < 0)


def saturated(p, a, n, total):
    """Holds total within n bits; carry is 1 where it was held."""
    held = min(max(total, 0), (1 << n) - 1)
    p.write(a, n, held)
    p.set_carry(held != total)


def set_enable(p, enable):
    p.enable = bool(enable)


# Rows in which pixels take part. o.a, o.b, o.n are the operands, k the coefficients.

TREE = {
    "geZERO": lambda p, o, k: p.keep_where(signed(tree(p, k), o.n) >= 0),
    "ltZERO": lambda p, o, k: p.keep_where(signed(tree(p, k), o.n) < 0),
    "ltMEM": lambda p, o, k: p.keep_where(
        unsigned(tree(p, k) // 2**o.b, o.n) < p.field(o.a, o.n)),
    "geMEM": lambda p, o, k: p.keep_where(
        unsigned(tree(p, k) // 2**o.b, o.n) >= p.field(o.a, o.n)),
    "intoMEM": lambda p, o, k: p.write(o.a, o.n, tree(p, k) // 2**o.b),
    "clampintoMEM": lambda p, o, k: p.write(
        o.a, o.n, min(max(tree(p, k) // 2**o.b, 0), 2**o.n - 1)),
}
MEMTREE = {
    "MEMpluseq": lambda p, o, k: add(p, o.a, o.n, tree(p, k) // 2**o.b),
    "MEMminuseq": lambda p, o, k: subtract(p, o.a, o.n, tree(p, k) // 2**o.b),
}


def product(p, o, left, right):
    p.write(o.a, 2 * o.n, left * right)


def divide(p, o):
    divisor = p.field(o.b, o.n)
    p.write(o.a, o.n, -1 if divisor == 0 else p.field(o.a, o.n) // divisor)


ROWS = {
    "SETENABS": lambda p, o, k: set_enable(p, True),
    "CLRENABS": lambda p, o, k: set_enable(p, False),
    "INVENABS": lambda p, o, k: set_enable(p, not p.enable),
    "ENABintoMEM": lambda p, o, k: p.set_field(o.a, 1, int(p.enable)),
    "MEMintoENAB": lambda p, o, k: set_enable(p, p.field(o.a, 1)),
    "ENABandeqMEM": lambda p, o, k: p.keep_where(p.field(o.a, 1) == 1),
    "ENABandeqNOTMEM": lambda p, o, k: p.keep_where(p.field(o.a, 1) == 0),
    "ENABoreqMEM": lambda p, o, k: set_enable(p, p.enable or p.field(o.a, 1) == 1),
    "ENABandeqCARRY": lambda p, o, k: p.keep_where(p.carry),
    "MEMintoMEM": lambda p, o, k: p.write(o.a, o.n, p.field(o.b, o.n)),
    "CONSTintoMEM": lambda p, o, k: p.write(o.a, o.n, k[0]),
    "IMMintoMEM": lambda p, o, k: p.write(o.a, o.n, o.b),
    "CLEARMEM": lambda p, o, k: p.write(o.a, o.n, 0),
    "NOTMEM": lambda p, o, k: p.write(o.a, o.n, ~p.field(o.a, o.n)),
    "MEMandeqMEM": lambda p, o, k: p.write(o.a, o.n, p.field(o.a, o.n) & p.field(o.b, o.n)),
    "MEMoreqMEM": lambda p, o, k: p.write(o.a, o.n, p.field(o.a, o.n) | p.field(o.b, o.n)),
    "MEMxoreqMEM": lambda p, o, k: p.write(o.a, o.n, p.field(o.a, o.n) ^ p.field(o.b, o.n)),
    "MEMltMEM": lambda p, o, k: p.keep_where(p.field(o.a, o.n) < p.field(o.b, o.n)),
    "MEMltMEMsigned": lambda p, o, k: p.keep_where(
        signed(p.field(o.a, o.n), o.n) < signed(p.field(o.b, o.n), o.n)),
    "MEMeqMEM": lambda p, o, k: p.keep_where(p.field(o.a, o.n) == p.field(o.b, o.n)),
    "MEMeqCONST": lambda p, o, k: p.keep_where(p.field(o.a, o.n) == unsigned(k[0], o.n)),
    "MEMgeCONST": lambda p, o, k: p.keep_where(p.field(o.a, o.n) >= unsigned(k[0], o.n)),
    "MEMltCONST": lambda p, o, k: p.keep_where(p.field(o.a, o.n) < unsigned(k[0], o.n)),
    "MEMgeCONSTsigned": lambda p, o, k: p.keep_where(
        signed(p.field(o.a, o.n), o.n) >= signed(k[0], o.n)),
    "MEMltCONSTsigned": lambda p, o, k: p.keep_where(
        signed(p.field(o.a, o.n), o.n) < signed(k[0], o.n)),
    "MEMpluseqMEM": lambda p, o, k: add(p, o.a, o.n, p.field(o.b, o.n)),
    "MEMminuseqMEM": lambda p, o, k: subtract(p, o.a, o.n, p.field(o.b, o.n)),
    "MEMpluseqCONST": lambda p, o, k: add(p, o.a, o.n, k[0]),
    "MEMsatpluseqMEM": lambda p, o, k: saturated(
        p, o.a, o.n, p.field(o.a, o.n) + p.field(o.b, o.n)),
    "MEMsatminuseqMEM": lambda p, o, k: saturated(
        p, o.a, o.n, p.field(o.a, o.n) - p.field(o.b, o.n)),
    "NEGMEM": lambda p, o, k: p.write(o.a, o.n, -p.field(o.a, o.n)),
    "ABSMEM": lambda p, o, k: p.write(o.a, o.n, abs(signed(p.field(o.a, o.n), o.n))),
    "MULMEM": lambda p, o, k: product(p, o, p.field(o.a, o.n), p.field(o.b, o.n)),
    "MULMEMsigned": lambda p, o, k: product(
        p, o, signed(p.field(o.a, o.n), o.n), signed(p.field(o.b, o.n), o.n)),
    "MULCONST": lambda p, o, k: product(
        p, o, signed(p.field(o.b, o.n), o.n), signed(k[0], o.n)),
    "DIVMEM": lambda p, o, k: divide(p, o),
    "SQRTMEM": lambda p, o, k: p.write(o.a, o.n, math.isqrt(p.field(o.a, o.n))),
    "BSREAD": lambda p, o, k: p.write(o.a, 32, p.blocks.get(o.b, 0)),
    "BSWRITE": lambda p, o, k: p.blocks.update(
        {o.b: p.field(o.a, 32)} if p.enable else {}),
    "PIXELSTOFB": lambda p, o, k: setattr(p, "readout", p.field(o.a, o.n)),
}
for name, row in TREE.items():
    ROWS["TREE" + name] = ROWS["QUAD" + name] = row
for name, row in MEMTREE.items():
    ROWS[name + "TREE"] = ROWS[name + "QUAD"] = row

# How an instruction is written.

SYNTAX = {
    "ENABintoMEM": "m{a}", "MEMintoENAB": "m{a}", "ENABandeqMEM": "m{a}",
    "ENABandeqNOTMEM": "m{a}", "ENABoreqMEM": "m{a}",
    "MEMintoMEM": "m{b} m{a}:{n}", "IMMintoMEM": "m{a}:{n} #{b}",
    "BSREAD": "m{a} bs{b}", "BSWRITE": "m{a} bs{b}", "LOOP": "#{b}", "SIGNAL": "#{b}",
    "MULCONST": "m{a}:{n} m{b}",
    **{row: "m{a}:{n} m{b}" for row in (
        "MEMandeqMEM MEMoreqMEM MEMxoreqMEM MEMltMEM MEMltMEMsigned MEMeqMEM MEMpluseqMEM "
        "MEMminuseqMEM MEMsatpluseqMEM MEMsatminuseqMEM MULMEM MULMEMsigned DIVMEM").split()},
    **{row: "m{a}:{n}" for row in (
        "CONSTintoMEM CLEARMEM NOTMEM MEMeqCONST MEMgeCONST MEMltCONST MEMgeCONSTsigned "
        "MEMltCONSTsigned MEMpluseqCONST NEGMEM ABSMEM SQRTMEM PIXELSTOFB").split()},
    **{tree + test: ":{n}" for tree in ("TREE", "QUAD") for test in ("geZERO", "ltZERO")},
    **{tree + test: "m{a}:{n} >>{b}" for tree in ("TREE", "QUAD")
       for test in ("ltMEM", "geMEM", "intoMEM", "clampintoMEM")},
    **{change + tree: "m{a}:{n} >>{b}" for tree in ("TREE", "QUAD")
       for change in ("MEMpluseq", "MEMminuseq")},
}
