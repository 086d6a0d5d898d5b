#!/usr/bin/env python3
"""Files of the program and of strangers: test_private_files.py FOLDER_OF_BINARIES [words].

Who may read run folders, what is kept, what is refused, and where errors go.
"""
import fcntl
import json
import os
import pathlib
import select
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import unittest

from processes import children_of, name_of

BIN = pathlib.Path()  # From the command line.
LIMIT_S = 120


class PrivateFiles(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pxpl5-private-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.state = self.folder / "state"
        self.sockets = self.folder / "sockets"
        self.sockets.mkdir()
        self.work = self.folder / "work"
        self.work.mkdir()

    def pxpl5(self, *words, env=None, **more):
        return subprocess.run(
            [BIN / "pxpl5", *words], capture_output=not more, text=True, timeout=LIMIT_S,
            cwd=self.work, check=False, env={**os.environ, "XDG_STATE_HOME": str(self.state),
                                             "XDG_RUNTIME_DIR": str(self.sockets), **(env or {})},
            **more)

    def run_commands(self, commands, *flags, **more):
        return self.pxpl5("run", "--topology", "one-of-each", *flags, "-c", commands, **more)

    def runs(self):
        return sorted((self.state / "pxpl5").iterdir())

    def test_run_folders_lie_in_the_state_folder_for_the_owner_alone(self):
        done = self.run_commands("load phantom:sphere; surface s iso=0.5; digest", "--record",
                                 "full", preexec_fn=lambda: os.umask(0),
                                 stdout=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0)
        run, = self.runs()
        self.assertEqual(os.listdir(self.work), [])
        for folder, _, files in os.walk(self.state / "pxpl5"):
            mode = stat.S_IMODE(os.stat(folder).st_mode)
            if folder in (str(run), str(run.parent)):
                self.assertEqual(mode, 0o700, folder)
            for name in files:
                mode = stat.S_IMODE(os.lstat(os.path.join(folder, name)).st_mode)
                self.assertEqual(mode, 0o600, name)
        self.assertTrue((run / "traces/gp-0.mcap").exists())

    def run_without_lock(self, name, host):
        """A run with uploads, as a program on this host leaves it where files have no locks."""
        run = self.state / "pxpl5" / name
        (run / "uploads").mkdir(parents=True)
        (run / "manifest.json").write_text(json.dumps({"host": host}))
        return run

    def test_old_runs_go_and_running_ones_stay(self):
        base = self.state / "pxpl5"
        ended = subprocess.Popen(["true"])
        ended.wait()
        here = {"name": os.uname().nodename}
        for day in range(1, 6):
            self.run_without_lock(f"2020010{day}T000000Z-{ended.pid}", here)
        running = self.run_without_lock(f"20190101T000000Z-{os.getpid()}", here)
        other = base / "notes"
        other.mkdir()
        done = self.run_commands("stats", "--keep-runs", "3")
        self.assertEqual(done.returncode, 0, done)
        names = [run.name for run in self.runs()]
        self.assertEqual(names[:3], [running.name, f"20200104T000000Z-{ended.pid}",
                                     f"20200105T000000Z-{ended.pid}"])
        self.assertEqual(len(names), 5, names)
        self.assertIn("notes", names)
        self.assertTrue((running / "uploads").exists())
        self.assertFalse((base / names[1] / "uploads").exists())

    def test_runs_of_other_computers_and_containers_stay(self):
        ended = subprocess.Popen(["true"])
        ended.wait()
        here = {"name": os.uname().nodename}
        pids = os.readlink("/proc/self/ns/pid")
        unsure = [self.run_without_lock(f"2020010{n}T000000Z-{ended.pid}", host)
                  for n, host in enumerate(({"name": "elsewhere"}, {}, 5,
                                            {**here, "pid_namespace": "pid:[1]"}))]
        (unsure[1] / "manifest.json").write_text('{"host')
        gone = [self.run_without_lock(f"2020020{n}T000000Z-{ended.pid}", host)
                for n, host in enumerate((here, {**here, "pid_namespace": pids}))]
        # A program that runs elsewhere has a lock, whatever process has its number here.
        locked = self.run_without_lock(f"20200301T000000Z-{ended.pid}", here)
        freed = self.run_without_lock(f"20200302T000000Z-{os.getpid()}", {"name": "elsewhere"})
        (freed / "lock").write_text("")
        with open(locked / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.assertEqual(self.run_commands("presets", "--keep-runs", "1").returncode, 0)
            for run in (*unsure, locked):
                self.assertTrue((run / "uploads").exists(), run)
            for run in (*gone, freed):
                self.assertFalse(run.exists(), run)
        self.assertEqual(self.run_commands("presets", "--keep-runs", "1").returncode, 0)
        self.assertFalse(locked.exists())

    def is_locked(self, run):
        with open(run / "lock", "r+") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return True
        return False

    def test_a_program_locks_its_runs_until_it_ends(self):
        # The pulses of the children replace the lowest descriptors: the lock's must be above.
        low = [os.open("/dev/null", os.O_RDONLY) for _ in range(8)]
        self.addCleanup(lambda: [os.close(fd) for fd in low])
        program = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "-"], text=True,
            pass_fds=low, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            cwd=self.work, env={**os.environ, "XDG_STATE_HOME": str(self.state),
                                "XDG_RUNTIME_DIR": str(self.sockets)})
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        for line in ("kill gp-0", "load phantom:sphere"):
            program.stdin.write(line + "\n")
            program.stdin.flush()
            self.assertTrue(program.stdout.readline())
        first, second = self.runs()  # The restarted machine has a folder of its own.
        children = children_of(program.pid)
        self.assertEqual(len(children), 3)
        for child in children:
            for fd in os.listdir(f"/proc/{child}/fd"):
                self.assertNotIn("lock", os.path.basename(os.readlink(f"/proc/{child}/fd/{fd}")))
        self.assertEqual(os.stat(first / "lock").st_ino, os.stat(second / "lock").st_ino)
        self.assertTrue(self.is_locked(first) and self.is_locked(second))
        program.kill()
        program.wait()
        self.assertFalse(self.is_locked(first) or self.is_locked(second))
        program.stdin.close()
        program.stdout.close()

    def stop_writers(self, program):
        """Stops the io processes while one has an unfinished file, and returns them."""
        def is_stopped(pid):
            return "State:\tT" in pathlib.Path(f"/proc/{pid}/status").read_text()
        while program.poll() is None:
            parts = list(self.work.glob(".mesh.*.part.obj"))
            writers = [pid for pid in children_of(program.pid)
                       if parts and name_of(pid) == "pxpl5-io"]
            try:
                for pid in writers:
                    os.kill(pid, signal.SIGSTOP)
                while not all(is_stopped(pid) for pid in writers):
                    pass
                if writers and any(part.exists() for part in parts):
                    return writers
                for pid in writers:
                    os.kill(pid, signal.SIGCONT)
            except (FileNotFoundError, ProcessLookupError):
                pass  # It had finished; the next export has a process of its own.
        return self.fail("the program has ended: " + program.stderr.read())

    def test_a_host_that_is_killed_during_an_export_leaves_the_older_file_and_no_process(self):
        target = self.work / "mesh.obj"
        target.write_text("# older\n" * 1000)
        with subprocess.Popen(
                [BIN / "pxpl5", "run", "--topology", "one-of-each", "-"], text=True,
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                cwd=self.work, env={**os.environ, "XDG_STATE_HOME": str(self.state),
                                    "XDG_RUNTIME_DIR": str(self.sockets)}) as program:
            self.addCleanup(program.kill)
            program.stdin.write("load phantom:pelvis\nsurface bone\n" + "export mesh.obj\n" * 50)
            program.stdin.flush()
            self.stop_writers(program)
            before = target.read_bytes()
            children = [os.pidfd_open(pid) for pid in children_of(program.pid)]
            program.kill()
        self.assertGreaterEqual(len(children), 4)  # GP, Renderer, frame buffer, io process.
        for child in children:
            ended, _, _ = select.select([child], [], [], LIMIT_S)
            os.close(child)
            self.assertTrue(ended)
        self.assertEqual(target.read_bytes(), before)
        # An earlier export of these may have replaced the older file.
        is_older = before == b"# older\n" * 1000
        last = before.rpartition(b"\nf ")[2]
        self.assertTrue(is_older or before.endswith(b"\n") and last.count(b"\n") == 1, last[:200])
        # Nobody was left to remove the unfinished files.
        parts = list(self.work.glob(".mesh.*.part.*"))
        self.assertTrue(parts)
        parts.append(self.work / ".film.0123456789abcdef.part.webm")
        parts[-1].touch()
        for part in parts:
            os.utime(part, (1, 1))
        with open(parts[0], "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.export_sphere()
            self.assertEqual(list(self.work.glob(".*.part.*")), parts[:1])
        done = self.run_commands("load phantom:sphere; history script.txt")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(self.work.glob(".*.part.*")), [])

    def export_sphere(self):
        done = self.run_commands("load phantom:sphere; surface s iso=0.5; export mesh.obj")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_sockets_of_a_killed_host_go_with_the_next_start(self):
        def folder_of_sockets(name):
            folder = self.sockets / name
            folder.mkdir(mode=0o700)
            server = socket.socket(socket.AF_UNIX)
            server.bind(str(folder / "host"))
            server.listen()
            return folder, server

        dead, server = folder_of_sockets("pxpl5-aaaaaa")
        server.close()
        young, server = folder_of_sockets("pxpl5-bbbbbb")
        server.close()
        alive, listening = folder_of_sockets("pxpl5-cccccc")
        other = self.sockets / "pxpl5-longer-name"
        other.mkdir()
        for folder in (dead, alive, other):
            os.utime(folder, (1, 1))
        self.run_commands("help")  # Needs no machine.
        self.assertTrue(dead.exists())
        self.run_commands("presets")
        self.assertFalse(dead.exists())
        self.assertEqual(sorted(os.listdir(self.sockets)),
                         [young.name, alive.name, "pxpl5-longer-name"])
        listening.close()

    def start(self, *words, **more):
        program = subprocess.Popen(
            [BIN / "pxpl5", *words], stderr=subprocess.DEVNULL, cwd=self.work, text=True,
            env={**os.environ, "XDG_STATE_HOME": str(self.state), "TMPDIR": str(self.sockets),
                 "XDG_RUNTIME_DIR": str(self.sockets)}, **more)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        return program

    def assert_folders_go_with_the_next_start(self, program, count):
        """The folders stay while the program lives; a start after its end removes them."""
        folders = list(self.sockets.iterdir())
        self.assertEqual(len(folders), count, folders)
        nodes = [os.pidfd_open(pid) for pid in children_of(program.pid)]
        self.assertGreaterEqual(len(nodes), 3)
        for is_alive in (True, False):
            if not is_alive:
                program.kill()
                program.wait()
                for node in nodes:
                    self.assertEqual(select.select([node], [], [], LIMIT_S)[0], [node])
                    os.close(node)
            for folder in folders:
                os.utime(folder, (1, 1))
            done = self.run_commands("presets", env={"TMPDIR": str(self.sockets)})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(sorted(self.sockets.iterdir()), sorted(folders) if is_alive else [])

    def test_folders_of_a_killed_info_go_with_the_next_start(self):
        reading, writing = os.pipe()  # A full pipe, so that the program waits in the midst.
        with open(reading, "rb"), open(writing, "wb", buffering=0) as full:
            os.set_blocking(writing, False)
            while full.write(bytes(4096)):
                pass
            os.set_blocking(writing, True)
            program = self.start("info", "phantom:sphere", stdout=full)
            for node in ("gp-0", "renderer-0", "framebuffer-0"):
                while not list(self.sockets.glob(f"pxpl5-??????/{node}")):
                    self.assertIsNone(program.poll())
            self.assertEqual(len(list(self.sockets.glob("pxpl5-info-*"))), 1)
            self.assert_folders_go_with_the_next_start(program, 2)

    def test_a_folder_without_a_socket_of_a_killed_host_goes_with_the_next_start(self):
        with self.start("run", "--json", "--topology", "one-of-each", "--set",
                        "ring.transport=tcp", "-", stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE) as program:
            program.stdin.write("presets\n")
            program.stdin.flush()
            self.assertTrue(program.stdout.readline())
            self.assertEqual(list(self.sockets.glob("*/host")), [])
            self.assert_folders_go_with_the_next_start(program, 1)

    def test_a_folder_for_temporary_files_that_is_none_is_named(self):
        (self.folder / "file").write_text("")
        done = self.run_commands("presets", env={"TMPDIR": str(self.folder / "file"),
                                                 "XDG_RUNTIME_DIR": ""})
        self.assertEqual(done.returncode, 1, done)
        self.assertIn(str(self.folder / "file"), done.stderr)
        self.assertIn("TMPDIR", done.stderr)
        self.assertNotIn("Success", done.stderr)
        (self.work / "t").mkdir()
        done = self.run_commands("presets", env={"TMPDIR": "t", "XDG_RUNTIME_DIR": ""})
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_closed_streams_do_no_harm(self):
        for closed in ((0,), (1,), (2,), (0, 1, 2)):
            def close(closed=closed):
                for fd in closed:
                    os.close(fd)
            done = self.run_commands("load phantom:sphere", preexec_fn=close,
                                     stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, closed)

    def test_a_full_device_is_told(self):
        with open("/dev/full", "w") as full:
            done = self.pxpl5("--help", stdout=full, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("standard output cannot be written: No space left", done.stderr)
        done = self.run_commands("load phantom:sphere; history /dev/full")
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("history: '/dev/full' cannot be written: No space left", done.stderr)
        self.assertTrue(stat.S_ISCHR(os.stat("/dev/full").st_mode))

    def test_scripts_are_written_beside_no_file_of_the_user(self):
        (self.work / "x.part").write_text("mine")
        done = self.run_commands("load phantom:sphere; history x")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.work / "x.part").read_text(), "mine")
        self.assertEqual(sorted(os.listdir(self.work)), ["x", "x.part"])

    def test_many_programs_write_the_same_files_at_once(self):
        commands = "load phantom:sphere; surface s iso=0.5; snapshot a.png; export a.stl; digest"
        variables = {**os.environ, "XDG_STATE_HOME": str(self.state),
                     "XDG_RUNTIME_DIR": str(self.sockets)}
        running = [subprocess.Popen(
            [BIN / "pxpl5", "run", "--topology", "one-of-each", "-c", commands], cwd=self.work,
            env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            for _ in range(12)]
        digests = set()
        for program in running:
            said, errors = program.communicate(timeout=LIMIT_S)
            self.assertEqual((program.returncode, errors), (0, ""))
            digests.add(said.splitlines()[-1])
        self.assertEqual(len(digests), 1, digests)
        self.assertEqual(len(self.runs()), 12)
        self.assertEqual(os.listdir(self.sockets), [])
        self.assertEqual(sorted(os.listdir(self.work)),
                         ["a.png", "a.stl", "a.stl.certificate.json"])
        mesh = (self.work / "a.stl").read_bytes()
        self.assertEqual(len(mesh), 84 + 50 * int.from_bytes(mesh[80:84], "little"))
        self.assertTrue((self.work / "a.png").read_bytes().endswith(b"IEND\xaeB`\x82"))

    def test_fifos_are_refused_at_once(self):
        os.mkfifo(self.work / "scene.phigs")
        done = self.run_commands("load scene.phigs")
        self.assertEqual(done.returncode, 65, done)
        self.assertIn("scene.phigs: is no regular file", done.stderr)
        os.mkfifo(self.work / "plan.json")
        model = "load phantom:sphere; surface s iso=0.5; model plan.json"
        for done in (self.pxpl5("run", "--topology", "plan.json", "-c", "stats"),
                     self.run_commands(model)):
            self.assertEqual(done.returncode, 64, done)
            self.assertIn("plan.json: is no regular file", done.stderr)
        with open(self.work / "large.json", "wb") as large:
            large.truncate((1 << 20) + 1)
        done = self.pxpl5("run", "--topology", "large.json", "-c", "stats")
        self.assertEqual(done.returncode, 64, done)
        self.assertIn("large.json: has 1048577 bytes, 1048576 are the most", done.stderr)
        os.mkfifo(self.work / "gp-0.mcap")
        done = self.pxpl5("trace", "ls", ".")
        self.assertEqual(done.returncode, 65, done)
        self.assertIn("is no file", done.stderr)

    def test_a_header_reads_data_elsewhere_only_if_that_is_allowed(self):
        (self.folder / "private").mkdir()
        (self.folder / "private/data.raw").write_bytes(bytes(range(64)))
        (self.work / "a.nhdr").write_text(
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\n"
            "encoding: raw\ndata file: ../private/data.raw\n\n")
        done = self.pxpl5("info", "a.nhdr")
        self.assertEqual(done.returncode, 65, done)
        for text in ("a.nhdr", "../private/data.raw", "--allow DIR"):
            self.assertIn(text, done.stderr)
        for allow in (str(self.folder / "private"), "../private"):
            done = self.pxpl5("info", "a.nhdr", "--allow", allow)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1))
    unittest.main()
