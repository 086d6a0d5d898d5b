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
from cluster import OTHER_USER, missing  # noqa: E402
from on_cluster import (BIN, ENDS, FOUR_GPS, IN_JOB, LIMIT_S, MPIRUN, NAMES, PXPL5,  # noqa: E402
                        ROOT, SLURM, SSH, OnACluster, new_cluster, results)

SCENE = ["load phantom:pelvis", "surface skin iso=-300 opacity=0.5", "surface bone iso=250",
         "view 30 20 zoom=1.5", "size 200x160", "digest", "certificate bone"]


class Machines(OnACluster):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(new_cluster())

    def tearDown(self):
        self.cluster.wait_until_idle()

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
        self.check_engine(*SLURM, before=IN_JOB)

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

    def test_every_topology_by_every_engine(self):
        """Also the paper's machine of 54 processes, with CURVE and without."""
        lines = ["load phantom:sphere", "surface s iso=0", "digest", "certificate s"]
        for topology in ("one-of-each", "default", "paper-1993"):
            alone = results(self.run_lines(lines, "--topology", topology).stdout)
            for words, before in ((SSH, ()), (SLURM, IN_JOB), (MPIRUN, ())):
                for more in ((), ("--insecure-tcp",)):
                    with self.subTest(topology=topology, words=words, more=more):
                        far = self.run_lines(lines, "--topology", topology, *words, *more,
                                             before=before)
                        self.assertEqual(results(far.stdout), alone)
                        self.cluster.wait_until_idle()

    def test_traces_are_those_of_one_computer(self):
        lines = "load phantom:sphere; surface s iso=0; size 256x256; snapshot x.png; orbit 3"
        for folder, words in (("alone", ()), ("far", SSH), ("plain", (*SSH, "--insecure-tcp"))):
            self.cluster.login([PXPL5, "run", "--run-folder", f"same/{folder}", "--record", "full",
                                *FOUR_GPS, *words, "-c", lines], timeout=LIMIT_S)
        self.cluster.wait_until_idle()
        for folder in ("far", "plain"):
            compare = f"{PXPL5} trace diff --json same/alone/*/ same/{folder}/*/"
            told = json.loads(self.cluster.login(["sh", "-c", compare]).stdout)
            self.assertEqual(told.get("frames"), 4, told)
        said = self.cluster.login(["sh", "-c", compare.replace("--json ", "")]).stdout
        self.assertIn("no difference: 4 frames", said)

    def test_a_frame_sends_the_bytes_that_the_plan_says(self):
        """Renderers on one computer: the plan is exact but for the overhead of messages, and for
        GPs that do not have equally many triangles in sight."""
        words = ("--engine", "ssh", "--computers", "n1:5,n2:2", "--record", "full", *FOUR_GPS)
        plan = self.cluster.login([PXPL5, "run", "--dry-run", *words]).stderr
        pixels, programs = (float(mb) for mb in re.findall(r"([\d.]+) MB", plan))
        self.assertRegex(plan, r"n1 +5 nodes +gp-0..1, renderer-0..2\n +n2 +2 nodes +gp-2..3\n")
        self.assertEqual(programs, 0.72)
        lines = ["load phantom:pelvis", "surface bone iso=250", "size 512x512", "activity",
                 "orbit 10", "activity"]
        told = results(self.run_lines(lines, *words).stdout)[-1]
        self.assertEqual(told["frames"], 10)
        computers = {each["name"]: each for each in told["computers"]}
        self.assertEqual([each["nodes"] for each in computers.values()], [2, 5, 2])
        kinds = {each["kind"]: each["bytes"] for each in told["network"]["kinds"]}
        self.assertAlmostEqual(kinds["RegionPixels"] / 10 / 1e6, pixels, delta=0.01 * pixels)
        sent = {kind: sum(each["bytes"] for node in told["nodes"] for each in node["sent"]
                          if each["kind"] == kind and node["name"] in ("gp-2", "gp-3"))
                for kind in ("RegionPrograms",)}
        self.assertEqual(kinds["RegionPrograms"], sent["RegionPrograms"])
        self.cluster.wait_until_idle()
        newest = f"{PXPL5} trace ls --json $(ls -td runs/*/ | head -n 1)"
        frames = json.loads(self.cluster.login(["sh", "-c", newest]).stdout)["frames"]
        triangles = sum(frame["triangles_drawn"] for frame in frames)
        forecast = triangles / 10_000 * programs * 1e6
        self.assertAlmostEqual(kinds["RegionPrograms"], forecast, delta=0.05 * forecast)
        self.assertEqual(len(frames), 10)
        self.assertEqual(told["network"]["bytes"], sum(kinds.values()))
        self.assertEqual(sum(each["sent_bytes"] for each in computers.values()),
                         told["network"]["bytes"])
        print(f"a frame: {told['network']['bytes_per_frame'] / 1e6:.2f} MB between computers")

    def test_messages_are_compressed_where_the_network_is_slow(self):
        lines = ["load phantom:sphere", "surface s iso=0", "size 512x512", "digest"]
        words = (*SSH, "--set", "placement=spread", *FOUR_GPS)
        note = r"note: the network to n\d carries \d+ MB/s: messages between .* are compressed"

        def sent_bytes(computer):
            """By all of its messages, as the network counts them."""
            text = self.cluster.on(computer, ["cat", "/proc/net/dev"]).stdout
            return int(re.search(r"eth0:(.*)", text)[1].split()[8])

        def run(*more):
            before = sent_bytes("n3")
            done = self.run_lines(lines, *words, *more)
            self.cluster.wait_until_idle()
            return done, sent_bytes("n3") - before

        fast, plain_bytes = run("--set", "compress_below_mb_s=1")  # Measured, too.
        self.assertNotRegex(fast.stderr, note)
        self.cluster.link("n3", rate_mbit=20)
        try:
            slow, packed_bytes = run()
        finally:
            self.cluster.link("n3")
        self.assertRegex(slow.stderr, note)
        self.assertEqual(results(slow.stdout), results(fast.stdout))
        print(f"n3 has sent {plain_bytes} bytes, compressed {packed_bytes}")
        self.assertLess(packed_bytes, plain_bytes - 300_000)

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
        old = ".local/state/pxpl5/job-0.txt"
        self.cluster.login(["sh", "-c", f"mkdir -p -m 700 .local/state/pxpl5; touch -d @1 {old}"])
        job = self.cluster.login(["sbatch", "--parsable", "-N3", script, "phantom:sphere"],
                                 env={"PXPL5": PXPL5}).stdout.strip()
        # No event tells another computer that the file has grown.
        wait = (f"until grep -q 'ends it' .local/state/pxpl5/job-{job}.txt 2>/dev/null; do "
                f"[ \"$(squeue -h -j {job} -o %T)\" ] || exit 1; sleep 0.1; done; "
                f"cat .local/state/pxpl5/job-{job}.txt; stat -c 'mode %a' .local/state/pxpl5/job-*")
        told = self.cluster.login(["sh", "-c", wait], check=False, timeout=LIMIT_S)
        self.assertEqual(told.returncode, 0, self.cluster.login(["cat", f"pxpl5-{job}.out"]).stdout)
        self.assertIn("mode 600", told.stdout)
        self.cluster.login(["test", "!", "-e", old])
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

    def test_a_job_says_that_its_time_is_nearly_over(self):
        script = ROOT / "host/slurm-session.sbatch"
        job = self.cluster.login(["sbatch", "--parsable", "-N2", "--time=2", script,
                                  "phantom:sphere"], env={"PXPL5": PXPL5}).stdout.strip()
        wait = (f"until grep -q 'session is saved' pxpl5-{job}.out 2>/dev/null; do "
                f"[ \"$(squeue -h -j {job} -o %T)\" ] || exit 1; sleep 0.1; done; "
                f"scontrol show job {job}")
        told = self.cluster.login(["sh", "-c", wait], check=False, timeout=LIMIT_S)
        out = self.cluster.login(["cat", f"pxpl5-{job}.out"]).stdout
        self.assertEqual(told.returncode, 0, out)
        end = re.search(r" EndTime=(\S+)", told.stdout)[1]
        at = re.search(rf"warning: This session ends at (\S+)Z: job {job} reaches its time limit",
                       out)
        local = time.mktime(time.strptime(end, "%Y-%m-%dT%H:%M:%S"))
        self.assertEqual(at[1], time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(local)))
        file = re.search(r"Open it again with: pxpl5 serve --session (\S+)", out)[1]
        self.assertIn("load phantom:sphere", self.cluster.login(["cat", file]).stdout)
        listed = self.cluster.login([PXPL5, "sessions", "--json"]).stdout
        one, = [each for each in json.loads(listed)["sessions"] if each["job"] == job]
        self.assertEqual((one["subcommand"], one["here"], one["volume"]),
                         ("serve", False, "phantom:sphere"))
        refused = self.cluster.login([PXPL5, "sessions", "end", one["name"]], check=False)
        self.assertEqual(refused.returncode, 69)
        self.assertIn(f"Run 'scancel {job}'", refused.stderr)
        self.cluster.login(["scancel", job])
        self.cluster.wait_until_idle()

    def test_a_killed_host_leaves_nothing(self):
        for words, before in ((SSH, ()), (SLURM, IN_JOB)):
            with self.subTest(words=words):
                machine = self.start(*words, *FOUR_GPS, before=before)
                self.cluster.login(["pkill", "-9", "-f", "pxpl5 run"])
                machine.communicate(timeout=LIMIT_S)
                self.cluster.wait_until_idle()

    def test_a_killed_srun(self):
        for words, code in ((ENDS, 137), ((), 0)):
            with self.subTest(words=words):
                machine = self.start(*SLURM, *words, *FOUR_GPS, before=IN_JOB)
                self.cluster.login(["pkill", "-9", "-o", "-x", "srun"])
                ended, out, complaint = self.end_of(machine)
                self.assertEqual(ended, code, complaint)
                self.assertIn("engine-slurm was killed by signal 9", complaint)
                self.assertNotIn("goes on without computer", complaint)
                self.assertEqual(len(out.splitlines()), 1, out)
                self.cluster.wait_until_idle()

    def test_the_time_limit_of_a_job(self):
        machine = self.start(*SLURM, *ENDS, *FOUR_GPS, before=IN_JOB)
        self.cluster.login(["scancel", "--signal=TERM", "--me"])
        code, _, complaint = self.end_of(machine)
        self.assertEqual(code, 69, complaint)
        self.assertRegex(complaint, r"is lost with computer n\d: pxpl5 join got SIGTERM there")


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
