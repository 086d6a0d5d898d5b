"""The top level is fixed, and every folder says what it is."""
import pathlib
from typing import List

import tree

FOLDERS = {"gp_firmware", "renderer_firmware", "host", "ringbus", "isa", "tests"}
FILES = {"CMakeLists.txt", "README.md", "CMakePresets.json", "CHANGELOG.md", "LICENSE"}
MAY_BE = {"CONTRIBUTING.md", "NOTICE", "CITATION.cff", "Containerfile"}


def _described(path: pathlib.PurePath) -> str:
    """The folder whose README must speak of `path`: a top-level one, or one directly in host."""
    parts = path.parts
    if parts[0] == "host" and len(parts) > 2 and path.suffix in {".cpp", ".hpp"}:
        return "/".join(parts[:2])
    return parts[0]


def check(root: pathlib.Path) -> List[str]:
    files = tree.files_of(root)
    errors = []
    for top in sorted({path.parts[0] for path in files}):
        is_folder = (root / top).is_dir()
        if not top.startswith(".") and top not in (FOLDERS if is_folder else FILES | MAY_BE):
            errors.append(f"{top}: the top level is fixed: {' '.join(sorted(FOLDERS | FILES))}")
    for missing in sorted((FOLDERS | FILES) - {path.parts[0] for path in files}):
        errors.append(f"{missing}: is missing from the top level")
    described = {_described(path) for path in files if path.parts[0] in FOLDERS}
    for folder in sorted(described):
        if not (root / folder / "README.md").is_file():
            errors.append(f"{folder}: has no README.md")
    return errors
