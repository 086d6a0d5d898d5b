#!/usr/bin/env python3
"""Machines on three computers: every engine gives the bits of one computer, and all faults end.

usage: test_machines.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import json
import pathlib
import re
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import contents  # noqa: E402
from cluster import Cluster, OTHER_USER, missing  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
PXPL5 = str(BIN / "pxpl5")
LIMIT_S = 120
NAMES = "n1,n2,n3"
SSH = ("--engine", "ssh", "--computers", NAMES)
SLURM = ("--engine", "slurm")
MPIRUN = ("--engine", "mpirun", "--computers", NAMES)
ENDS = tuple(word for role in ("gp", "renderer", "frame_buffer")
             for word in ("--set", f"{role}.restart.policy=end"))
SCENE = ["load phantom:pelvis", "surface skin iso=-300 opacity=0.5", "surface bone iso=250",
         "view 30 20 zoom=1.5", "size 200x160", "digest", "certificate bone"]
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


def new_cluster():
    return Cluster(computers=3, slots=64, hosts_as_debian=True, noisy_bashrc=True, shared=[BIN])


class OnACluster(unittest.TestCase):
    """Machines on `self.cluster`."""

    def run_lines(self, lines, *words, before=(), check=True):
        return self.cluster.login([*before, PXPL5, "run", "--json", "--run-folder", "runs", *words,
                                   "-c", "; ".join(lines)], check=check, timeout=LIMIT_S)

    def start(self, *words, before=(), lines=("load phantom:sphere", "surface s iso=0")):
        """A machine at its prompt, after the replies to `lines`."""
        machine = self.cluster.popen(
            "login", [*before, PXPL5, "run", "--json", "--run-folder", "runs", *words, "-"],
            stdin=-1, stdout=-1, stderr=-1, text=True)
        machine.stdin.write("".join(f"{line}\n" for line in lines))
        machine.stdin.flush()
        for line in lines:
            reply = json.loads(machine.stdout.readline() or '{"ok": false, "error": "ended"}')
            self.assertTrue(reply["ok"], f"{line}: {reply}")
        return machine

    def end_of(self, machine, line="digest"):
        out, complaint = machine.communicate(f"{line}\n", timeout=LIMIT_S)
        return machine.returncode, out, complaint


class Machines(OnACluster):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(new_cluster())

    def tearDown(self):
        self.cluster.wait_until_idle()

    def wait_until_no_node_runs(self):
        while left := [each for each in self.cluster.processes() if "pxpl5" in str(each)]:
            contents.wait_for(left, LIMIT_S)

    def check_engine(self, *words, before=()):
        alone = results(self.run_lines(SCENE, *FOUR_GPS).stdout)
        for more in ((), ("--insecure-tcp",), ("--set", "placement=spread")):
            with self.subTest(words=more):
                done = self.run_lines(SCENE, *FOUR_GPS, *words, *more, before=before)
                self.assertEqual(results(done.stdout), alone)
                self.cluster.wait_until_idle()

    def test_ssh(self):
        self.check_engine(*SSH)

    def test_slurm(self):
        self.check_engine(*SLURM, before=("salloc", "--quiet", "-N3", "-n3"))

    def test_mpirun(self):
        self.check_engine(*MPIRUN)

    def test_computers_that_join_by_hand(self):
        alone = results(self.run_lines(SCENE, *FOUR_GPS).stdout)
        machine = self.cluster.popen(
            "login", [PXPL5, "run", "--json", "--run-folder", "runs", "--engine", "wait", "--set",
                      "wait=3", *FOUR_GPS, "-c", "; ".join(SCENE)],
            stdout=-1, stderr=-1, text=True)
        words = re.search(r": (/.*/pxpl5 join .*)$", machine.stderr.readline()).group(1).split()
        stranger = self.cluster.on("n2", [*words[:3], "--key-file", words[4]], user=OTHER_USER,
                                   check=False)
        self.assertEqual(stranger.returncode, 64, stranger.stderr)
        self.assertIn("cannot read the key file", stranger.stderr)
        joins = [self.cluster.popen(name, words, stderr=-1, text=True)
                 for name in NAMES.split(",")]
        out, complaint = machine.communicate(timeout=LIMIT_S)
        self.assertEqual(machine.returncode, 0, complaint)
        self.assertEqual(results(out), alone)
        for join in joins:
            join.communicate(timeout=LIMIT_S)
            self.assertEqual(join.returncode, 0)

    def test_the_paper_s_machine_of_54_processes(self):
        lines = ["load phantom:sphere", "surface s iso=0", "digest"]
        alone = results(self.run_lines(lines, "--topology", "paper-1993").stdout)
        far = self.run_lines(lines, "--topology", "paper-1993", *SSH)
        self.assertEqual(results(far.stdout), alone)

    def test_traces_of_other_computers_answer_questions(self):
        lines = ["load phantom:sphere", "surface s iso=0", "size 128x128", "snapshot x.png"]
        runs = "traced"
        self.cluster.login([PXPL5, "run", "--run-folder", runs, "--record", "full", *SSH, "-c",
                            "; ".join(lines)], timeout=LIMIT_S)
        said = self.cluster.login(["sh", "-c", f"{PXPL5} trace ls {runs}/*/"])
        self.assertIn("renderer-0", said.stdout)
        files = self.cluster.login(["sh", "-c", f"ls {runs}/*/traces"]).stdout.split()
        self.assertIn("gp-0.mcap", files)
        self.assertIn("renderer-0.mcap", files)

    def test_a_dead_node_is_replaced(self):
        lines = ["load phantom:sphere", "surface s iso=0", "digest", "kill gp-1", "digest"]
        got = results(self.run_lines(lines, *SSH, "--set", "gp.count=3").stdout)
        self.assertEqual(got[2], got[4])

    def test_a_computer_without_power(self):
        machine = self.start(*SSH, *ENDS, "--set", "placement=spread", *FOUR_GPS)
        begin = time.monotonic()
        self.cluster.off("n2")
        try:
            code, _, complaint = self.end_of(machine)
            took_s = time.monotonic() - begin
            self.assertEqual(code, 69, complaint)
            self.assertRegex(complaint, r"is lost with computer n2: it has not answered for")
            print(f"power off: the machine had ended after {took_s:.1f} s")
        finally:
            self.cluster.boot("n2")

    def test_a_cut_cable(self):
        machine = self.start(*SSH, *ENDS, "--set", "placement=spread", *FOUR_GPS)
        self.cluster.cut("n3")
        try:
            code, _, complaint = self.end_of(machine)
            self.assertEqual(code, 69, complaint)
            self.assertRegex(complaint, r"is lost with computer n3: it has not answered for")
            self.wait_until_no_node_runs()  # Also on n3, which hears nothing from anybody.
        finally:
            self.cluster.join("n3")

    def test_after_a_lost_computer_the_session_goes_on(self):
        machine = self.start(*SSH, "--set", "placement=spread", *FOUR_GPS, "--set",
                             "gp.restart.backoff_ms=0",
                             lines=("load phantom:sphere", "surface s iso=0", "digest"))
        processes = [each for each in self.cluster.processes() if "pxpl5 join" in str(each)]
        self.assertEqual(len(processes), 3, processes)
        self.cluster.on("n2", ["pkill", "-9", "-f", "pxpl5 join"])
        code, out, complaint = self.end_of(machine)
        self.assertEqual(code, 0, complaint)
        self.assertRegex(complaint, "is lost with computer n2|engine-n2 ended with exit code 255")
        self.assertEqual(len(results(out)), 1)

    def test_a_job_shows_its_page_and_ends(self):
        script = ROOT / "host/slurm-session.sbatch"
        job = self.cluster.login(["sbatch", "--parsable", "-N3", script, "phantom:sphere"],
                                 env={"PXPL5": PXPL5}).stdout.strip()
        # No event tells another computer that the file has grown.
        wait = (f"until grep -q 'ends it' .local/state/pxpl5/job-{job}.txt 2>/dev/null; do "
                f"[ \"$(squeue -h -j {job} -o %T)\" ] || exit 1; sleep 0.1; done; "
                f"cat .local/state/pxpl5/job-{job}.txt; stat -c 'mode %a' .local/state/pxpl5/job-*")
        told = self.cluster.login(["sh", "-c", wait], check=False, timeout=LIMIT_S)
        self.assertEqual(told.returncode, 0, self.cluster.login(["cat", f"pxpl5-{job}.out"]).stdout)
        self.assertIn("mode 600", told.stdout)
        url, port = re.search(r"open +(http://127.0.0.1:(\d+)/\S+)", told.stdout).groups()
        here = re.search(rf"ssh -L {port}:127.0.0.1:{port} -J login (n\d)", told.stdout)
        self.assertTrue(here, told.stdout)
        get = f"import urllib.request as r; print(r.urlopen({url!r}).read().decode())"
        page = self.cluster.on(here[1], [sys.executable, "-c", get])
        self.assertIn("pxpl5", page.stdout)
        out = self.cluster.login(["cat", f"pxpl5-{job}.out"]).stdout
        self.assertNotIn("token", out)
        self.cluster.login(["scancel", job])
        self.cluster.wait_until_idle()

    def test_a_killed_host_leaves_nothing(self):
        for words, before in ((SSH, ()), (SLURM, ("salloc", "--quiet", "-N3", "-n3"))):
            with self.subTest(words=words):
                machine = self.start(*words, *FOUR_GPS, before=before)
                self.cluster.login(["pkill", "-9", "-f", "pxpl5 run"])
                machine.communicate(timeout=LIMIT_S)
                self.cluster.wait_until_idle()

    def test_a_killed_srun(self):
        in_job = ("salloc", "--quiet", "-N3", "-n3")
        for words, code in ((ENDS, 137), ((), 0)):
            with self.subTest(words=words):
                machine = self.start(*SLURM, *words, *FOUR_GPS, before=in_job)
                self.cluster.login(["pkill", "-9", "-o", "-x", "srun"])
                ended, out, complaint = self.end_of(machine)
                self.assertEqual(ended, code, complaint)
                self.assertIn("engine-slurm was killed by signal 9", complaint)
                self.assertNotIn("goes on without computer", complaint)
                self.assertEqual(len(out.splitlines()), 1, out)
                self.cluster.wait_until_idle()

    def test_the_time_limit_of_a_job(self):
        machine = self.start(*SLURM, *ENDS, *FOUR_GPS, before=("salloc", "--quiet", "-N3", "-n3"))
        self.cluster.login(["scancel", "--signal=TERM", "--me"])
        code, _, complaint = self.end_of(machine)
        self.assertNotEqual(code, 0)
        self.assertRegex(complaint, r"SIGTERM")


class Losses(OnACluster):
    """Each test has a cluster of its own, which has a computer less at the end."""

    def setUp(self):
        self.cluster = self.enterContext(new_cluster())

    def tearDown(self):
        self.cluster.wait_until_idle()

    def check_that_a_session_goes_on_without(self, computer, *words, before=()):
        """The same picture by the computers that are left, and once more after another restart."""
        machine = self.start(*words, "--set", "placement=spread", *FOUR_GPS, before=before)
        machine.stdin.write("digest\n")
        machine.stdin.flush()
        digest = json.loads(machine.stdout.readline())["result"]
        self.cluster.off(computer)
        begin = time.monotonic()
        machine.stdin.write("digest\n")
        machine.stdin.flush()
        again = json.loads(machine.stdout.readline())
        print(f"power off: the next picture after {time.monotonic() - begin:.1f} s")
        code, out, complaint = self.end_of(machine, "kill gp-0\ndigest")
        self.assertEqual(again.get("result"), digest, f"{again} {complaint}")
        self.assertEqual(code, 0, complaint)
        self.assertEqual(json.loads(out.splitlines()[-1])["result"], digest)
        self.assertEqual(complaint.count(f"goes on without computer {computer}"), 1, complaint)

    def test_without_a_lost_computer_by_ssh(self):
        self.check_that_a_session_goes_on_without("n2", *SSH)

    def test_without_a_lost_computer_by_slurm(self):
        self.check_that_a_session_goes_on_without(
            "n2", *SLURM, before=("salloc", "--quiet", "--no-kill", "-N3", "-n3"))


if __name__ == "__main__":
    if reason := missing([BIN]):
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
