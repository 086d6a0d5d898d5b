"""Files include only the folders below them."""
import pathlib
import posixpath
import re
from typing import List

import tree

MAY_INCLUDE = {
    "isa": {"isa"},
    "ringbus": {"ringbus"},
    "gp_firmware": {"gp_firmware", "isa", "ringbus"},
    "renderer_firmware": {"renderer_firmware", "isa", "ringbus"},
    "host": {"host", "isa", "ringbus"},
    "tests": {"tests", "host", "gp_firmware", "renderer_firmware", "isa", "ringbus"},
}
# The rooms of a folder, from the bottom up, and which of its other rooms each may include. "." is
# the folder's own files. A room of a room has its own row: "host/inspect": {"record": ...}.
ROOMS = {
    "isa": {".": set(), "reference": {"."}, "conformance": {"."}, "contract": {"."}},
    "ringbus": {"rules": set(), ".": {"rules"}, "trace": {"."}, "zmq": {"."},
                "simulated": {"."}, "process": {".", "trace", "zmq"}},
    "renderer_firmware": {
        "hal": set(),
        "programs": set(),
        "fast": {"hal", "programs"},
        "igc": {"programs"},
        ".": {"fast", "igc"},
    },
    "gp_firmware": {
        "hal": set(),
        "volume": {"hal"},
        "surface": {"volume", "hal"},
        "slices": {"surface", "volume"},
        "geometry": {"surface"},
        "render": {"geometry", "slices", "surface", "hal"},
        "node": {"render", "geometry", "slices", "surface", "volume", "hal"},
        ".": {"node"},
    },
    "host": {
        "base": set(),
        "film": {"base"},
        "volume": {"base"},
        "scene": {"base", "volume"},
        "chart": {"base", "scene"},
        "surface": {"base", "volume", "scene", "chart"},
        "phigs": {"base", "scene"},
        "phantom": {"base", "volume"},
        "io": {"base", "volume", "scene", "surface", "phigs", "phantom"},
        "frame_buffer": {"base"},
        "machine": {"base"},
        "timing": {"base", "machine"},
        "session": {"base", "volume", "scene", "chart", "surface", "phantom", "machine", "timing"},
        "inspect": {"base", "volume", "scene", "chart", "phantom", "frame_buffer", "machine",
                    "timing", "session"},
        "commands": {"base", "chart", "film", "volume", "scene", "surface", "phantom", "machine",
                     "timing", "session", "inspect"},
        "report": {"base", "chart", "phantom", "machine", "timing", "session", "inspect",
                   "commands"},
        "serve": {"base", "film", "volume", "machine", "scene", "session", "inspect", "commands"},
        ".": {"base", "phantom", "machine", "inspect", "commands", "report", "serve"},
    },
    "host/timing": {"counts": set(), "replay": {"counts"}, ".": {"counts", "replay"},
                    "cluster": {"counts", "replay", "."}},
    "host/surface": {"atlas": set(), ".": set(), "blocks": {"."}, "export": {"."},
                     "parts": {"."}},
    "host/session": {"activity": set(), "history": set(), "transfer": set(), "pictures": set(),
                     ".": {"activity", "history", "transfer"}},
    "host/io": {
        "values": set(),
        "formats": {"values"},
        "dicom": {"values"},
        "picture": set(),
        "mesh": {"values"},
        "sandbox": set(),
        "zarr": {"values", "formats"},
        "packed": {"values", "formats", "dicom"},
        ".": {"values", "formats", "dicom", "picture", "mesh", "sandbox", "zarr", "packed"},
    },
    "host/inspect": {
        "record": set(),
        "replay": {"record"},
        "listing": {"record", "replay"},
        "map": {"record", "replay"},
        "step": {"record", "replay", "listing", "map"},
        "diff": {"record", "replay"},
        "why": {"record", "listing", "step"},
        "model": {"record", "listing", "why"},
        "tools": {"record", "replay", "listing", "map", "step", "diff", "why", "model"},
    },
    "host/commands": {"text": set(), "pictures": {"text"}, ".": {"text", "pictures"},
                      "questions": {".", "text", "pictures"}},
    "host/serve": {"depths": set(), "video": set(), "texts": set(), "encoding": set(),
                   "server": {"depths", "encoding", "video", "texts"},
                   "director": {"encoding", "server"},
                   "job": {"director"}, "limits": {"server"},
                   "classroom": {"server", "job", "limits", "texts"}, "page": set(),
                   ".": {"server", "director", "job", "limits", "classroom"}},
    "host/serve/page": {
        "texts": set(),
        "link": {"texts"},
        "elements": {"texts"},
        "state": {"texts", "link"},
        "picture": {"texts", "link", "elements", "state"},
        "panel": {"texts", "link", "elements", "state", "picture"},
        "surfaces": {"texts", "link", "elements", "state", "picture", "panel"},
        "headset": {"texts", "link", "elements", "picture", "panel"},
        "slices": {"texts", "link", "elements", "panel"},
        "inspect": {"texts", "link", "elements", "panel"},
        "machine": {"texts", "link", "elements", "panel"},
        "volume": {"texts", "link", "elements", "panel"},
        "tour": {"texts", "link", "elements", "panel", "inspect", "machine"},
        "shell": {"texts", "link", "elements", "picture", "panel", "slices", "inspect", "machine",
                  "volume"},
        ".": {"texts", "link", "elements", "state", "picture", "panel", "headset", "surfaces",
              "volume", "shell", "tour"},
    },
}
# Files that the build writes. generated/vocabulary.hpp is plain: every folder may include it.
GENERATED = re.compile(r"^(\w+_generated\.h|generated/\w+\.hpp|schema_hash\.hpp|\w+\.inc)$")
FIRMWARE = {"gp_firmware", "renderer_firmware"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
# `import ... from 'x'` of an ES module, its last line if it has several, and import('x') of types.
IMPORT = re.compile(r"""(?:\bfrom\s*|\bimport\s*\(?\s*)(['"])([^'"]+)\1""")
PAGE = "host/serve/page"

ZMQ = re.compile(r"^zmq(\.hpp|\.h|_addon\.hpp)$")
SOCKETS = re.compile(r"^(libwebsockets\.h|libwebsockets/.*)$")
CODECS = re.compile(r"^(itk|OpenImageIO/|assimp/|cairo|ft2build|meshoptimizer|gdcm|nifti|vnl/"
                    r"|seccomp|expat|blosc|archive(_entry)?\.h|zip\.h)")
MESSAGES = re.compile(
    r"^(.*_generated\.h|flatbuffers/.*|ringbus/(message|node|process/process)\.hpp)$")


# Inspection executes the firmware again, so it alone of the host may include it.
INSPECT = ("host", "inspect")


def _is_node_or_main(path: pathlib.PurePath) -> bool:
    in_node = path.parts[0] in FIRMWARE and path.parts[1:2] == ("node",)
    return in_node or path.name == "main.cpp" or \
        bool(re.match(r"node(_\w+)?\.[ch]pp$", path.name))


def may_use_messages(path: pathlib.PurePath) -> bool:
    """Messages are for ringbus, nodes, mains, and the parts of the host that talk to nodes.

    A file called X_messages converts X to messages and back.
    """
    parts = path.parts
    if parts[0] in {"ringbus", "tests"} or _is_node_or_main(path) or \
            path.stem.endswith("_messages"):
        return True
    return parts[0] == "host" and (
        parts[1] in {"volume", "machine", "io", "frame_buffer", "session", "surface", "inspect"})


def _layer_error(path: pathlib.PurePath, included: str) -> str:
    """main -> node -> stages -> hal, within a firmware."""
    parts = path.parts
    if parts[0] not in FIRMWARE or len(parts) < 3 or parts[1] == "node":
        return ""
    if included.startswith("ringbus/") and not included.startswith("ringbus/rules/") or \
            included.startswith(parts[0] + "/node"):
        return f"a stage may not include {included}"
    if parts[1] == "hal" and included.startswith(parts[0] + "/"):
        if not included.startswith(parts[0] + "/hal/"):
            return f"hal may not include the stage {included}"
    return ""


def _room_of(folder: str, name: str) -> str:
    """The room of `folder` that the file `name` lies in, or '' if it lies elsewhere."""
    if not name.startswith(folder + "/"):
        return ""
    inside = name[len(folder) + 1:].split("/")
    return inside[0] if len(inside) > 1 else "."


def _room_error(path: pathlib.PurePath, included: str) -> str:
    """An include goes down, from room to room of ROOMS."""
    for folder, rooms in ROOMS.items():
        room = _room_of(folder, path.as_posix())
        if room and room not in rooms:
            return f"{folder}/{room} is not in ROOMS of check_includes.py"
        target = _room_of(folder, included)
        if room and target and target not in rooms[room] | {room}:
            return f"{folder}/{room} may not include {folder}/{target}"
    return ""


def error_of(path: pathlib.PurePath, quote: str, included: str) -> str:
    """The error if `path` must not include `included`, or ''."""
    owner, target = path.parts[0], included.split("/")[0]
    allowed = MAY_INCLUDE.get(owner, set()) | (FIRMWARE if path.parts[:2] == INSPECT else set())
    if quote == '"' and target in MAY_INCLUDE and target not in allowed:
        return f"{owner} may not include {target}"
    is_rooted = "/" in included and target in MAY_INCLUDE
    if quote == "<" and (is_rooted or GENERATED.match(included)):
        return f"<{included}> is a file of this repository; include it in double quotes"
    if ".." in included.split("/"):
        return f'"{included}" is not a path from the top of the repository'
    if quote == '"' and not is_rooted and not GENERATED.match(included):
        return f'"{included}" is not a path from the top of the repository'
    is_link = path.as_posix().startswith(("ringbus/zmq/", "tests/ringbus/test_zmq_link"))
    if ZMQ.match(included) and not is_link:
        return "only ringbus/zmq/* includes ZeroMQ"
    is_server = path.as_posix().startswith("host/serve/server/") and path.suffix == ".cpp"
    if SOCKETS.match(included) and not is_server:
        return "only host/serve/server/*.cpp includes libwebsockets"
    if CODECS.match(included) and path.parts[:2] != ("host", "io") and \
            path.parts[:3] != ("tests", "host", "io"):
        return f"only host/io includes {included}"
    if MESSAGES.match(included) and not may_use_messages(path):
        return f"only ringbus, nodes and the host's machine side include {included}"
    return _layer_error(path, included) or _room_error(path, included)


def import_error(path: pathlib.PurePath, imported: str) -> str:
    """The fault of the page's module `path` importing `imported`, or ''."""
    if not imported.startswith(("./", "../")):
        return f"'{imported}' is not a relative path; nothing else is served"
    target = posixpath.normpath((path.parent / imported).as_posix())
    if not target.startswith(PAGE + "/"):
        return f"'{imported}' lies outside of {PAGE} and is not served"
    return _room_error(path, target)


def _import_errors(root: pathlib.Path, path: pathlib.Path) -> List[str]:
    found = []
    for number, line in enumerate(tree.read(root, path).splitlines(), 1):
        for match in IMPORT.finditer(line):
            error = import_error(path, match[2])
            if error:
                found.append(f"{path}:{number}: {error}")
    return found


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for path in tree.files_of(root):
        is_page = path.as_posix().startswith(PAGE + "/") and not tree.is_translation(path)
        if path.suffix in {".js", ".ts"} and is_page:
            errors += _import_errors(root, path)
        if path.suffix not in tree.CPP | {".def"} or path.parts[0] not in MAY_INCLUDE:
            continue
        for number, line in enumerate(tree.read(root, path).splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                error = error_of(path, match[1], match[2])
                if error:
                    errors.append(f"{path}:{number}: {error}")
    return errors
