#!/usr/bin/env python3
"""`pxpl5 serve --engine slurm` on the login computer: it submits a job and follows it.

usage: test_jobs.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import pathlib
import re
import shlex
import signal
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from cluster import Cluster, missing  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
PXPL5 = str(BIN / "pxpl5")
LIMIT_S = 120
UP = r"Ctrl-C ends job \d+"


class Jobs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(Cluster(
            computers=3, slots=64, hosts_as_debian=True, noisy_bashrc=True, shared=[BIN]))

    def tearDown(self):
        self.cluster.login(["scancel", "--me"])
        self.cluster.wait_until_idle()

    def serve(self, *words):
        program = self.cluster.popen("login", [PXPL5, "serve", "--engine", "slurm", *words],
                                     stdout=-1, stderr=-1, text=True)
        program.said = ""
        program.job = self.until(program, r"job (\d+) is submitted")[1]
        return program

    def until(self, program, pattern):
        """Reads lines until one has the pattern. Returns the match."""
        while not (found := re.search(pattern, program.said)):
            line = program.stdout.readline()
            if not line:
                self.fail(f"no '{pattern}': {program.said}{program.communicate()[1]}")
            program.said += line
        return found

    def end_of(self, program):
        out, complaint = program.communicate(timeout=LIMIT_S)
        return program.returncode, out, complaint

    def job(self, program):
        return self.cluster.login(["scontrol", "show", "job", program.job]).stdout

    def test_a_job_that_waits_says_why_and_ctrl_c_cancels_it(self):
        busy = self.cluster.login(["sbatch", "--parsable", "-N3", "--exclusive", "--time=10",
                                   "--output=/dev/null", "--wrap", "tail -f /dev/null"]).stdout
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            program = self.serve("--nodes", "2")
            self.until(program, r"job \d+ waits: Resources \(the computers that it needs are in")
            self.assertIn("JobState=PENDING", self.job(program))
            program.send_signal(number)
            ended, out, complaint = self.end_of(program)
            self.assertEqual((ended, complaint), (code, ""))
            self.assertIn(f"job {program.job} is canceled\n", out)
            self.assertIn("JobState=CANCELLED", self.job(program))
        self.assertIn("JobState=RUNNING", self.cluster.login(
            ["scontrol", "show", "job", busy.strip()]).stdout)

    def test_a_job_shows_its_page_by_the_line_for_ssh(self):
        program = self.serve("--nodes", "2", "--time-limit", "10", "phantom:sphere",
                             "--sbatch-option=--comment=of ada", "--sbatch-option", "-Jball")
        self.until(program, UP)
        job = self.job(program)
        for words in ("NumNodes=2", "TimeLimit=00:10:00", "Comment=of ada", "JobName=ball"):
            self.assertIn(words, job)
        url, = re.findall(r"open +(http://127.0.0.1:\d+/\?token=\w+)\n", program.said)
        line, = re.findall(r"from another computer: (ssh .*), then open the same", program.said)
        self.assertRegex(line, r"^ssh -L (\d+):127\.0\.0\.1:\1 -J login n\d$")
        away = ({"n1", "n2", "n3"} - set(re.findall(r"n\d", line))).pop()
        with self.cluster.popen(away, [*shlex.split(line), "echo up; read line"],
                                stdin=-1, stdout=-1, stderr=-1, text=True) as tunnel:
            while (said := tunnel.stdout.readline()) != "up\n":
                self.assertTrue(said, "ssh has ended")
            get = f"import urllib.request as r; print(r.urlopen({url!r}).read().decode())"
            page = self.cluster.on(away, [sys.executable, "-c", get]).stdout
        self.assertIn("<title>pxpl5</title>", page)
        self.check_secret(program, url.partition("token=")[2])
        program.send_signal(signal.SIGINT)
        code, out, complaint = self.end_of(program)
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
        self.until(program, UP)
        program.send_signal(signal.SIGHUP)
        self.assertEqual(self.end_of(program)[0], -signal.SIGHUP)
        self.assertIn("JobState=RUNNING", self.job(program))
        shown = self.cluster.login([PXPL5, "sessions", "show", program.job]).stdout
        self.assertRegex(shown, r"open +http://127.0.0.1:\d+/\?token=")

    def test_the_end_of_a_job_names_the_saved_session(self):
        program = self.serve("phantom:sphere", "--time-limit", "2")
        self.until(program, UP)
        wait = (f"until grep -q 'session is saved' pxpl5-{program.job}.out; do "
                f"[ \"$(squeue -h -j {program.job} -o %T)\" ] || exit 1; sleep 0.1; done")
        self.cluster.login(["sh", "-c", wait], timeout=LIMIT_S)
        self.cluster.login(["scancel", program.job])
        code, out, complaint = self.end_of(program)
        self.assertEqual((code, complaint), (0, ""))
        self.assertRegex(out, rf"job {program.job} has ended: CANCELLED\n")
        file = re.search(r"Open it again with: pxpl5 serve --session (\S+)", out)[1]
        self.assertIn("load phantom:sphere", self.cluster.login(["cat", file]).stdout)

    def test_a_job_that_fails_shows_the_end_of_its_output(self):
        program = self.serve("missing.nrrd")
        code, _, complaint = self.end_of(program)
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
