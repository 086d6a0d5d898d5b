"""The processes that a program has started."""
import pathlib

# The machine ends when a node dies.
ENDS = tuple(word for role in ("gp", "renderer", "frame_buffer")
             for word in ("--set", f"{role}.restart.policy=end"))


def children_of(pid):
    """Process ids whose parent is `pid`."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if entry.name.isdigit():
                stat = (entry / "stat").read_text(errors="replace")
                parent = int(stat.rsplit(")", 1)[1].split()[1])
                found += [int(entry.name)] if parent == pid else []
        except (FileNotFoundError, ProcessLookupError):
            pass  # It ended while we looked.
    return found


def name_of(pid):
    """Empty if the process has ended, as pxpl5-io does once its picture is written."""
    try:
        return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
    except (FileNotFoundError, ProcessLookupError):
        return ""
