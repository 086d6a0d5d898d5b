"""Machines of pxpl5 on a cluster, for tests. The first argument of such a test is BIN."""
import json
import pathlib
import queue
import re
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import contents  # noqa: E402
from cluster import Cluster  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
PXPL5 = str(BIN / "pxpl5")
LIMIT_S = 120
NAMES = "n1,n2,n3"
SSH = ("--engine", "ssh", "--computers", NAMES)
SLURM = ("--engine", "slurm")
MPIRUN = ("--engine", "mpirun", "--computers", NAMES)
IN_JOB = ("salloc", "--quiet", "-N3", "-n3")
SPREAD = ("--set", "placement=spread")
ENDS = tuple(word for role in ("gp", "renderer", "frame_buffer")
             for word in ("--set", f"{role}.restart.policy=end"))
FOUR_GPS = ("--set", "gp.count=4", "--set", "renderer.count=3")


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(each) for key, each in value.items()
                if not key.endswith("_ms")}
    return [without_times(each) for each in value] if isinstance(value, list) else value


def results(out):
    replies = [json.loads(line) for line in out.splitlines()]
    return [without_times(reply["result"]) if reply["ok"] else reply["error"]
            for reply in replies]


def new_cluster(**more):
    return Cluster(computers=3, slots=64, hosts_as_debian=True, noisy_bashrc=True, shared=[BIN],
                   **more)


class Dialog:
    """A program at its prompt. Threads read what it writes, so that every wait has a deadline."""

    def __init__(self, program):
        self.program = program
        self.out, self.notes, self.said = queue.Queue(), queue.Queue(), []
        self.readers = [threading.Thread(target=self._read, args=pair, daemon=True) for pair in
                        ((program.stdout, self.out), (program.stderr, self.notes))]
        for reader in self.readers:
            reader.start()

    @staticmethod
    def _read(stream, lines):
        for line in stream:
            lines.put(line)
        lines.put("")

    def ask(self, line, limit_s=LIMIT_S):
        """The reply to a command, as JSON."""
        self.program.stdin.write(f"{line}\n")
        self.program.stdin.flush()
        reply = self.out.get(timeout=limit_s)
        return json.loads(reply) if reply else {"ok": False, "error": "ended"}

    def result(self, line, limit_s=LIMIT_S):
        reply = self.ask(line, limit_s)
        if not reply["ok"]:
            raise AssertionError(f"{line}: {reply['error']}\n{''.join(self.said)}")
        return without_times(reply["result"])

    def note(self, pattern):
        """Waits for a line on standard error."""
        end = time.monotonic() + LIMIT_S
        while line := self.notes.get(timeout=max(0, end - time.monotonic())):
            self.said.append(line)
            if found := re.search(pattern, line):
                return found
        raise AssertionError(f"ended without {pattern}:\n{''.join(self.said)}")

    def end(self):
        """Ends the input. Returns exit code and standard error."""
        self.program.stdin.close()
        code = self.program.wait(LIMIT_S)
        while line := self.notes.get(timeout=LIMIT_S):
            self.said.append(line)
        return code, "".join(self.said)


class OnACluster(unittest.TestCase):
    """Machines on `self.cluster`."""

    def run_lines(self, lines, *words, before=(), check=True):
        return self.cluster.login([*before, PXPL5, "run", "--json", "--run-folder", "runs", *words,
                                   "-c", "; ".join(lines)], check=check, timeout=LIMIT_S)

    def popen_machine(self, *words, before=()):
        return self.cluster.popen(
            "login", [*before, PXPL5, "run", "--json", "--run-folder", "runs", *words, "-"],
            stdin=-1, stdout=-1, stderr=-1, text=True)

    def dialog(self, *words, before=()):
        machine = Dialog(self.popen_machine(*words, before=before))
        self.addCleanup(machine.program.end)
        return machine

    def start(self, *words, before=(), lines=("load phantom:sphere", "surface s iso=0")):
        """A machine at its prompt, after the replies to `lines`."""
        machine = self.popen_machine(*words, before=before)
        machine.stdin.write("".join(f"{line}\n" for line in lines))
        machine.stdin.flush()
        for line in lines:
            reply = json.loads(machine.stdout.readline() or '{"ok": false, "error": "ended"}')
            self.assertTrue(reply["ok"], f"{line}: {reply}")
        return machine

    def end_of(self, machine, line="digest"):
        out, complaint = machine.communicate(f"{line}\n", timeout=LIMIT_S)
        return machine.returncode, out, complaint

    def programs(self, name, computer=None):
        """Running programs of pxpl5 whose command line has `name`."""
        return [each for each in self.cluster.processes()
                if name in str(each) and computer in (None, each.computer)]

    def wait_until_ended(self, name, computer=None):
        while left := self.programs(name, computer):
            contents.wait_for(left, LIMIT_S)

    def wait_until_no_node_runs(self):
        self.wait_until_ended("pxpl5")
