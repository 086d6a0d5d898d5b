#!/usr/bin/env python3
"""Computers that join a machine, all of them on this one: test_join.py BIN_DIR [unittest's].

Over loopback and with the engines `command` and `wait`. tests/cluster has several computers.
"""
import json
import os
import pathlib
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from processes import ENDS, children_of, name_of

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 120
LOOPBACK = ("--set", "listen=127.0.0.1")
BY_COMMAND = ("--engine", "command", "--set", "engine_command={join}", *LOOPBACK)
SCENE = ["load phantom:pelvis", "surface skin iso=-300 opacity=0.5", "surface bone iso=250",
         "view 30 20 zoom=1.5", "size 200x160", "digest", "certificate bone"]


def in_tree(pid):
    """The processes that `pid` has started, and those that they have started."""
    for child in children_of(pid):
        yield child
        yield from in_tree(child)


def processor_s(pid):
    """The time that the process has computed."""
    words = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return sum(map(int, words[11:13])) / os.sysconf("SC_CLK_TCK")


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(each) for key, each in value.items()
                if not key.endswith("_ms")}
    return [without_times(each) for each in value] if isinstance(value, list) else value


class Joins(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.env = {**os.environ, "XDG_RUNTIME_DIR": str(self.folder),
                    "TMPDIR": str(self.folder)}

    def run_lines(self, lines, *words):
        """Exit code, replies and standard error. Nothing may be left behind."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", *words, "-c",
             "; ".join(lines)], capture_output=True, text=True, check=False, timeout=LIMIT_S,
            env=self.env)
        self.assertEqual(list(self.folder.glob("pxpl5-*")), [], "folders are left")
        return done.returncode, [json.loads(line) for line in done.stdout.splitlines()], done.stderr

    def results(self, lines, *words):
        code, replies, complaint = self.run_lines(lines, *words)
        self.assertEqual([each["error"] for each in replies if not each["ok"]], [])
        self.assertEqual(code, 0, complaint)
        self.assertNotIn("dropped", complaint)
        return without_times([reply["result"] for reply in replies])

    def logs(self):
        (run,) = (self.folder / "run").iterdir()
        return run

    def refusal(self, *words, text=None):
        """Exit code and error of a pxpl5 join that fails."""
        done = subprocess.run([BIN / "pxpl5", "join", *words], capture_output=True, text=True,
                              input=text, check=False, timeout=LIMIT_S, env=self.env)
        return done.returncode, done.stderr.strip()

    def test_any_number_of_computers_gives_the_same_bits(self):
        nodes = ("--set", "gp.count=3", "--set", "renderer.count=2")
        alone = self.results(SCENE, *nodes)
        two = ("--engine", "command", *LOOPBACK, "--computers", "a:2,b:3", "--set",
               "placement=spread", "--set", "gp.computer=b,a", "--set", "engine_command=env",
               "--set", "engine_command=COMPUTER={computer}", "--set", "engine_command={join}")
        for words in ((*BY_COMMAND, "--set", "wait=1"), two):
            with self.subTest(words=words):
                self.assertEqual(self.results(SCENE, *nodes, *words), alone)

    def test_without_encryption_only_when_asked(self):
        plain = self.results(SCENE, *BY_COMMAND, "--set", "wait=1", "--insecure-tcp")
        self.assertEqual(plain, self.results(SCENE, *BY_COMMAND, "--set", "wait=1"))

    def test_logs_and_traces_come_to_the_host(self):
        self.results(["load phantom:sphere", "surface s iso=0", "digest", "trace save"],
                     *BY_COMMAND, "--set", "wait=1", "--set", "gp.count=2")
        run = self.logs()
        for name in ("gp-0", "gp-1", "renderer-0", "framebuffer-0"):
            for file in (run / f"{name}.log", run / "traces" / f"{name}.mcap"):
                self.assertTrue(file.is_file(), file)
                self.assertEqual(file.stat().st_mode & 0o777, 0o600, file)
        self.assertIn("pxpl5 join", (run / "engine-command.log").read_text())

    def test_a_dead_node_is_named_and_replaced(self):
        lines = ["load phantom:sphere", "surface s iso=0", "digest", "kill gp-1", "digest"]
        _, replies, complaint = self.run_lines(lines, *BY_COMMAND, "--set", "wait=1",
                                               "--set", "gp.count=2")
        self.assertEqual([each["ok"] for each in replies], [True] * 5, complaint)
        self.assertEqual(replies[2]["result"], replies[4]["result"])
        self.assertIn("gp-1 was killed by signal 9", replies[4]["restarts"][0]["cause"])

    def start(self, *words):
        """A machine at its prompt, after the first reply."""
        machine = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", *ENDS, *words,
             "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, env=self.env)
        self.addCleanup(machine.stdout.close)
        self.addCleanup(machine.stderr.close)
        self.addCleanup(machine.stdin.close)
        self.addCleanup(machine.kill)
        machine.stdin.write("load phantom:sphere\nsurface s iso=0\n")
        machine.stdin.flush()
        for _ in range(2):
            self.assertTrue(json.loads(machine.stdout.readline())["ok"])
        return machine

    def wait_for_end(self, pids):
        end = time.monotonic() + LIMIT_S
        for pid in pids:
            try:
                waiter = os.pidfd_open(pid)
            except ProcessLookupError:
                continue
            with os.fdopen(waiter) as ended:
                left = max(end - time.monotonic(), 0)
                self.assertTrue(select.select([ended], [], [], left)[0], f"{pid} still runs")

    def test_another_build_is_refused_and_the_right_one_joins(self):
        other = self.folder / "other"
        mine, theirs = b"pxpl5 {}, protocol", b"pxpl6 {}, protocol"
        program = (BIN / "pxpl5").read_bytes()
        self.assertEqual(program.count(mine), 1)
        other.write_bytes(program.replace(mine, theirs))
        other.chmod(0o700)
        machine = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", "--engine",
             "wait", "--set", "wait=1", *LOOPBACK, "-c", "load phantom:sphere"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.env)
        self.addCleanup(machine.kill)
        line = re.search(r": (/.*/pxpl5 join .*)$", machine.stderr.readline())[1].split()
        builds = "it has build 'pxpl6 .*, the host build 'pxpl5 "
        refused = subprocess.run([other, *line[1:]], capture_output=True, text=True, check=False,
                                 timeout=LIMIT_S, env=self.env)
        self.assertEqual(refused.returncode, 69)
        self.assertRegex(refused.stderr, f"refuses this computer: {builds}")
        subprocess.run(line, check=True, timeout=LIMIT_S, env=self.env)
        _, complaint = machine.communicate(timeout=LIMIT_S)
        self.assertEqual(machine.returncode, 0, complaint)
        self.assertRegex(complaint, f"was refused: {builds}")

    def end_after(self, number):
        """Exit code and standard error of a machine whose join gets a signal. No node is left."""
        machine = self.start(*BY_COMMAND, "--set", "wait=1")
        nodes = list(in_tree(machine.pid))
        (join,) = [pid for pid in children_of(machine.pid) if name_of(pid) == "pxpl5"]
        os.kill(join, number)
        _, complaint = machine.communicate("digest\n", timeout=LIMIT_S)
        self.wait_for_end(nodes)
        return machine.returncode, complaint

    def test_a_dead_join_is_a_lost_computer(self):
        code, complaint = self.end_after(signal.SIGKILL)
        self.assertRegex(complaint, r"(gp-0|renderer-0) is lost with computer \S+: it has not "
                                    r"answered for|engine-command was killed by signal 9")
        self.assertNotEqual(code, 0)

    def test_a_stopped_join_is_a_lost_computer(self):
        code, complaint = self.end_after(signal.SIGSTOP)
        self.assertRegex(complaint, r"(gp-0|renderer-0) is lost with computer \S+: it has not "
                                    r"answered for [01]\.\d s")
        self.assertEqual(code, 69)

    def test_a_join_that_is_told_to_end_says_so(self):
        code, complaint = self.end_after(signal.SIGTERM)
        self.assertRegex(complaint, r"is lost with computer \S+: pxpl5 join got SIGTERM there")
        self.assertEqual(code, 69)

    def test_nothing_is_left_when_the_host_is_killed(self):
        machine = self.start(*BY_COMMAND, "--set", "wait=1")
        nodes = list(in_tree(machine.pid))
        self.assertGreaterEqual(len(nodes), 4)
        machine.kill()
        machine.wait(timeout=LIMIT_S)
        self.wait_for_end(nodes)

    def test_computers_join_by_hand(self):
        machine = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", "--engine",
             "wait", "--set", "wait=1", *LOOPBACK, "-c", "load phantom:sphere"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.env)
        self.addCleanup(machine.kill)
        line = machine.stderr.readline()
        words = re.search(r": (/.*/pxpl5 join .*)$", line).group(1).split()
        address, key = words[2], pathlib.Path(words[4])
        self.assertEqual(key.stat().st_mode & 0o777, 0o600)

        code, complaint = self.refusal(address, "--key-stdin", text=self.other_key(key))
        self.assertEqual(code, 69)
        self.assertRegex(complaint, r"the host at tcp://127.0.0.1:\d+ does not accept this key")

        damaged = key.read_text().split()
        damaged[-1] = damaged[-1][::-1]
        code, complaint = self.refusal(address, "--key-stdin", text=" ".join(damaged) + "\n")
        self.assertEqual(code, 64)
        self.assertIn("standard input has a damaged key: its two parts of 40 characters", complaint)

        wide = self.folder / "wide.key"
        wide.write_text(key.read_text())
        wide.chmod(0o644)
        code, complaint = self.refusal(address, "--key-file", wide)
        self.assertEqual(code, 64)
        self.assertIn("chmod 600", complaint)

        join = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, env=self.env)
        self.addCleanup(join.kill)
        out, complaint = machine.communicate(timeout=LIMIT_S)
        self.assertTrue(json.loads(out)["ok"], complaint)
        self.assertEqual(machine.returncode, 0, complaint)
        self.assertIn("warning: a program without the key of this machine has connected to port "
                      + address.rsplit(":", 1)[1], complaint)
        _, said = join.communicate(timeout=LIMIT_S)
        self.assertEqual(join.returncode, 0, said)
        self.assertIn("takes part in the machine at", said)

    def test_a_host_that_waits_does_not_compute(self):
        machine = subprocess.Popen(
            [BIN / "pxpl5", "run", "--run-folder", self.folder / "run", "--engine", "wait",
             "--set", "wait=1", *LOOPBACK, "-c", "digest"], stderr=subprocess.PIPE, env=self.env)
        self.addCleanup(machine.stderr.close)
        self.addCleanup(machine.kill)
        machine.stderr.readline()
        before_s = processor_s(machine.pid)
        self.assertEqual(select.select([machine.stderr], [], [], 2)[0], [])  # It is quiet.
        self.assertLess(processor_s(machine.pid) - before_s, 0.2)

    def test_a_computer_joins_again_with_a_key_of_the_user(self):
        """After the death of a node, and after that of a host with the same key and port."""
        key = self.folder / "key"
        made = subprocess.run([BIN / "pxpl5", "key"], stdout=subprocess.PIPE, check=True)
        key.write_bytes(made.stdout)
        key.chmod(0o400)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        join = subprocess.Popen(
            [BIN / "pxpl5", "join", f"tcp://localhost:{port}", "--key-file", key, "--again",
             "--wait", str(LIMIT_S)], stderr=subprocess.PIPE, text=True, env=self.env)
        self.addCleanup(join.stderr.close)
        self.addCleanup(join.kill)
        self.assertIn("waits for the host at", join.stderr.readline())
        words = ("--engine", "wait", "--set", "wait=1", "--listen", f"127.0.0.1:{port}",
                 "--key-file", key)
        machine = self.start(*words)
        nodes = list(in_tree(join.pid))
        self.assertGreaterEqual(len(nodes), 3)
        machine.kill()
        machine.wait(timeout=LIMIT_S)
        lines = ["load phantom:sphere", "surface s iso=0", "digest", "kill gp-0", "digest"]
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--run-folder", self.folder / "run", *words, "-c",
             "; ".join(lines)], capture_output=True, text=True, check=False, timeout=LIMIT_S,
            env=self.env)
        self.assertEqual(done.returncode, 0, done.stderr)
        replies = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(replies[2]["result"], replies[4]["result"])
        self.assertNotIn(made.stdout.decode().split()[-1], done.stderr)
        self.wait_for_end(nodes)
        join.terminate()
        self.assertEqual(join.wait(timeout=LIMIT_S), 128 + signal.SIGTERM)

    def other_key(self, key):
        """The key of another session: the pair of another machine."""
        run = self.folder / "other"
        other = subprocess.Popen(
            [BIN / "pxpl5", "run", "--run-folder", run, "--engine", "wait", "--set", "wait=1",
             *LOOPBACK, "-c", "quit"], stderr=subprocess.PIPE, text=True, env=self.env)
        self.addCleanup(other.kill)
        line = other.stderr.readline()
        text = pathlib.Path(line.split()[-1]).read_text()
        other.send_signal(signal.SIGINT)
        other.communicate(timeout=LIMIT_S)
        self.assertNotEqual(text, key.read_text())
        return text

    def test_no_host_no_key_no_address(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        key = "pxpl5-key-1 11 " + "0" * 32 + " - -\n"
        code, complaint = self.refusal(f"tcp://localhost:{port}", "--key-stdin", "--wait", "1",
                                       text=key)
        self.assertEqual(code, 69)
        self.assertIn(f"no host answers at tcp://localhost:{port} within 1 s: no program listens "
                      f"at port {port} of 127.0.0.1", complaint)
        code, complaint = self.refusal(f"tcp://127.0.0.1:{port}", "--key-stdin", text="hello\n")
        self.assertEqual((code, "standard input has no key" in complaint), (64, True), complaint)
        code, complaint = self.refusal(f"tcp://127.0.0.1:{port}", "--key-stdin", text="")
        self.assertIn("standard input ended after 0 bytes", complaint)
        for address in ("127.0.0.1:80", "tcp://127.0.0.1", "tcp://a b:80", "tcp://1.2.3.4:0"):
            code, complaint = self.refusal(address, "--key-stdin", text=key)
            self.assertEqual(code, 64, address)


if __name__ == "__main__":
    unittest.main()
