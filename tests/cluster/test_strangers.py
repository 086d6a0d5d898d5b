#!/usr/bin/env python3
"""Strangers in the network of a machine on several computers: nothing is learned or changed.

The stranger is another user, on a computer of the machine or on one beside it. It sends text,
garbage and orders, has a key of its own, or plays again what went over the network.

usage: test_strangers.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import json
import pathlib
import re
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from cluster import Cluster, OTHER_USER, USER, missing  # noqa: E402
from stranger import MOST_ANSWER_BYTES  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
STRANGER = (sys.executable, "-B", str(HERE / "stranger.py"))
LIMIT_S = 120
PARTS = ("login", "n1")  # The computers of the machine. n2 is beside it.
MACHINE = ("--engine", "ssh", "--computers", "n1", "--set", "placement=spread", "--set",
           "gp.count=2", "--set", "renderer.count=2")


class Strangers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(Cluster(computers=2, hosts_as_debian=True,
                                                    shared=[BIN]))

    def tearDown(self):
        if self.machine.poll() is None:
            self.machine.kill()
        self.cluster.wait_until_idle()

    def start(self):
        self.machine = self.cluster.popen(
            "login", [BIN / "pxpl5", "run", "--json", "--run-folder", "runs", *MACHINE, "-"],
            stdin=-1, stdout=-1, stderr=-1, text=True)
        for line in ("load phantom:sphere", "surface s iso=0"):
            self.ask(line)

    def ask(self, line):
        self.machine.stdin.write(line + "\n")
        self.machine.stdin.flush()
        reply = json.loads(self.machine.stdout.readline() or '{"ok": false, "error": "ended"}')
        self.assertTrue(reply["ok"], f"{line}: {reply}")
        return reply["result"]

    def stranger(self, computer, what, *words, **more):
        return self.cluster.on(computer, [*STRANGER, what, *words], timeout=LIMIT_S,
                               **{"user": OTHER_USER, **more}).stdout

    def ends(self):
        """Each port of the machine, as ADDRESS:PORT: where computers join, and those of nodes."""
        uid = self.cluster.login(["id", "-u"], user=USER).stdout.strip()
        found = []
        for computer in PARTS:
            text = self.cluster.on(computer, ["ip", "-4", "-o", "addr", "show", "eth0"]).stdout
            address = re.search(r"inet ([\d.]+)/", text)[1]
            ports = json.loads(self.stranger(computer, "listening", uid))
            self.assertGreaterEqual(len(ports), 2, computer)
            found += [f"{address}:{port}" for port in ports]
        return found

    def check(self, attack):
        """`attack` has no effect but that it is counted and named."""
        before = self.ask("digest")
        attack(self.ends())
        self.assertEqual(self.ask("digest"), before)
        out, complaint = self.machine.communicate("digest\n", timeout=LIMIT_S)
        self.assertEqual(self.machine.returncode, 0, complaint)
        self.assertEqual(json.loads(out)["result"], before)
        self.assertRegex(complaint, "a program without the key of this machine has connected to "
                                    r"port \d+, where computers join")
        self.assertRegex(complaint, r"the ring dropped a connection to tcp://[\d.]+:\d+ without "
                                    "the key of this session")
        self.assertRegex(complaint, r"the host dropped \d+ messages without a lawful sender")
        logs = "cat $(ls -td runs/*/ | head -1)"
        for node in ("gp-0", "gp-1", "renderer-0", "renderer-1", "framebuffer-0"):
            log = self.cluster.login(["sh", "-c", f"{logs}/{node}.log"]).stdout
            self.assertIn("without the key of this session", log, node)

    def check_answer(self, text):
        self.assertLessEqual(int(text), MOST_ANSWER_BYTES)

    def test_what_is_no_message_of_this_machine(self):
        self.start()

        def attack(ends):
            for computer in ("n1", "n2"):
                self.check_answer(self.stranger(computer, "attack", *ends))
        self.check(attack)

    def test_another_key(self):
        self.start()
        self.check(lambda ends: self.assertEqual(
            json.loads(self.stranger("n2", "keys", *ends)), [True] * len(ends)))

    def test_recorded_connections(self):
        """Also those of `pxpl5 join`, with the secret in its first letter."""
        recorder = self.cluster.popen("login", [*STRANGER, "record", "eth0"], user="root",
                                      stdin=-1, stdout=-1, text=True)
        self.assertEqual(recorder.stdout.readline(), "records\n")
        self.start()
        self.ask("digest")
        recorded, _ = recorder.communicate("", timeout=LIMIT_S)
        streams = json.loads(recorded)

        def attack(ends):
            self.assertGreaterEqual(len(set(streams) & set(ends)), 5, streams.keys())
            self.check_answer(self.stranger("n2", "play", *ends, input=recorded))
        self.check(attack)


if __name__ == "__main__":
    if reason := missing([BIN]):
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
