#!/usr/bin/env python3
"""Random deaths at random moments: each run gives the same bits as an undisturbed one.

test_chaos.py BIN_DIR [--trials N] [--seed S]. A long run prints one line per trial, and at the end
the median time from a death to the next right answer.
"""
import argparse
import contextlib
import json
import os
import pathlib
import random
import resource
import select
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from pages import write_nrrd
from processes import children_of, name_of

TOPOLOGIES = ("default", "one-of-each", "paper-1993")
SIGNALS = (signal.SIGKILL, signal.SIGSTOP, signal.SIGSEGV)
SCENE = ("load phantom:pelvis", "surface skin iso=-300 opacity=0.5", "surface bone iso=250",
         "size 320x256")
# The work under which a node dies. `{}` is a folder.
MOMENTS = {"load": "load phantom:pelvis",
           "extraction": "surface bone iso=200",
           "orbit": "orbit 8",
           "export": "export {}/bone.ply surfaces=bone",
           "idle": None}
AFTER = ("surface skin iso=-300 opacity=0.5", "surface bone iso=250", "digest", "snapshot {}/p.png")
NODES = ("pxpl5-gp", "pxpl5-renderer", "pxpl5-framebuff")
# The work under which pxpl5-io dies. The request may fail, and nothing else.
IO_MOMENTS = {"load a file": "load {}/scan.nrrd",
              "export": "export {}/old.ply surfaces=bone",
              "orbit": "orbit 8 {}/o{{}}.png",
              "snapshot": "snapshot {}/s.png"}
IO_SIZE = 96  # Voxels per edge of the file: some milliseconds of reading.
LONGEST_IO_WORK_S = 0.03
LONGEST_WORK_S = 0.3  # Deaths are spread over this time after the command.
DEADLINE_S = 60
LIVELY = ("--set", "heartbeat.interval_ms=100", "--set", "heartbeat.misses=20")


class Failure(Exception):
    pass


class Host:
    """`pxpl5 run --json -`."""

    def __init__(self, binaries, folder, topology, *flags):
        self.folder = folder
        self.errors = open(folder / "errors", "w+", encoding="utf-8")
        self.process = subprocess.Popen(
            [binaries / "pxpl5", "run", "--json", "--topology", topology, "--run-folder",
             folder / "run", *LIVELY, *flags, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=self.errors, env={**os.environ, "XDG_RUNTIME_DIR": str(folder)},
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)))
        self.unread = b""

    def say(self, line):
        self.process.stdin.write((line + "\n").encode())
        self.process.stdin.flush()

    def answer(self):
        """The next reply; none if the program has ended."""
        deadline = time.monotonic() + DEADLINE_S
        while b"\n" not in self.unread:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([self.process.stdout], [], [], left)[0]:
                raise Failure(f"no answer within {DEADLINE_S} s")
            part = os.read(self.process.stdout.fileno(), 1 << 16)
            if not part:
                return None
            self.unread += part
        line, self.unread = self.unread.split(b"\n", 1)
        return json.loads(line)

    def wait_for_answer(self, seconds):
        """Until an answer comes, but at most so long."""
        select.select([self.process.stdout], [], [], seconds)

    def ask(self, line):
        self.say(line)
        return self.answer()

    def nodes(self):
        return [pid for pid in children_of(self.process.pid) if name_of(pid) in NODES]

    def ios(self):
        """Its pxpl5-io, as soon as there is one or an answer."""
        deadline = time.monotonic() + DEADLINE_S
        while time.monotonic() < deadline:
            found = [pid for pid in children_of(self.process.pid) if name_of(pid) == "pxpl5-io"]
            if found or select.select([self.process.stdout], [], [], 0)[0]:
                return found
        raise Failure("neither pxpl5-io nor an answer")

    def parts(self):
        """Files that are being written."""
        return [name for name in os.listdir(self.folder) if ".part" in name]

    def wait_for_part(self):
        """Until a file is being written, or the answer is there."""
        deadline = time.monotonic() + DEADLINE_S
        while (time.monotonic() < deadline and not self.parts() and
               not select.select([self.process.stdout], [], [], 0)[0]):
            pass

    def end(self):
        """Exit code. Raises Failure if a process or a socket is left."""
        children = children_of(self.process.pid)
        self.process.stdin.close()
        try:
            code = self.process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired as slow:
            raise Failure(f"the program does not end within {DEADLINE_S} s") from slow
        left = [pid for pid in children if pathlib.Path(f"/proc/{pid}").exists()]
        sockets = list(self.folder.glob("pxpl5-*"))
        if left or sockets:
            raise Failure(f"processes {left} and sockets {sockets} are left")
        return code

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.errors.close()


def digests_of(answers):
    """What must be equal whatever has died."""
    return [answer["result"] for answer in answers if answer["name"] == "digest"]


def undisturbed(binaries):
    """Digests, mesh and picture of a run without deaths, on the smallest machine."""
    with tempfile.TemporaryDirectory(prefix="pxpl5-chaos-") as name:
        folder = pathlib.Path(name)
        host = Host(binaries, folder, "one-of-each")
        try:
            lines = [*SCENE, MOMENTS["export"], *AFTER]
            answers = [host.ask(line.format(folder)) for line in lines]
            if not all(answer["ok"] for answer in answers) or host.end() != 0:
                raise Failure(f"the undisturbed run fails: {answers}")
            return (digests_of(answers), (folder / "bone.ply").read_bytes(),
                    (folder / "p.png").read_bytes())
        finally:
            host.kill()


def check_answer(answer):
    """A command works, although a node has died."""
    if answer is None:
        raise Failure("the program has ended without an answer")
    if not answer["ok"]:
        raise Failure(f"{answer['command']}: {answer['error']}")


def disturb(host, chance, number):
    """Sends the signal to a node. Returns the node's name."""
    nodes = sorted(host.nodes())
    victim = chance.choice(nodes)
    name = name_of(victim)
    os.kill(victim, number)
    return name


def trial(binaries, seed, expected):
    """Returns a line about the trial, and the seconds from the death to the next right answer."""
    chance = random.Random(seed)
    topology, number = chance.choice(TOPOLOGIES), chance.choice(SIGNALS)
    moment = chance.choice(tuple(MOMENTS))
    with tempfile.TemporaryDirectory(prefix="pxpl5-chaos-") as name:
        folder = pathlib.Path(name)
        host = Host(binaries, folder, topology)
        try:
            for line in SCENE:
                if not host.ask(line)["ok"]:
                    raise Failure(f"{line} fails before any death")
            if MOMENTS[moment]:
                host.say(MOMENTS[moment].format(folder))
                host.wait_for_answer(chance.uniform(0, LONGEST_WORK_S))
            victim, died = disturb(host, chance, number), time.monotonic()
            answers = [host.answer()] if MOMENTS[moment] else []
            answers += [host.ask(line.format(folder)) for line in AFTER[:3]]
            seconds = time.monotonic() - died
            answers.append(host.ask(AFTER[3].format(folder)))
            for answer in answers:
                check_answer(answer)
            digests, mesh, picture = expected
            code = host.end()
            if code != 0:
                raise Failure(f"exit code {code}")
            if digests_of(answers) != digests or (folder / "p.png").read_bytes() != picture:
                raise Failure("the picture or a mesh differs")
            if moment == "export" and (folder / "bone.ply").read_bytes() != mesh:
                raise Failure("the exported mesh differs")
            restarts = sum(len(answer.get("restarts", [])) for answer in answers)
            strays = [path.name for path in folder.iterdir()
                      if path.name not in ("run", "errors", "p.png") and
                      not path.name.startswith("bone.ply")]
            if strays:
                raise Failure(f"files are left: {strays}")
            return (f"{seed}: {topology}, {moment}, {number.name} to {victim}: {restarts} "
                    f"restart(s), right after {seconds:.2f} s", seconds, restarts)
        except Failure as failure:
            raise Failure(f"seed {seed}: {topology}, {moment}, {number.name}: {failure}\n"
                          f"{(folder / 'errors').read_text()}") from failure
        finally:
            host.kill()


def check_io_answer(answer):
    """The request works, or its error names the process and how it has died."""
    if answer is None:
        raise Failure("the program has ended without an answer")
    if not answer["ok"] and "io-" not in answer["error"] and "pxpl5-io" not in answer["error"]:
        raise Failure(f"{answer['command']}: the error does not name pxpl5-io: {answer['error']}")


def io_trial(binaries, seed, expected):
    """Returns a line about the trial, and whether a request has failed."""
    chance = random.Random(seed)
    number, moment = chance.choice(SIGNALS), chance.choice(tuple(IO_MOMENTS))
    digests, mesh, picture = expected
    with tempfile.TemporaryDirectory(prefix="pxpl5-chaos-") as name:
        folder = pathlib.Path(name)
        write_nrrd(folder / "scan.nrrd", IO_SIZE, 30)
        host = Host(binaries, folder, "one-of-each", "--keep-going")
        try:
            for line in (*SCENE, "export {}/old.ply surfaces=skin"):
                check_answer(host.ask(line.format(folder)))
            old = (folder / "old.ply").read_bytes()
            host.say(IO_MOMENTS[moment].format(folder))
            if chance.random() < 0.5 and moment != "load a file":
                host.wait_for_part()
            else:
                host.wait_for_answer(chance.uniform(0, LONGEST_IO_WORK_S))
            for victim in host.ios():
                # It may have ended meanwhile, and its number may even belong to another program.
                if name_of(victim) == "pxpl5-io":
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(victim, number)
            answer = host.answer()
            check_io_answer(answer)
            if host.parts():
                raise Failure(f"unfinished files are left: {host.parts()}")
            if (folder / "old.ply").read_bytes() not in (old, mesh):
                raise Failure("the exported mesh is neither the old nor the new one")
            after = []
            for line in (*SCENE, *AFTER):
                after.append(host.ask(line.format(folder)))
                check_answer(after[-1])
            host.end()  # Its exit code is that of the failed request.
            if digests_of(after) != digests or (folder / "p.png").read_bytes() != picture:
                raise Failure("the picture or a mesh differs")
            return (f"{seed}: pxpl5-io, {moment}, {number.name}: {answer.get('error', 'done')}",
                    not answer["ok"])
        except Failure as failure:
            raise Failure(f"seed {seed}: pxpl5-io, {moment}, {number.name}: {failure}\n"
                          f"{(folder / 'errors').read_text()}") from failure
        finally:
            host.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("binaries", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--trials", type=int, default=15)
    parser.add_argument("--io-trials", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    expected = undisturbed(options.binaries)
    times, restarts, failures = [], 0, []
    for seed in range(options.seed, options.seed + options.trials):
        try:
            line, seconds, count = trial(options.binaries, seed, expected)
        except Failure as failure:
            failures.append(str(failure))
            print(f"FAILED {failure}", flush=True)
            continue
        print(line, flush=True)
        restarts += count
        times.append(seconds)
    print(f"{options.trials} trials: {len(times)} right, {len(failures)} failed, "
          f"{restarts} restarts; median {statistics.median(times or [0]):.2f} s from the "
          "death to the next right picture")
    if restarts == 0:
        failures.append("no trial has met a death: the test checks nothing")
    met = 0
    for seed in range(options.seed, options.seed + options.io_trials):
        try:
            line, has_failed = io_trial(options.binaries, seed, expected)
        except Failure as failure:
            failures.append(str(failure))
            print(f"FAILED {failure}", flush=True)
            continue
        print(line, flush=True)
        met += has_failed
    print(f"{options.io_trials} deaths of pxpl5-io: {met} requests failed")
    if options.io_trials > 5 and met == 0:
        failures.append("no request has met the death of pxpl5-io: the test checks nothing")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
