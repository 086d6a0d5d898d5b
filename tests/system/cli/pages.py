"""The commands of Markdown pages, and a folder in which they find what they name."""
import gzip
import math
import os
import pathlib
import re
import struct
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[3]
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
LIMIT_S = 500  # With sanitizers.


def write_nifti(path: pathlib.Path, size: int, radius: float) -> None:
    """A NIfTI-1 file of int16: a ball of 1000 in 0, voxels of 1 mm, place known to scanners."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, size, size, size, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    struct.pack_into("<b", header, 123, 2)
    struct.pack_into("<2h", header, 252, 0, 1)
    for row in range(3):
        struct.pack_into("<4f", header, 280 + 16 * row,
                         *[1.0 if column == row else 0.0 for column in range(4)])
    header[344:348] = b"n+1\0"
    data = bytes(header) + ball(size, radius)
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)


def write_nrrd(path: pathlib.Path, size: int, radius: float) -> None:
    """The same ball as an NRRD file."""
    header = (f"NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {size} {size} {size}\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
              "space origin: (0,0,0)\nendian: little\nencoding: raw\n\n")
    path.write_bytes(header.encode() + ball(size, radius))


def ball(size: int, radius: float) -> bytes:
    """size^3 voxels of int16, 1000 inside the ball and 0 outside."""
    middle = (size - 1) / 2
    values = [1000 if math.dist((x, y, z), (middle,) * 3) < radius else 0
              for z in range(size) for y in range(size) for x in range(size)]
    return struct.pack(f"<{len(values)}h", *values)


def png_size(path: pathlib.Path):
    data = path.read_bytes()[:24]
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG file"
    return struct.unpack(">II", data[16:24])


def commands_of(block: str) -> list:
    """The commands of a block; lines that end with a backslash belong together."""
    return [line.strip() for line in re.sub(r"\\\n\s*", "", block).splitlines()
            if line.strip() and not line.lstrip().startswith("#")]


def paste(commands: str, folder: pathlib.Path, binaries: pathlib.Path):
    """Runs lines in `folder` as a person pastes them. Stops at the first that fails."""
    env = {**os.environ, "XDG_STATE_HOME": os.path.join(folder, "run"),
           "PATH": f"{binaries}:{os.environ['PATH']}",
           "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(["bash", "-e", "-o", "pipefail", "-c", commands], cwd=folder, env=env,
                          capture_output=True, text=True, timeout=LIMIT_S, check=False)
