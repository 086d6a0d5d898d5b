"""The pixels of a PNG file, read without a library."""
import pathlib
import struct
import zlib
from typing import List, Tuple

COLORS = {2: 3, 6: 4}  # Bytes of a pixel by the kind of the file: RGB, RGBA.


def rows_of(png: pathlib.Path) -> List[List[Tuple[int, int, int]]]:
    """Red, green and blue of each pixel of an RGB or RGBA file of 8 bits, row by row."""
    data, at, packed = png.read_bytes(), 8, b""
    width, height, bits, kind = struct.unpack(">IIBB", data[16:26])
    while at < len(data):
        length, name = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + length] if name == b"IDAT" else b""
        at += length + 12
    step = COLORS[kind]
    line = width * step
    raw, above, rows = zlib.decompress(packed), bytes(line), []
    assert bits == 8 and len(raw) == height * (1 + line)
    for begin in range(0, len(raw), 1 + line):
        above = unfiltered(raw[begin], raw[begin + 1:begin + 1 + line], above, step)
        rows.append([tuple(above[i:i + 3]) for i in range(0, line, step)])
    return rows


def unfiltered(kind: int, line: bytes, above: bytes, step: int) -> bytes:
    """One row of a PNG file; `above` is the row before."""
    out = bytearray()
    for i, byte in enumerate(line):
        left = out[i - step] if i >= step else 0
        corner = above[i - step] if i >= step else 0
        guess = left + above[i] - corner
        paeth = min((left, above[i], corner), key=lambda value: abs(guess - value))
        out.append((byte + (0, left, above[i], (left + above[i]) // 2, paeth)[kind]) & 255)
    return bytes(out)
