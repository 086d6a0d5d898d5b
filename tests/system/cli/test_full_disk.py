#!/usr/bin/env python3
"""Disks that are full at a random byte, or have no room for another file: each command writes what
it writes on an empty disk, or its error names the file, and the earlier file is whole.

test_full_disk.py BIN_DIR [--seed S]. PXPL5_CHAOS_SEEDS is the number of seeds.

The disk is a small tmpfs, in a mount namespace of this test.
"""
import argparse
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

from test_chaos import Failure, Host, check_answer

USUAL_SEEDS = 40
DISK_BYTES, DISK_FILES = 16 << 20, 200
PAGE = 4096  # A tmpfs counts in pages.
NO_ROOM = "No space left on device"
SCENE = ("load phantom:sphere", "surface a iso=0.5", "surface b iso=0.3 opacity=0.5",
         "size 160x128", "stereo rows")
PROGRAM = "SETENABS\nCONSTintoMEM m64:24 0x401008\n" * 200

# Commands of a session, and the files that each one writes. `{}` is the disk.
WRITERS = {f"snapshot {{}}/f{suffix}": (f"f{suffix}",)
           for suffix in (".png", ".tif", ".exr", ".gif", ".jps", ".mpo")}
WRITERS |= {f"export {{}}/f{suffix}": (f"f{suffix}", f"f{suffix}.certificate.json")
            for suffix in (".stl", ".ply", ".vtp", ".glb")}
WRITERS |= {
    "export {}/f.obj": ("f.obj", "f.mtl", "f.obj.certificate.json"),
    "export {}/f.ply keep=0.5": ("f.ply", "f.ply.certificate.json"),
    "orbit 3 {}/o{{}}.png": ("o0000.png", "o0001.png", "o0002.png"),
    "orbit 3 {}/o.gif": ("o.gif",),
    "sweep a 0.3 0.6 3 {}/s{{}}.tif": ("s0000.tif", "s0001.tif", "s0002.tif"),
    "slice z 10 {}/f.png": ("f.png",),
    "atlas {}/f.png steps=8": ("f.png",),
    "history {}/scene.txt form=scene": ("scene.txt",)}
# Tools without a machine.
TOOLS = {("exec", "{program}", "--picture", "rgb", "-o", "{disk}/f.png"): ("f.png",),
         ("asm", "{program}", "--hex", "-o", "{disk}/f.hex"): ("f.hex",),
         ("trace", "dump", "{run}", "-o", "{disk}/f.jsonl"): ("f.jsonl",)}


# Files that appear together, because one refers to the other.
PAIR = ("f.obj", "f.mtl")
# The time in the head of a TIFF or EXR file.
TIME = re.compile(rb"\d{4}:\d\d:\d\d \d\d:\d\d:\d\d")


class Disk:
    """A small disk that becomes full on order."""

    def __init__(self, place):
        self.place = place
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES},nr_inodes={DISK_FILES}",
                        "none", place], check=True)

    def files(self):
        return {path.name: TIME.sub(b"", path.read_bytes()) for path in self.place.iterdir()}

    def empty(self):
        for path in self.place.iterdir():
            path.unlink()

    def fill_bytes(self, left):
        """Leaves room for so many bytes, in pages."""
        free = os.statvfs(self.place)
        with open(self.place / "filler", "wb") as filler:
            bytes_to_fill = free.f_bavail * free.f_frsize - left // PAGE * PAGE
            os.posix_fallocate(filler.fileno(), 0, max(bytes_to_fill, PAGE))

    def fill_names(self, left):
        """Leaves room for so many files."""
        for n in range(os.statvfs(self.place).f_ffree - left):
            (self.place / f"filler{n}").touch()

    def free(self):
        for filler in self.place.glob("filler*"):
            filler.unlink()


def undisturbed(session, disk):
    """The files of each command on an empty disk."""
    written = {}
    for command, names in session.commands.items():
        error = session.run(command)
        if error:
            raise Failure(f"{command}: fails on an empty disk: {error}")
        written[command] = disk.files()
        if sorted(written[command]) != sorted(names):
            raise Failure(f"{command}: writes {sorted(written[command])}, not {sorted(names)}")
        disk.empty()
    return written


class Session:
    """Writes from one program with a machine."""

    commands = WRITERS

    def __init__(self, host, disk):
        self.host, self.disk = host, disk
        for line in SCENE:
            check_answer(host.ask(line))
        self.digest = self.ask_digest()

    def ask_digest(self):
        answer = self.host.ask("digest")
        check_answer(answer)
        return answer["result"]

    def run(self, command):
        """The error; none if there is none."""
        answer = self.host.ask(command.format(self.disk.place))
        if answer is None:
            raise Failure("the program has ended without an answer")
        return None if answer["ok"] else answer["error"]

    def check_next(self):
        if self.ask_digest() != self.digest:
            raise Failure("the next digest differs")


class Tools:
    """Writes from programs of their own."""

    commands = TOOLS

    def __init__(self, binaries, disk, **places):
        self.binaries, self.disk, self.places = binaries, disk, places

    def run(self, command):
        words = [word.format(disk=self.disk.place, **self.places) for word in command]
        done = subprocess.run([self.binaries / "pxpl5", *words], capture_output=True, text=True,
                              timeout=60, check=False)
        if done.returncode == 0:
            return None
        return done.stderr or f"no error, exit code {done.returncode}"

    def check_next(self):
        pass


def check_error(error, command, disk, missing):
    """The error names a file that is not there, and why."""
    if NO_ROOM not in error:
        raise Failure(f"{command}: the error does not name the reason: {error}")
    if not any(str(disk.place / name) in error for name in missing):
        raise Failure(f"{command}: the error names none of {missing}: {error}")


def trial(session, disk, chance, expected):
    """Returns the error; none if the command has succeeded."""
    disk.empty()  # A trial before may have failed.
    command = chance.choice(sorted(session.commands, key=str))
    names = session.commands[command]
    earlier = {name: f"earlier {name}".encode() for name in names if chance.random() < 0.5}
    for name, content in earlier.items():
        (disk.place / name).write_bytes(content)
    if chance.random() < 0.7:
        needed = sum(len(content) + PAGE for content in expected[command].values())
        disk.fill_bytes(chance.randrange(needed))
    else:
        disk.fill_names(chance.randrange(len(names) + 1))
    error = session.run(command)
    disk.free()
    there = disk.files()
    missing = [name for name in names if there.get(name) != expected[command][name]]
    if error is None and missing:
        sizes = {name: (len(there.get(name, b"")), len(expected[command][name]))
                 for name in missing}
        raise Failure(f"{command}: succeeds, but bytes differ from those on an empty disk: {sizes}")
    if error is not None:
        check_error(error, command, disk, missing)
    for name in missing:
        if there.get(name) != earlier.get(name):
            raise Failure(f"{command}: {name} is neither the earlier nor the new file: {error}")
    if set(PAIR) <= set(names) and len(set(PAIR) & set(missing)) == 1:
        raise Failure(f"{command}: one of {PAIR} is new, the other is not: {error}")
    strays = sorted(set(there) - set(names))
    if strays:
        raise Failure(f"{command}: {strays} are left: {error}")
    session.check_next()
    if session.run(command) is not None or disk.files() != expected[command]:
        raise Failure(f"{command}: differs when the disk has room again")
    return error


class RunFolder:
    """A program whose run folder lies on the disk."""

    def __init__(self, binaries, host, disk):
        self.binaries, self.host, self.disk = binaries, host, disk
        for line in (*SCENE, "digest"):
            check_answer(host.ask(line))
        self.run, = disk.place.iterdir()

    def ask(self, command):
        """What the answer complains about; none if nothing."""
        answer = self.host.ask(command)
        if answer is None:
            raise Failure("the program has ended without an answer")
        return " ".join([answer.get("error", ""), *answer.get("warnings", [])]).strip() or None

    def save(self):
        """Saves traces, which can be executed again. Returns their bytes."""
        error = self.ask("trace save")
        if error:
            raise Failure(f"trace save: {error}")
        return self.traces()

    def traces(self):
        done = subprocess.run([self.binaries / "pxpl5", "trace", "replay", self.run], check=False,
                              capture_output=True, text=True, timeout=120)
        if done.returncode != 0:
            raise Failure(f"the traces cannot be executed again: {done.stdout}{done.stderr}")
        return {path.name: path.read_bytes() for path in self.run.rglob("*.mcap*")}


def run_folder_trial(side, chance):
    """Returns the error; none if the command has succeeded."""
    picture = side.disk.place.parent / "picture.png"
    command = chance.choice(("trace save", f"snapshot {picture}"))
    earlier = side.save()
    if chance.random() < 0.7:
        side.disk.fill_bytes(chance.randrange(sum(map(len, earlier.values()))))
    else:
        side.disk.fill_names(chance.randrange(len(earlier) + 1))
    error = side.ask(command)
    side.disk.free()
    now = side.traces()
    if sorted(now) != sorted(earlier):
        raise Failure(f"{command}: there are {sorted(now)}, not {sorted(earlier)}: {error}")
    if error and (NO_ROOM not in error or str(side.run) not in error):
        raise Failure(f"{command}: the error names no file or no reason: {error}")
    error_of_next = side.ask(f"snapshot {picture}")
    if error_of_next:
        raise Failure(f"the next picture fails: {error_of_next}")
    side.save()
    return error


def has_namespace():
    """Whether this test has a mount namespace of its own: it starts itself again in one."""
    return os.environ.get("PXPL5_FULL_DISK") == "1"


def start_in_namespace():
    able = shutil.which("unshare") and subprocess.run(
        ["unshare", "-Urm", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True,
        check=False).returncode == 0
    if not able:
        print("SKIPPED: this system allows no mount namespaces (unshare -Urm)")
        return 0
    return subprocess.run(["unshare", "-Urm", sys.executable, "-B", *sys.argv], check=False,
                          env={**os.environ, "PXPL5_FULL_DISK": "1"}).returncode


def sides_of(options, folder, hosts):
    """Pairs of a chance and a trial."""
    disk = Disk(folder / "disk")
    program = folder / "program.pxasm"
    program.write_text(PROGRAM)
    runs = Disk(folder / "small/run")
    small = RunFolder(options.binaries, hosts.start(folder / "small"), runs)
    small.save()
    recorded = shutil.copytree(small.run, folder / "recorded")
    session = Session(hosts.start(folder), disk)
    tools = Tools(options.binaries, disk, program=program, run=recorded)
    expected = undisturbed(session, disk), undisturbed(tools, disk)
    return ((0.75, lambda chance: trial(session, disk, chance, expected[0])),
            (0.15, lambda chance: trial(tools, disk, chance, expected[1])),
            (0.1, lambda chance: run_folder_trial(small, chance)))


def run_trials(options, sides):
    count = int(os.environ.get("PXPL5_CHAOS_SEEDS", USUAL_SEEDS))
    failures, met = [], 0
    for seed in range(options.seed, options.seed + count):
        chance = random.Random(seed)
        run, = chance.choices([side for _, side in sides], [share for share, _ in sides])
        try:
            error = run(chance)
            met += error is not None
            print(f"{seed}: {error or 'done'}", flush=True)
        except Failure as failure:
            failures.append(seed)
            print(f"FAILED seed {seed}: {failure}", flush=True)
    print(f"{count} full disks: {met} commands failed by name, {len(failures)} trials failed")
    if count >= USUAL_SEEDS and met < count // 4:
        failures.append("few disks were full: the test checks little")
    return 1 if failures else 0


class Hosts:
    """The programs of this test, which end with it."""

    def __init__(self, binaries):
        self.binaries, self.started = binaries, []

    def start(self, folder):
        self.started.append(Host(self.binaries, folder, "one-of-each", "--keep-going"))
        return self.started[-1]

    def end(self):
        for host in self.started:
            host.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("binaries", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if not has_namespace():
        return start_in_namespace()
    with tempfile.TemporaryDirectory(prefix="pxpl5-full-") as name:
        folder = pathlib.Path(name)
        hosts = Hosts(options.binaries)
        for place in ("disk", "small/run"):
            (folder / place).mkdir(parents=True)
        try:
            return run_trials(options, sides_of(options, folder, hosts))
        except Failure as failure:
            print(f"FAILED {failure}")
            return 1
        finally:
            hosts.end()
            for place in ("disk", "small/run"):
                subprocess.run(["umount", "--lazy", folder / place], check=False)


if __name__ == "__main__":
    sys.exit(main())
