"""Real volumes as MetaImage files beside raw voxels, which VTK reads without help."""
import gzip
import math
import pathlib
import zlib
from typing import Dict, NamedTuple, Tuple


class Volume(NamedTuple):
    """x fastest, little endian."""
    dims: Tuple[int, ...]
    spacing_mm: Tuple[float, ...]
    element: str  # MET_SHORT, MET_UCHAR, ...
    voxels: bytes


ELEMENTS = {"short": "MET_SHORT", "int16": "MET_SHORT", "signed short": "MET_SHORT",
            "ushort": "MET_USHORT", "uint16": "MET_USHORT", "unsigned short": "MET_USHORT",
            "uchar": "MET_UCHAR", "uint8": "MET_UCHAR", "unsigned char": "MET_UCHAR",
            "float": "MET_FLOAT"}
ELEMENT_BYTES = {"MET_SHORT": 2, "MET_USHORT": 2, "MET_UCHAR": 1, "MET_FLOAT": 4}


def _checked(volume: Volume, name: str) -> Volume:
    needed = math.prod(volume.dims) * ELEMENT_BYTES[volume.element]
    if len(volume.voxels) != needed:
        raise ValueError(f"{name}: {volume.dims} of {volume.element} need {needed} bytes, "
                         f"there are {len(volume.voxels)}")
    return volume


def parse_nrrd(data: bytes, name: str) -> Volume:
    """An NRRD file with its voxels in it, raw or gzip. Raises ValueError naming what is wrong."""
    if not data.startswith(b"NRRD") or b"\n\n" not in data:
        raise ValueError(f"{name}: no NRRD file with its voxels in it")
    head, body = data.split(b"\n\n", 1)
    fields: Dict[str, str] = {}
    for line in head.decode("latin1").splitlines()[1:]:
        if ": " in line and not line.startswith("#"):
            key, value = line.split(": ", 1)
            fields[key] = value.strip()
    encoding = fields["encoding"]
    if encoding not in ("raw", "gzip", "gz") or fields.get("endian", "little") != "little":
        raise ValueError(f"{name}: {encoding}, {fields.get('endian')} endian is not understood")
    axes = fields["space directions"].split()
    spacing = tuple(math.hypot(*map(float, axis.strip("()").split(","))) for axis in axes)
    voxels = body if encoding == "raw" else gzip.decompress(body)
    return _checked(Volume(tuple(map(int, fields["sizes"].split())), spacing,
                           ELEMENTS[fields["type"]], voxels), name)


def parse_metaimage(data: bytes, name: str) -> Volume:
    """A MetaImage file with its voxels in it. Raises ValueError naming what is wrong."""
    mark = b"ElementDataFile = LOCAL\n"
    if mark not in data:
        raise ValueError(f"{name}: no MetaImage file with its voxels in it")
    head, body = data.split(mark, 1)
    fields = dict(line.split(" = ", 1) for line in head.decode("latin1").splitlines())
    if fields.get("BinaryDataByteOrderMSB", "False") != "False":
        raise ValueError(f"{name}: big endian is not understood")
    voxels = zlib.decompress(body) if fields.get("CompressedData") == "True" else body
    return _checked(Volume(tuple(map(int, fields["DimSize"].split())),
                           tuple(map(float, fields["ElementSpacing"].split())),
                           fields["ElementType"], voxels), name)


def convert(source: str, folder: str) -> str:
    """Writes `source` into `folder` as NAME.mhd and NAME.raw. Returns the path of the former."""
    path = pathlib.Path(source)
    parse = parse_nrrd if path.suffix == ".nrrd" else parse_metaimage
    volume = parse(path.read_bytes(), path.name)
    out = pathlib.Path(folder) / (path.stem + ".mhd")
    out.with_suffix(".raw").write_bytes(volume.voxels)
    out.write_text(
        "ObjectType = Image\nNDims = 3\n"
        f"DimSize = {' '.join(map(str, volume.dims))}\n"
        f"ElementSpacing = {' '.join(map(str, volume.spacing_mm))}\n"
        f"ElementType = {volume.element}\nElementByteOrderMSB = False\n"
        f"ElementDataFile = {out.stem}.raw\n", encoding="utf-8")
    return str(out)
