#!/usr/bin/env python3
"""A stranger at the tcp ports of a running machine: nothing changes, and the machine goes on.

The stranger sends text, garbage and orders, has a key of its own, or plays again what it recorded.

usage: test_strangers.py BIN    BIN is the folder of pxpl5
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve()
sys.path[:0] = [str(HERE.parent), str(HERE.parents[2] / "cluster")]
from processes import children_of  # noqa: E402
from stranger import (ATTACKS, MOST_ANSWER_BYTES, STRANGER, Recorder, refused_with_own_key, speak,
                      steps_of)  # noqa: E402

LOOPBACK = "127.0.0.1"
LIMIT_S = 60
SCENE = "load phantom:sphere; surface s iso=0"


def ports(pid):
    """The tcp ports at which a process listens."""
    inodes = set()
    for entry in os.listdir(f"/proc/{pid}/fd"):
        try:
            inodes.add(os.readlink(f"/proc/{pid}/fd/{entry}"))
        except OSError:
            pass
    found = []
    for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
        words = line.split()
        if words[3] == "0A" and f"socket:[{words[9]}]" in inodes:
            found.append(int(words[1].split(":")[1], 16))
    return found


def attack(port, steps):
    """Sends `steps`, as another user if this is root. Returns how many bytes came back."""
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            if os.geteuid() == 0:
                os.setgid(65534)
                os.setuid(65534)
            os.write(write_end, str(speak(LOOPBACK, port, steps)).encode())
        finally:
            os._exit(0)
    os.close(write_end)
    with os.fdopen(read_end) as told:
        text = told.read()
    os.waitpid(child, 0)
    return int(text)


class Strangers(unittest.TestCase):
    def run_attacked(self, flags, attack_all):
        with tempfile.TemporaryDirectory() as folder:
            command = [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder", folder,
                       *flags, "-"]
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True) as host:
                host.stdin.write(SCENE.replace("; ", "\n") + "\n")
                host.stdin.flush()
                said = [host.stdout.readline()]
                while not said[-1].startswith("s: isovalue"):
                    self.assertTrue(said[-1], "the machine ended early")
                    said.append(host.stdout.readline())
                listening = [port for pid in [host.pid, *children_of(host.pid)]
                             for port in ports(pid)]
                self.assertGreaterEqual(len(listening), 4)
                attack_all(listening)
                out, errors = host.communicate("digest\nquit\n", LIMIT_S)
                self.assertEqual(host.returncode, 0, errors)
                logs = "".join(log.read_text() for log in pathlib.Path(folder).glob("*/*.log"))
                return out, errors, logs

    def quiet_digest(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder", folder,
                       "-c", SCENE + "; digest"]
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S,
                                  check=True)
            return [line for line in done.stdout.splitlines() if line.startswith("frame ")]

    def attack_all(self, listening):
        for name, steps in ATTACKS.items():
            for port in listening:
                self.assertLessEqual(attack(port, steps), MOST_ANSWER_BYTES, name)

    def check(self, flags, named, attack_all=None):
        out, errors, logs = self.run_attacked(["--set", "ring.transport=tcp", *flags],
                                              attack_all or self.attack_all)
        frames = [line for line in out.splitlines() if line.startswith("frame ")]
        self.assertEqual(frames, self.quiet_digest())
        self.assertIn("warning: the ring dropped", errors)
        self.assertIn("without a lawful sender", errors)
        for text in named:
            self.assertIn(text, logs)

    def test_with_keys(self):
        self.check([], ["without the key of this session"])

    def test_with_another_key(self):
        def connect_all(listening):
            for port in listening:
                self.assertTrue(refused_with_own_key(LOOPBACK, port))
        self.check([], ["without the key of this session"], connect_all)

    @unittest.skipUnless(os.geteuid() == 0, "only root can record what others send")
    def test_with_recorded_messages(self):
        recorder = Recorder("lo")

        def play_again(listening):
            streams = recorder.streams()
            ends = {port: streams[f"{LOOPBACK}:{port}"] for port in listening}
            # No io process has connected to the host's socket for them.
            (quiet,) = [port for port in listening if not ends[port]]
            ends[quiet] = [stream for of_port in ends.values() for stream in of_port]
            for port, of_port in ends.items():
                for stream in of_port:
                    for steps in steps_of(stream):
                        self.assertLessEqual(attack(port, steps), MOST_ANSWER_BYTES)
        try:
            self.check([], ["without the key of this session"], play_again)
        finally:
            recorder.streams()

    def test_without_keys(self):
        self.check(["--insecure-tcp"],
                   [f"Shutdown from node {STRANGER}, which is not a node of this machine",
                    "a message of 1 parts with a header of 5 bytes"])


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop()).resolve()
    unittest.main()
