#!/usr/bin/env python3
"""`pxpl5 serve --engine slurm` on the login computer: it submits a job and follows it.

usage: test_jobs.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import pathlib
import queue
import re
import shlex
import signal
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from cluster import missing  # noqa: E402
from on_cluster import BIN, LIMIT_S, PXPL5, Dialog, new_cluster  # noqa: E402

UP = r"Ctrl-C ends job \d+"


class Follower(Dialog):
    """A `pxpl5 serve` that follows its job."""

    def __init__(self, program):
        super().__init__(program)
        self.shown = ""
        self.job = self.until(r"job (\d+) is submitted")[1]

    def until(self, pattern):
        """Reads lines until one has the pattern. Returns the match."""
        end = time.monotonic() + LIMIT_S
        while not (found := re.search(pattern, self.shown)):
            try:
                line = self.out.get(timeout=max(0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"no '{pattern}' in {LIMIT_S} s: {self.shown}") from None
            if not line:
                raise AssertionError(f"no '{pattern}': {self.shown}{self.rest(self.notes)}")
            self.shown += line
        return found

    @staticmethod
    def rest(lines):
        return "".join(iter(lambda: lines.get(timeout=LIMIT_S), ""))

    def ended(self):
        """Waits for the end. Returns exit code, unread output and standard error."""
        code = self.program.wait(LIMIT_S)
        return code, self.rest(self.out), self.rest(self.notes)


class Jobs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(new_cluster())

    def tearDown(self):
        self.cluster.login(["scancel", "--me"])
        self.cluster.wait_until_idle()

    def serve(self, *words):
        program = self.cluster.popen("login", [PXPL5, "serve", "--engine", "slurm", *words],
                                     stdout=-1, stderr=-1, text=True)
        self.addCleanup(program.end)
        return Follower(program)

    def job(self, program):
        return self.cluster.login(["scontrol", "show", "job", program.job]).stdout

    def test_a_job_that_waits_says_why_and_ctrl_c_cancels_it(self):
        busy = self.cluster.login(["sbatch", "--parsable", "-N3", "--exclusive", "--time=10",
                                   "--output=/dev/null", "--wrap", "tail -f /dev/null"]).stdout
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            program = self.serve("--nodes", "2")
            program.until(r"job \d+ waits: Resources \(the computers that it needs are in")
            self.assertIn("JobState=PENDING", self.job(program))
            program.program.send_signal(number)
            ended, out, complaint = program.ended()
            self.assertEqual((ended, complaint), (code, ""))
            self.assertIn(f"job {program.job} is canceled\n", out)
            self.assertIn("JobState=CANCELLED", self.job(program))
        self.assertIn("JobState=RUNNING", self.cluster.login(
            ["scontrol", "show", "job", busy.strip()]).stdout)

    def test_a_job_shows_its_page_by_the_line_for_ssh(self):
        program = self.serve("--nodes", "2", "--time-limit", "10", "phantom:sphere",
                             "--sbatch-option=--comment=of ada", "--sbatch-option", "-Jball")
        program.until(UP)
        job = self.job(program)
        for words in ("NumNodes=2", "TimeLimit=00:10:00", "Comment=of ada", "JobName=ball"):
            self.assertIn(words, job)
        url, = re.findall(r"open +(http://127.0.0.1:\d+/\?token=\w+)\n", program.shown)
        line, = re.findall(r"from another computer: (ssh .*), then open the same", program.shown)
        self.assertRegex(line, r"^ssh -L (\d+):127\.0\.0\.1:\1 -J login n\d$")
        away = ({"n1", "n2", "n3"} - set(re.findall(r"n\d", line))).pop()
        tunnel = Dialog(self.cluster.popen(away, [*shlex.split(line), "echo up; read line"],
                                           stdin=-1, stdout=-1, stderr=-1, text=True))
        self.addCleanup(tunnel.program.end)
        while (said := tunnel.out.get(timeout=LIMIT_S)) != "up\n":
            self.assertTrue(said, "ssh has ended")
        get = f"import urllib.request as r; print(r.urlopen({url!r}).read().decode())"
        page = self.cluster.on(away, [sys.executable, "-c", get]).stdout
        tunnel.end()
        self.assertIn("<title>pxpl5</title>", page)
        self.check_secret(program, url.partition("token=")[2])
        program.program.send_signal(signal.SIGINT)
        code, out, complaint = program.ended()
        self.assertEqual((code, complaint), (0, ""))
        self.assertIn(f"job {program.job} is canceled\n", out)
        self.cluster.wait_until_idle()

    def check_secret(self, program, token):
        """Only files of the owner have the token."""
        read = self.cluster.login
        script = read(["scontrol", "write", "batch_script", program.job, "-"]).stdout
        self.assertIn("set -- phantom:sphere\n", script)
        commands = [str(one.argv) for one in self.cluster.processes()]
        self.assertTrue(any("phantom:sphere" in command for command in commands), commands)
        output = read(["cat", f"pxpl5-{program.job}.out"]).stdout
        self.assertNotIn(token, " ".join([script, self.job(program), output, *commands]))
        modes = read(["sh", "-c", f"grep -rl {token} . | xargs stat -c %a"]).stdout.split()
        self.assertEqual(set(modes), {"600"})

    def test_a_job_goes_on_without_the_terminal(self):
        program = self.serve("phantom:sphere")
        program.until(UP)
        program.program.send_signal(signal.SIGHUP)
        self.assertEqual(program.ended()[0], -signal.SIGHUP)
        self.assertIn("JobState=RUNNING", self.job(program))
        shown = self.cluster.login([PXPL5, "sessions", "show", program.job]).stdout
        self.assertRegex(shown, r"open +http://127.0.0.1:\d+/\?token=")

    def test_the_end_of_a_job_names_the_saved_session(self):
        program = self.serve("phantom:sphere", "--time-limit", "2")
        program.until(UP)
        wait = (f"until grep -q 'session is saved' pxpl5-{program.job}.out; do "
                f"[ \"$(squeue -h -j {program.job} -o %T)\" ] || exit 1; sleep 0.1; done")
        self.cluster.login(["sh", "-c", wait], timeout=LIMIT_S)
        self.cluster.login(["scancel", program.job])
        code, out, complaint = program.ended()
        self.assertEqual((code, complaint), (0, ""))
        self.assertRegex(out, rf"job {program.job} has ended: CANCELLED\n")
        file = re.search(r"Open it again with: pxpl5 serve --session (\S+)", out)[1]
        self.assertIn("load phantom:sphere", self.cluster.login(["cat", file]).stdout)

    def test_a_job_that_fails_shows_the_end_of_its_output(self):
        program = self.serve("missing.nrrd")
        code, _, complaint = program.ended()
        self.assertEqual(code, 69)
        self.assertRegex(complaint, rf"error: job {program.job} has ended: FAILED, before its page "
                         rf"was up. The end of its output /home/ada/pxpl5-{program.job}.out:\n"
                         r"(.*\n)*error: .*missing.nrrd")

    def test_a_job_that_slurm_refuses(self):
        done = self.cluster.login([PXPL5, "serve", "--engine", "slurm",
                                   "--sbatch-option=--partition=nowhere"], check=False)
        self.assertEqual(done.returncode, 69, done.stdout)
        self.assertRegex(done.stderr, "error: sbatch has failed with code 1: sbatch: error: .*"
                         "partition.*. No job was submitted")


if __name__ == "__main__":
    if reason := missing([BIN]):
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
