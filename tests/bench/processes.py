"""The kernel's figures of a machine's processes: memory, CPU time by thread."""
import collections
import os
import pathlib
import threading
import time
from typing import Dict, List, NamedTuple, Optional

PROC = pathlib.Path("/proc")
SAMPLE_S = 0.02
IO_THREAD = "ZMQbg"  # How ZeroMQ names its threads.


class Stat(NamedTuple):
    """The needed fields of /proc/PID/stat."""
    name: str
    parent: int


def parse_stat(text: str) -> Stat:
    """The name may hold blanks and brackets: it ends at the last one."""
    opening, closing = text.index("("), text.rindex(")")
    return Stat(text[opening + 1:closing], int(text[closing + 1:].split()[1]))


def parse_ran(text: str) -> float:
    """Seconds that a thread has run, from the text of its schedstat, which counts nanoseconds."""
    return int(text.split()[0]) / 1e9


def pss_kib(text: str) -> int:
    """Proportional set size from the text of smaps_rollup: shared pages count by their share."""
    for line in text.splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1])
    raise ValueError("smaps_rollup has no line 'Pss:'")


def _read(path: pathlib.Path) -> Optional[str]:
    """A file of /proc, or None if its process has gone."""
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except (FileNotFoundError, ProcessLookupError, PermissionError):
        return None


def family(root: int) -> List[int]:
    """`root` and all its descendants that live."""
    children = collections.defaultdict(list)
    for entry in PROC.iterdir():
        text = _read(entry / "stat") if entry.name.isdigit() else None
        if text:
            children[parse_stat(text).parent].append(int(entry.name))
    found, at = [root], 0
    while at < len(found):
        found += children[found[at]]
        at += 1
    return found


def memory_kib(pids: List[int]) -> int:
    """Sum of the processes' proportional set sizes; those that have gone count nothing."""
    texts = [_read(PROC / str(pid) / "smaps_rollup") for pid in pids]
    return sum(pss_kib(text) for text in texts if text)


def cpu_seconds(pids: List[int]) -> Dict[str, float]:
    """CPU time by process name, and with ' io' behind it that of ZeroMQ's threads."""
    seconds: Dict[str, float] = collections.defaultdict(float)
    for pid in pids:
        process = _read(PROC / str(pid) / "stat")
        if process is None:
            continue
        name = parse_stat(process).name
        for task in (PROC / str(pid) / "task").iterdir():
            thread, ran = _read(task / "comm"), _read(task / "schedstat")
            if thread and ran:
                is_io = thread.startswith(IO_THREAD)
                seconds[name + (" io" if is_io else "")] += parse_ran(ran)
    return dict(seconds)


class PeakMemory:
    """Samples the memory of a process and its descendants while a `with` block runs."""

    def __init__(self, root: int):
        self.peak_kib = 0
        self.samples = 0
        self._root = root
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch)

    def _sample(self):
        self.peak_kib = max(self.peak_kib, memory_kib(family(self._root)))
        self.samples += 1

    def _watch(self):
        while not self._over.wait(SAMPLE_S):
            self._sample()

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()
        self._sample()  # A block shorter than a sample's distance counts, too.


def parse_idle(text: str) -> float:
    """Seconds in which a core had nothing to do, of all cores, from the text of /proc/stat."""
    fields = text.split("\n", 1)[0].split()
    if fields[0] != "cpu":
        raise ValueError(f"/proc/stat begins with '{fields[0]}', not with 'cpu'")
    return (int(fields[4]) + int(fields[5])) / os.sysconf("SC_CLK_TCK")


class Usage(NamedTuple):
    """At one time."""
    seconds: Dict[str, float]  # As of cpu_seconds().
    idle_s: float
    at_s: float


def usage(pids: List[int]) -> Usage:
    """Resources that the processes and the computer have used so far."""
    text = (PROC / "stat").read_text(encoding="utf-8")
    return Usage(cpu_seconds(pids), parse_idle(text), time.perf_counter())


def shares(before: Usage, after: Usage, cores: int) -> Dict[str, float]:
    """Each name's share of all cores' time between, 'idle', and 'others': what is left."""
    whole = (after.at_s - before.at_s) * cores
    if whole <= 0:
        raise ValueError(f"no shares of {after.at_s - before.at_s} s on {cores} cores")
    parts = {name: max(0.0, seconds - before.seconds.get(name, 0.0)) / whole
             for name, seconds in after.seconds.items()}
    parts["idle"] = min((after.idle_s - before.idle_s) / whole, 1 - min(1, sum(parts.values())))
    parts["others"] = max(0.0, 1 - sum(parts.values()))
    return parts
