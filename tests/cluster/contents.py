"""What is in a cluster: its processes and files, seen from outside."""
import dataclasses
import os
import pathlib
import select
import time

SHARED = ("/home",)
PLACES = ("/tmp", "/var/tmp", "/dev/shm", "/run")
CLUSTERS_OWN = ("/run/cluster", "/run/machine")


@dataclasses.dataclass(frozen=True)
class Running:
    """A process on a computer. `pid` is its number on this machine, not on the computer."""
    computer: str
    pid: int
    started: int  # Ticks since this machine's boot.
    user_id: int
    argv: tuple

    @property
    def key(self):
        return self.pid, self.started

    def __str__(self):
        return f"{self.computer}: {' '.join(self.argv)} (process {self.pid})"


def _process(pid):
    """Parent, start and pid namespace of a process that is no zombie; None if it has ended."""
    folder = pathlib.Path(f"/proc/{pid}")
    try:
        words = (folder / "stat").read_text().rsplit(")", 1)[1].split()
        if words[0] in "ZX":
            return None
        return int(words[1]), int(words[19]), os.readlink(folder / "ns/pid")
    except OSError:
        return None


def processes(first):
    """All processes of computers, given their first ones; also those in namespaces below."""
    found = {int(name): data for name in os.listdir("/proc") if name.isdigit()
             and (data := _process(int(name)))}
    computers = {found[pid][2]: name for name, pid in first.items() if pid in found}
    running = []

    def computer_of(pid):
        while pid in found:
            if found[pid][2] in computers:
                return computers[found[pid][2]]
            pid = found[pid][0]
        return None

    for pid, (_, started, _) in found.items():
        computer = computer_of(pid)
        if computer:
            try:
                folder = pathlib.Path(f"/proc/{pid}")
                argv = (folder / "cmdline").read_text(errors="replace").rstrip("\0").split("\0")
                running.append(Running(computer, pid, started, folder.stat().st_uid, tuple(argv)))
            except OSError:
                pass  # It has ended meanwhile.
    return running


def wait_for_descriptors(ends, limit_s):
    """Waits for the end of processes, given as pidfds. Returns those that have not ended."""
    end = time.monotonic() + limit_s
    left = set(ends)
    while left:
        ended, _, _ = select.select(left, [], [], max(0, end - time.monotonic()))
        if not ended:
            break
        left -= set(ended)
    return left


def wait_for(running, limit_s):
    ends = []
    for one in running:
        try:
            ends.append(os.pidfd_open(one.pid))
        except ProcessLookupError:
            pass
    wait_for_descriptors(ends, limit_s)
    for end in ends:
        os.close(end)


def _below(root, place):
    """Paths below a folder of a computer, on the same file system."""
    found, unread = set(), [place]
    device = None
    while unread:
        folder = unread.pop()
        try:
            status = os.stat(root + folder)
            device = device or status.st_dev
            entries = list(os.scandir(root + folder)) if status.st_dev == device else []
        except OSError:
            continue  # It is gone meanwhile.
        for entry in entries:
            path = f"{folder}/{entry.name}"
            if path not in CLUSTERS_OWN:
                found.add(path)
                if entry.is_dir(follow_symlinks=False):
                    unread.append(path)
    return found


def files(first, private_tmp):
    """Files and sockets on computers, given their first processes: "n2:/tmp/x", "n2:@socket"."""
    found = set()
    for name, pid in first.items():
        is_login = name == "login"
        for place in (*PLACES, *SHARED):
            if is_login or place not in SHARED and (private_tmp or place != "/tmp"):
                found |= {f"{name}:{path}" for path in _below(f"/proc/{pid}/root", place)}
        for line in pathlib.Path(f"/proc/{pid}/net/unix").read_text().splitlines()[1:]:
            path = line.split()[7:]
            if path and path[0].startswith("@"):
                found.add(f"{name}:{path[0]}")
    return found
