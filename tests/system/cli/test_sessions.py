#!/usr/bin/env python3
"""`pxpl5 sessions`: test_sessions.py FOLDER_OF_BINARIES [words].

Which sessions run, how to reach them again, and how they end.
"""
import contextlib
import fcntl
import json
import os
import pathlib
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import unittest
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host/serve"))
from websocket_client import WebSocket  # noqa: E402

BIN = pathlib.Path()  # From the command line.
LIMIT_S = 120
PATIENT = ("--timeout", str(LIMIT_S))  # The end of a machine may take long on a busy computer.


def received(driver):
    """The next text."""
    while not isinstance(message := driver.receive(), str):
        pass
    return message


class Sessions(unittest.TestCase):
    def setUp(self):
        self.base = pathlib.Path(tempfile.mkdtemp(prefix="pxpl5-sessions-"))
        self.addCleanup(shutil.rmtree, self.base, ignore_errors=True)
        self.environment = {**os.environ, "XDG_STATE_HOME": str(self.base)}
        self.environment.pop("SLURM_JOB_ID", None)

    def sessions(self, *words, env=()):
        return subprocess.run([BIN / "pxpl5", "sessions", *words], capture_output=True, text=True,
                              timeout=2 * LIMIT_S, check=False,
                              env={**self.environment, **dict(env)})

    def listed(self):
        done = self.sessions("--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)["sessions"]

    def start(self, subcommand, *words, job=None):
        environment = {**self.environment, **({"SLURM_JOB_ID": job} if job else {})}
        process = subprocess.Popen(
            [BIN / "pxpl5", subcommand, "--topology", "one-of-each", *words], text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
        self.addCleanup(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        process.communicate(timeout=LIMIT_S)

    def serve(self, *words, job=None):
        """The program, and what it has printed."""
        process = self.start("serve", *words, job=job)
        said = ""
        while "Ctrl-C" not in said:
            line = process.stdout.readline()
            self.assertTrue(line, "serve has ended")
            said += line
        return process, said

    def prompt(self, *words):
        """The program after its first answer."""
        process = self.start("run", "--json", *words, "-")
        self.ask(process, "load phantom:sphere")
        return process

    def ask(self, process, line):
        process.stdin.write(line + "\n")
        process.stdin.flush()
        reply = json.loads(process.stdout.readline())
        self.assertTrue(reply["ok"], reply)

    def test_a_viewer_is_listed_with_what_it_shows(self):
        process, said = self.serve("phantom:sphere", job="77")
        self.assertEqual(len(self.listed()), 1)
        one, = self.listed()
        folder, = (self.base / "pxpl5").iterdir()
        self.assertEqual(
            [one[key] for key in ("name", "folder", "subcommand", "state", "volume", "computer",
                                  "here", "pid", "job", "viewers")],
            [folder.name, str(folder), "serve", "ready", "phantom:sphere", os.uname().nodename,
             True, process.pid, "77", 0])
        self.assertRegex(one["started"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertGreater(one["memory_bytes"], 1 << 20)
        text = self.sessions().stdout
        self.assertRegex(text, r"^name +command +state +since +volume +computer +job +process")
        self.assertRegex(text, rf"\n{folder.name} +serve +ready .*phantom:sphere .* 77 +"
                               rf"{process.pid} +\d+ MiB +0\n")
        self.assertNotIn("token", text + json.dumps(one))
        driver = WebSocket(re.search(r"http://\S+", said)[0])
        self.addCleanup(driver.close)
        driver.send('{"id": 1, "do": "load phantom:head"}')
        while json.loads(text := received(driver)).get("re") != 1:
            pass
        self.assertTrue(json.loads(text)["ok"], text)
        one, = self.listed()
        self.assertEqual((one["viewers"], one["volume"]), (1, "phantom:head"))

    def test_show_opens_the_page_again_for_the_owner_alone(self):
        process, said = self.serve("phantom:sphere")
        folder, = (self.base / "pxpl5").iterdir()
        note = folder / "session.json"
        self.assertEqual(stat.S_IMODE(note.stat().st_mode), 0o600)
        self.assertEqual(stat.S_IMODE(folder.stat().st_mode), 0o700)
        for name in (folder.name, str(process.pid), "latest"):
            shown = self.sessions("show", name).stdout
            for line in said.splitlines()[1:-1]:
                self.assertIn(line, shown)
        told = json.loads(self.sessions("show", "latest", "--json").stdout)
        with urllib.request.urlopen(told["url"], timeout=LIMIT_S) as page:
            self.assertEqual(page.status, 200)
        self.assertIn(f"ssh -L {told['url'].split(':')[2].split('/')[0]}:", told["tunnel"])
        self.assertEqual(self.sessions("end", folder.name, *PATIENT).returncode, 0)
        self.assertNotIn("token", note.read_text())

    def test_a_machine_that_was_started_again_is_one_session(self):
        process = self.prompt()
        self.ask(process, "kill gp-0")
        self.ask(process, "digest")
        self.assertEqual(len(list((self.base / "pxpl5").iterdir())), 2)
        one, = self.listed()
        self.assertEqual((one["state"], one["volume"], one["viewers"]),
                         ("running", "phantom:sphere", None))
        self.assertIn(f"-{process.pid}", one["name"])
        process.send_signal(signal.SIGSTOP)
        self.assertEqual(self.listed()[0]["state"], "stopped")
        process.send_signal(signal.SIGCONT)

    def test_a_killed_session_is_not_listed(self):
        killed, _ = self.serve("phantom:sphere")
        stays = self.prompt()
        self.assertEqual(len(self.listed()), 2)
        killed.kill()
        killed.wait(LIMIT_S)
        one, = self.listed()
        self.assertEqual(one["pid"], stays.pid)
        # Another program that removes old runs keeps the lock for a moment.
        folder, = (self.base / "pxpl5").glob(f"*-{killed.pid}")
        with open(folder / "lock", "r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.assertEqual(len(self.listed()), 1)
        gone = self.sessions("show", folder.name)
        self.assertEqual(gone.returncode, 64)
        self.assertIn(f"no session '{folder.name}' runs", gone.stderr)

    def test_end_ends_in_order(self):
        process, _ = self.serve("phantom:sphere")
        other = self.prompt()
        done = self.sessions("end", str(process.pid), *PATIENT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, rf"-{process.pid} has ended after \d+\.\d s\n")
        self.assertEqual(process.wait(LIMIT_S), 0)
        self.assertEqual([each["pid"] for each in self.listed()], [other.pid])
        self.assertEqual(self.sessions("end", str(process.pid)).returncode, 64)
        self.assertIsNone(other.poll())

    def test_end_says_that_a_session_does_not_end(self):
        process = self.prompt()
        process.send_signal(signal.SIGSTOP)
        done = self.sessions("end", "latest", "--timeout", "1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("has not ended within 1 s of SIGTERM. 'kill -KILL "
                      f"{process.pid}' ends it at once", done.stderr)
        process.send_signal(signal.SIGCONT)

    def locked_run(self, pid, **facts):
        """The run folder of a program on a computer, which this test locks."""
        run = self.base / "pxpl5" / f"20260101T000000Z-{pid}"
        run.mkdir(parents=True)
        (run / "manifest.json").write_text(json.dumps(facts))
        lock = self.enterContext(open(run / "lock", "w"))
        fcntl.flock(lock, fcntl.LOCK_EX)
        return run

    def test_a_session_of_another_computer_is_listed_with_the_line_that_ends_it(self):
        sleeper = subprocess.Popen(["sleep", str(LIMIT_S)])
        self.addCleanup(self.stop, sleeper)
        for job, line in (("", f"ssh far kill -TERM {sleeper.pid}"), ("12", "scancel 12")):
            run = self.locked_run(sleeper.pid, subcommand="run", job=job, host={"name": "far"})
            one, = self.listed()
            self.assertEqual((one["computer"], one["here"], one["memory_bytes"]),
                             ("far", False, None))
            done = self.sessions("end", run.name)
            self.assertEqual(done.returncode, 69)
            self.assertIn(f"runs on computer far, not on {os.uname().nodename}. Run '{line}'",
                          done.stderr)
            shutil.rmtree(run)
        self.assertIsNone(sleeper.poll())

    def test_a_process_id_that_was_used_again_is_not_signaled(self):
        sleeper = subprocess.Popen(["sleep", str(LIMIT_S)])
        self.addCleanup(self.stop, sleeper)
        here = {"name": os.uname().nodename, "pid_namespace": os.readlink("/proc/self/ns/pid"),
                "boot_id": pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()}
        run = self.locked_run(sleeper.pid, subcommand="run", process_start=1, host=here)
        self.assertEqual(self.listed(), [])
        self.assertEqual(self.sessions("end", run.name).returncode, 64)
        self.assertIsNone(sleeper.poll())

    def test_a_damaged_manifest_hides_no_session(self):
        run = self.locked_run(4711)
        (run / "manifest.json").write_text("{")
        one, = self.listed()
        self.assertEqual((one["name"], one["here"]), (run.name, False))

    def test_a_fifo_in_the_place_of_a_manifest_keeps_nobody_waiting(self):
        run = self.locked_run(4711)
        for name in ("manifest.json", "session.json"):
            (run / name).unlink(missing_ok=True)
            os.mkfifo(run / name)
        one, = self.listed()
        self.assertEqual((one["name"], one["here"]), (run.name, False))

    @unittest.skipUnless(os.geteuid() == 0, "only root can give a folder to another user")
    def test_run_folders_of_other_users_are_no_sessions(self):
        """Their manifests could make `end` signal any process, and `show` print any address."""
        sleeper = subprocess.Popen(["sleep", str(LIMIT_S)])
        self.addCleanup(self.stop, sleeper)
        here = {"name": os.uname().nodename, "pid_namespace": os.readlink("/proc/self/ns/pid"),
                "boot_id": pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()}
        stat_text = pathlib.Path(f"/proc/{sleeper.pid}/stat").read_text()
        run = self.locked_run(sleeper.pid, subcommand="run", host=here,
                              process_start=int(stat_text.rsplit(")", 1)[1].split()[19]))
        self.assertEqual(len(self.listed()), 1)
        os.chown(run, 65534, 65534)
        self.assertEqual(self.listed(), [])
        self.assertEqual(self.sessions("end", str(sleeper.pid)).returncode, 64)
        self.assertIsNone(sleeper.poll())

    def test_without_sessions(self):
        done = self.sessions()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout,
                         f"no session runs with its run folder in {self.base / 'pxpl5'}\n")
        self.assertEqual(self.listed(), [])


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1))
    unittest.main()
