#!/usr/bin/env python3
"""A cluster of computers on this one: namespaces with real Slurm, munge, sshd and OpenMPI.

usage: cluster.py [--computers N] [--on NAME] [--user NAME] [COMMAND...]

Runs a command, or a shell, on a cluster that ends with it. README.md describes the class Cluster.
"""
import argparse
import dataclasses
import json
import os
import pathlib
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))
import configuration as conf  # noqa: E402
import contents  # noqa: E402
import kernel  # noqa: E402
from configuration import LOGIN, OTHER_USER, USER  # noqa: E402, F401
from program import Program  # noqa: E402

LIMIT_S = 60
LOG_LINES = 15
PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
PACKAGES = {"slurmctld": "slurmctld", "slurmd": "slurmd", "srun": "slurm-client",
            "munged": "munge", "sshd": "openssh-server", "ssh": "openssh-client",
            "mpirun": "openmpi-bin", "ip": "iproute2", "nsenter": "util-linux"}
PROBE = "link add br0 type bridge\nlink add v0 type veth peer name v1\n"


class ClusterError(Exception):
    """What failed, on which computer, and the last lines of its log."""


def _user_id():
    """The user of the cluster owns the repository, to be sure to read it; or is a stranger."""
    return ROOT.stat().st_uid or 2001


def _closed_to(user_id, path):
    """The first folder on the way to `path` that the user may not enter, or None."""
    for folder in [*reversed(path.parents), path]:
        status = folder.stat()
        if not status.st_mode & (0o100 if status.st_uid == user_id else 0o001):
            return folder
    return None


def missing(paths=(ROOT,)):
    """Why this machine cannot have a cluster, in a sentence; "" if it can."""
    if os.geteuid() != 0:
        return "only root can make the namespaces of a cluster; run it with sudo"
    packages = sorted({package for command, package in PACKAGES.items()
                       if not shutil.which(command, path=PATH)})
    if packages:
        return f"{', '.join(packages)} not installed; host/setup.sh cluster installs the packages"
    closed = next(filter(None, (_closed_to(_user_id(), pathlib.Path(path)) for path in paths)), "")
    if closed:
        return f"other users may not enter {closed}; the cluster's programs run as one"
    probe = subprocess.run(["unshare", "-m", "-u", "-i", "-n", "-p", "--fork", "ip", "-batch", "-"],
                           input=PROBE, capture_output=True, text=True, timeout=LIMIT_S,
                           check=False)
    if probe.returncode:
        return f"this machine refuses namespaces or bridges: {probe.stderr.strip()}"
    return ""


class Cluster:
    """A login computer and n1, n2, ... with a network of their own; root alone can make it.

    `with Cluster(computers=3) as cluster:` starts it; when the block ends, or this process,
    everything in the cluster ends, and no file of it is left. Each keyword is optional:

    computers         how many there are beside the login computer
    slots             processes that Slurm places on a computer
    private_tmp       False: all computers share one /tmp
    tmp_mb            size of /tmp, in MiB
    hosts_as_debian   each computer's own name has the address 127.0.1.1 there
    noisy_bashrc      .bashrc writes to stdout and stderr, also for commands that come by ssh
    slurm_conf        further lines of slurm.conf
    shared            folders, beside the repository, that each computer sees, even below /tmp
    writable          folders of this machine that programs of the cluster may change
    wire              the program of wire.cpp: link() takes delays and losses then
    seed              of the losses and jitter of the wire
    """

    def __init__(self, shared=(), writable=(), wire="", **options):
        wire = [pathlib.Path(wire).resolve()] if wire else []
        folders = [[str(pathlib.Path(path).resolve()) for path in paths] for paths in
                   ((ROOT, *shared, *writable, *(path.parent for path in wire)), writable)]
        self.options = conf.Options(user_id=_user_id(), shared=folders[0], writable=folders[1],
                                    wire="".join(map(str, wire)), **options)
        if not 1 <= self.options.computers <= conf.MOST_COMPUTERS:
            raise ValueError(f"a cluster has 1 to {conf.MOST_COMPUTERS} computers, "
                             f"not {self.options.computers}")
        self.names = [LOGIN, *self.options.names()]
        self._first = {}      # The first process of each computer that is on, as a pid.
        self._is_up = set()
        self._programs = []
        self._own = set()     # What the cluster itself consists of, of processes() and files().
        self._log = None

    def __enter__(self):
        self._control, inner = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        self._output = os.memfd_create("cluster")
        with inner:
            self._guardian = subprocess.Popen(
                [sys.executable, "-I", "-B", HERE / "computer.py", str(inner.fileno()),
                 json.dumps(dataclasses.asdict(self.options))],
                pass_fds=[inner.fileno()], start_new_session=True, stdin=subprocess.DEVNULL,
                stdout=self._output, stderr=self._output, cwd="/",
                env={"PATH": PATH, "LANG": "C.UTF-8"})
        try:
            self._wait_for(self.names)
        except BaseException:
            self.down()
            raise
        return self

    def __exit__(self, *_):
        self.down()

    def down(self):
        """Ends the cluster. Returns when no process of it is left."""
        if LOGIN in self._first:
            self._kill(LOGIN)  # All others live in its process namespace.
        self._control.close()  # Ends a login computer that has not reported yet.
        try:
            self._guardian.wait(LIMIT_S)
        finally:
            for program in self._programs:
                program.end()
            for descriptor in filter(None, (self._log, self._output)):
                os.close(descriptor)
            self._first, self._programs, self._log, self._output = {}, [], None, None

    def login(self, argv, **more):
        """on("login", argv)."""
        return self.on(LOGIN, argv, **more)

    def on(self, computer, argv, *, check=True, timeout=LIMIT_S, input=None, **more):
        """Runs a command and returns its subprocess.CompletedProcess, with texts.

        ClusterError has its output if it fails and `check` is true, or after `timeout` seconds.
        For user, env and cwd see popen().
        """
        streams = {"stdin": subprocess.DEVNULL if input is None else subprocess.PIPE,
                   "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        program = self.popen(computer, argv, **{**streams, **more})
        command = " ".join(map(str, argv))
        try:
            out, errors = program.communicate(input, timeout)
        except subprocess.TimeoutExpired as error:
            said = b"".join(filter(None, (error.stdout, error.stderr))).decode(errors="replace")
            raise ClusterError(f"{computer}: {command}: not done after {timeout} s"
                               f"{self._tail(said)}") from None
        finally:
            program.end()
            self._programs.remove(program)
        if check and program.returncode:
            raise ClusterError(f"{computer}: {command}: code {program.returncode}"
                               f"{self._tail(out + errors)}")
        return subprocess.CompletedProcess(argv, program.returncode, out, errors)

    def popen(self, computer, argv, *, user=USER, env=None, cwd=None, **more):
        """Starts a program and returns a subprocess.Popen, whose signals reach the program.

        user    "ada", "eve" or "root"
        env     variables beside those of a login shell
        cwd     folder, beside the user's home
        more    arguments of subprocess.Popen
        """
        if computer not in self._first:
            raise ClusterError(f"{computer} is not on; on are "
                               + " ".join(filter(self._first.get, self.names)))
        home = str(conf.home(user))
        variables = {"HOME": home, "USER": user, "LOGNAME": user, "SHELL": "/bin/bash",
                     "PATH": PATH, "LANG": "C.UTF-8", **(env or {})}
        more.setdefault("start_new_session", True)
        self._programs.append(Program(self._first[computer], argv, user, cwd or home,
                                      env=variables, **more))
        return self._programs[-1]

    def off(self, computer):
        """Power failure: no packet leaves the computer, and every process on it ends at once."""
        self.cut(computer)
        self._kill(computer)
        del self._first[computer]
        self._is_up.discard(computer)

    def boot(self, computer):
        """Starts a computer that is off, and waits until Slurm uses it again."""
        self._control.send(json.dumps({"boot": computer}).encode())
        self._wait_for([computer])

    def cut(self, computer):
        """Drops every packet to and from the computer. Neither end notices anything else."""
        self._set_port(computer, "cut", 0)

    def join(self, computer):
        """Ends what cut() does."""
        self._set_port(computer, "join", 3)

    def link(self, *computers, rate_mbit=0, delay_ms=0, jitter_ms=0, loss_percent=0):
        """Sets the cables of these computers, or of all, for both ways. A rate of 0 is no limit.

        A packet between two computers passes two cables, and has the delay of both.
        """
        for name in computers or self.names:
            if self.options.wire:
                self._ask_wire(f"set {name} {round(1000 * delay_ms)} {round(1000 * jitter_ms)} "
                               f"{round(10000 * loss_percent)} {rate_mbit}")
            elif delay_ms or jitter_ms or loss_percent:
                raise ClusterError("a cluster without a wire has no delay, jitter and loss; "
                                   "give Cluster(wire=) the program of wire.cpp")
            else:
                self._limit(name, rate_mbit)

    def _limit(self, name, rate_mbit):
        limit = ["tbf", "rate", f"{rate_mbit}mbit", "burst", "256k", "latency", "100ms"]
        change, limit = ("replace", limit) if rate_mbit else ("del", [])
        for place, device in ((LOGIN, f"v{name}"), (name, "eth0")):
            self.on(place, ["tc", "qdisc", change, "dev", device, "root", *limit],
                    user="root", check=bool(rate_mbit))

    def processes(self):
        """Running processes of the cluster, but not those of which it consists."""
        return [one for one in contents.processes(self._first) if one.key not in self._own]

    def own_processes(self):
        """The processes of which the cluster itself consists, such as its daemons."""
        return [one for one in contents.processes(self._first) if one.key in self._own]

    def path(self, computer, path):
        """A path of the computer, as this process can open it."""
        return pathlib.Path(f"/proc/{self._first[computer]}/root{path}")

    def wait_until_idle(self, limit_s=LIMIT_S):
        """Returns when processes() is empty. ClusterError has those that are left."""
        end = time.monotonic() + limit_s
        while left := self.processes():
            if time.monotonic() > end:
                raise ClusterError(f"after {limit_s} s, there are still: "
                                   + "; ".join(map(str, left)))
            contents.wait_for(left, end - time.monotonic())

    def files(self):
        """Files, folders and sockets that have appeared: ["n2:/tmp/x", "n2:@abstract socket"].

        Those of /tmp, /var/tmp, /dev/shm, /run and /home. All computers share /home.
        """
        found = contents.files(self._first, self.options.private_tmp)
        return sorted(found - self._own)

    def log(self, computer, daemon):
        """The log of munged, sshd, slurmd or slurmctld, also of a computer that is off."""
        path = pathlib.Path(f"/proc/self/fd/{self._log}/{computer}.{daemon}.log")
        return path.read_text(errors="replace") if path.exists() else ""

    def _tail(self, text):
        lines = text.strip().splitlines()[-LOG_LINES:]
        return ":\n    " + "\n    ".join(lines) if lines else ", and wrote nothing"

    def _kill(self, computer):
        try:
            ends = os.pidfd_open(self._first[computer])
        except ProcessLookupError:
            return
        signal.pidfd_send_signal(ends, signal.SIGKILL)
        contents.wait_for_descriptors([ends], LIMIT_S)
        os.close(ends)

    def _set_port(self, computer, request, state):
        if self.options.wire:
            self._ask_wire(f"{request} {computer}")
        else:
            self.login(["bridge", "link", "set", "dev", f"v{computer}", "state", str(state)],
                       user="root")

    def _ask_wire(self, request):
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as wire:
            wire.settimeout(LIMIT_S)
            wire.connect(f"/proc/{self._first[LOGIN]}/root{conf.WIRE}")
            wire.send(request.encode())
            reply = wire.recv(256).decode()
        if reply != "ok":
            raise ClusterError(f"{self.options.wire}: {request}: {reply}")

    def _wait_for(self, names):
        """Returns when these computers are up and, but the login computer, idle in Slurm."""
        end = time.monotonic() + LIMIT_S
        while set(names) - self._is_up:
            self._take_report(names, end)
        slurm = set(names) - {LOGIN}
        ask = ["sinfo", "-h", "-N", "-t", "idle", "-o", "%N"]
        # Slurm logs most of what it does; a tenth of a second is for the rest.
        with kernel.Watch(f"/proc/self/fd/{self._log}/{LOGIN}.slurmctld.log") as watch:
            while slurm - set(self.login(ask, user="root", check=False).stdout.split()):
                if time.monotonic() > end:
                    raise ClusterError(f"Slurm did not see {' '.join(sorted(slurm))} within "
                                       f"{LIMIT_S} s{self._tail(self.log(LOGIN, 'slurmctld'))}")
                watch.wait(0.1, self._control)
                if select.select([self._control], [], [], 0)[0]:
                    self._take_report(names, end)
        self._own |= {one.key for one in self.processes() if one.computer in names}
        self._own |= contents.files({name: self._first[name] for name in names},
                                    self.options.private_tmp)

    def _take_report(self, names, end):
        """Waits for one report of a computer. The kernel adds the pid of its first process.

        A daemon that ends is an error while its computer, one of `names`, starts.
        """
        self._control.settimeout(max(0.001, end - time.monotonic()))
        try:
            data, extra, _, _ = self._control.recvmsg(1 << 16, socket.CMSG_SPACE(12))
        except TimeoutError:
            late = " ".join(sorted(set(self.names) - self._is_up))
            raise ClusterError(f"{late}: not up within {LIMIT_S} s{self._said()}") from None
        if not data:
            raise ClusterError(f"the login computer has ended{self._said()}")
        report = json.loads(data)
        name = report["computer"]
        self._first[name] = struct.unpack("3i", extra[0][2])[0]
        if self._log is None:  # All computers have the folder.
            self._log = os.open(f"/proc/{self._first[name]}/root{conf.CLUSTER}/log", os.O_PATH)
        if "failed" in report:
            raise ClusterError(f"{name}: {report['failed']}")
        if "ended" in report and name in names:
            raise ClusterError(f"{name}: {report['ended']} has ended with code {report['code']}"
                               f"{self._tail(self.log(name, report['ended']))}")
        if "up" in report:
            self._is_up.add(name)

    def _said(self):
        return self._tail(os.pread(self._output, 1 << 16, 0).decode(errors="replace"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--computers", type=int, default=3)
    parser.add_argument("--on", default=LOGIN, help="the computer; login unless given")
    parser.add_argument("--user", default=USER)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    words = parser.parse_args()
    reason = missing()
    if reason:
        sys.exit(f"cluster.py: {reason}")
    with Cluster(computers=words.computers) as cluster:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # It is for the command.
        terminal = {"TERM": os.environ.get("TERM", "dumb")}
        sys.exit(cluster.popen(words.on, words.command or ["bash"], user=words.user, env=terminal,
                               start_new_session=False).wait())


if __name__ == "__main__":
    main()
