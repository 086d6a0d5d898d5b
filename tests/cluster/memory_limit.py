"""Limits of memory for the computers of a cluster, by the kernel's control groups, v1 or v2."""
import os
import pathlib

MIB = 1 << 20
V1 = pathlib.Path("/sys/fs/cgroup/memory")
V2 = pathlib.Path("/sys/fs/cgroup")
# The kernel's files: limit of memory, limit with swap, most memory so far, counts of kills.
FILES = {V1: ("memory.limit_in_bytes", "memory.memsw.limit_in_bytes",
              "memory.max_usage_in_bytes", "memory.oom_control"),
         V2: ("memory.max", "memory.swap.max", "memory.peak", "memory.events")}


def _root():
    """Where groups with a limit of memory can be made; None if nowhere."""
    if (V1 / FILES[V1][0]).exists():
        return V1
    controllers = V2 / "cgroup.subtree_control"
    return V2 if controllers.exists() and "memory" in controllers.read_text().split() else None


def missing():
    """Why this machine cannot limit memory, in a sentence; "" if it can."""
    root = _root()
    if root is None:
        return "the kernel has no control groups for memory"
    return "" if os.access(root, os.W_OK) else f"{root} cannot be written"


class MemoryLimit:
    """All processes of a computer together get `mib` MiB. The kernel kills one that needs more.

    Counts the processes that run now and those that they start: what ssh or Slurm starts, but not
    what Cluster.popen() starts. The context ends after the processes.
    """

    def __init__(self, cluster, computer, mib):
        self._processes = [one for one in cluster.own_processes() if one.computer == computer]
        self._root = _root()
        self._group = self._root / f"pxpl5-test-{os.getpid()}-{computer}"
        self._bytes = mib * MIB

    def __enter__(self):
        self._group.mkdir()
        limit, with_swap, _, _ = FILES[self._root]
        (self._group / limit).write_text(str(self._bytes))
        if (self._group / with_swap).exists():
            (self._group / with_swap).write_text(
                str(self._bytes if self._root == V1 else 0))
        for one in self._processes:
            (self._group / "cgroup.procs").write_text(str(one.pid))
        return self

    def __exit__(self, *_):
        self._group.rmdir()

    def peak_mib(self):
        """The most memory so far, with files that the kernel could drop from its cache."""
        peak = self._group / FILES[self._root][2]
        return int(peak.read_text()) // MIB

    def kills(self):
        """How many processes the kernel has killed for want of memory."""
        lines = (self._group / FILES[self._root][3]).read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("oom_kill "))
