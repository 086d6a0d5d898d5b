"""Volumes, surfaces and isovalues of the paper's loads."""
import json
import pathlib
import subprocess
from typing import List, NamedTuple, Tuple

from session import MeasureError


class Load(NamedTuple):
    """One of the paper's five surfaces."""
    key: str  # skin, muscle, bone, ultrasound or head, as in the tables of goals.
    volume: str  # As the command `load` takes it.
    surface: str
    isovalue: float


# Scans of the project's shared data folder. Their triangle counts are within 2 % of the paper's.
REAL = [
    ("skin", "ct/knee_128x128x56.nrrd", -519.5),
    ("muscle", "ct/knee_128x128x56.nrrd", 76.5),
    ("bone", "ct/knee_128x128x56.nrrd", 180.5),
    ("ultrasound", "us/spine_phantom_128x64x96.nrrd", 13.5),
    ("head", "mr/head_96x96x109.mha", 70.5),
]
# Built in; their isovalues are asked of the program.
PHANTOMS = [
    ("skin", "phantom:pelvis", "skin"),
    ("muscle", "phantom:pelvis", "muscle"),
    ("bone", "phantom:pelvis", "bone"),
    ("ultrasound", "phantom:fetus", "face"),
    ("head", "phantom:head", "skin"),
]
NUDGE = 0.25  # Isovalues alternate by this: the work is done again, the surface stays the same.


def real_loads(data: str) -> List[Load]:
    """The real volumes in folder `data`. Raises MeasureError naming the one that lacks."""
    loads = []
    for key, name, isovalue in REAL:
        path = pathlib.Path(data) / name
        if not path.is_file():
            raise MeasureError(f"{path}: not there; --data names the folder of real volumes")
        loads.append(Load(key, str(path.resolve()), key, isovalue))
    return loads


def phantom_loads(program: str) -> List[Load]:
    """The built-in volumes."""
    isovalues = {}
    for volume in sorted({volume for _, volume, _ in PHANTOMS}):
        answer = subprocess.run([program, "info", volume, "--json"], stdout=subprocess.PIPE,
                                text=True, check=True).stdout
        for surface in json.loads(answer)["result"]["surfaces"]:
            isovalues[volume, surface["name"]] = surface["isovalue"]
    return [Load(key, volume, surface, isovalues[volume, surface])
            for key, volume, surface in PHANTOMS]


def chosen_loads(program: str, data: str, keys: str) -> Tuple[str, List[Load]]:
    """'real' or 'phantoms', and the loads whose keys are in the list `keys` ("skin,head").

    data  Folder of real volumes; "phantoms" asks for the built-in ones; "" takes the real ones
          if they are where the project keeps them.
    Raises MeasureError for a key that is none, or a volume that is not there.
    """
    usual = pathlib.Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = data or (str(usual) if usual.is_dir() else "phantoms")
    loads = phantom_loads(program) if folder == "phantoms" else real_loads(folder)
    wanted = keys.split(",") if keys else [load.key for load in loads]
    unknown = sorted(set(wanted) - {load.key for load in loads})
    if unknown:
        raise MeasureError(f"--loads: there is no {', '.join(unknown)}; there are "
                           f"{', '.join(load.key for load in loads)}")
    kind = "phantoms" if folder == "phantoms" else "real"
    return kind, [load for load in loads if load.key in wanted]
