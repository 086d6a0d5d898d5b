#!/usr/bin/env python3
"""Nodes that hang or die, as a user meets them: test_liveness.py BIN_DIR [unittest's words]."""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from processes import ENDS, children_of, name_of

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
QUICK = ("--set", "heartbeat.interval_ms=100", "--set", "heartbeat.misses=20", *ENDS)
QUICK_INTERVAL_S = 0.1
QUICK_LIMIT_S = QUICK_INTERVAL_S * 20
PATIENT = ("--set", "heartbeat.interval_ms=100", "--set", "heartbeat.misses=1000")
NODES = {"gp-0": "pxpl5-gp", "renderer-0": "pxpl5-renderer", "framebuffer-0": "pxpl5-framebuff"}
TIMEOUT_CODE = 124
LIMIT_S = 120


class Conversation:
    """`pxpl5 run --json -` with commands one after another."""

    def __init__(self, folder, *words, **options):
        self.folder = folder
        environment = {**os.environ, "XDG_RUNTIME_DIR": str(folder)}
        self.process = subprocess.Popen(
            [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder",
             folder / "run", *words, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, env=environment, **options)

    def say(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def answer(self):
        line = self.process.stdout.readline()
        return json.loads(line) if line else None

    def ask(self, line):
        self.say(line)
        return self.answer()

    def node(self, name):
        """The process of that name."""
        return next(pid for pid in children_of(self.process.pid) if name_of(pid) == NODES[name])

    def end(self):
        """Exit code and standard error."""
        self.process.stdin.close()
        self.process.stdin = None
        _, complaint = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode, complaint

    def kill(self):
        """After a test that failed, too."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


class Liveness(unittest.TestCase):
    """Each test has a folder of its own, with the run and the sockets."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def talk(self, *words, **options):
        conversation = Conversation(self.folder, *words, **options)
        self.addCleanup(conversation.kill)
        self.assertTrue(conversation.ask("load phantom:sphere")["ok"])
        self.assertTrue(conversation.ask("surface bone iso=0")["ok"])
        return conversation

    def test_a_stopped_node_is_named_in_every_phase(self):
        """On standard error and in the answer, with exit code 124, and no process is left."""
        phases = {"gp-0": ["load phantom:torus", "surface bone iso=0.2", "digest"],
                  "renderer-0": ["digest", "orbit 4"],
                  "framebuffer-0": [f"snapshot {self.folder}/p.png", "digest"]}
        for node, commands in phases.items():
            for command in commands:
                with self.subTest(node=node, command=command):
                    talk = self.talk(*QUICK)
                    children = children_of(talk.process.pid)
                    os.kill(talk.node(node), signal.SIGSTOP)
                    answer = talk.ask(command)
                    self.assertEqual(answer["command"], command)
                    self.assertFalse(answer["ok"])
                    self.assertRegex(answer["error"],
                                     rf"^{node} \(process \d+\) does not answer: last heard "
                                     r"[\d.]+ s ago while .*the process is stopped")
                    self.assertEqual(answer["exit_code"], TIMEOUT_CODE)
                    code, complaint = talk.end()
                    self.assertEqual(code, TIMEOUT_CODE)
                    self.assertRegex(complaint, rf"warning: {node} .* has not answered for")
                    self.assertRegex(complaint, rf"error: {node} .* does not answer")
                    for pid in children:
                        self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())

    def test_a_stopped_second_frame_buffer_is_named_when_its_eye_is_missing(self):
        talk = self.talk(*QUICK, "--set", "frame_buffer.count=2")
        self.assertTrue(talk.ask("digest")["ok"])
        self.assertTrue(talk.ask("stereo sbs")["ok"])
        first, second = [pid for pid in children_of(talk.process.pid)
                         if name_of(pid) == NODES["framebuffer-0"]]
        os.kill(max(first, second), signal.SIGSTOP)
        answer = talk.ask("digest")
        self.assertRegex(answer["error"], r"^framebuffer-1 \(process \d+\) does not answer: ")
        self.assertEqual(answer["exit_code"], TIMEOUT_CODE)
        self.assertEqual(talk.end()[0], TIMEOUT_CODE)

    def test_a_node_that_stops_while_the_host_waits_for_a_line_is_named(self):
        talk = self.talk(*QUICK)
        os.kill(talk.node("renderer-0"), signal.SIGSTOP)
        answer = talk.answer()
        self.assertEqual(answer["command"], "")
        self.assertRegex(answer["error"], r"^renderer-0 .* while it waited for messages")
        self.assertEqual(talk.end()[0], TIMEOUT_CODE)

    def test_a_node_that_continues_in_time_draws_the_same_picture(self):
        for node in NODES:
            with self.subTest(node=node):
                talk = self.talk(*PATIENT)
                self.assertTrue(talk.ask("view 0 0")["ok"])
                digest = talk.ask("digest")["result"]
                pid = talk.node(node)
                os.kill(pid, signal.SIGSTOP)
                talk.say("view 20 20")
                talk.say("view 0 0")
                talk.say("digest")
                self.assertRegex(talk.process.stderr.readline(), f"warning: {node} ")
                os.kill(pid, signal.SIGCONT)
                self.assertTrue(talk.answer()["ok"])
                self.assertTrue(talk.answer()["ok"])
                self.assertEqual(talk.answer()["result"], digest)
                self.assertEqual(talk.end(), (0, ""))

    def test_a_host_that_was_stopped_blames_no_node(self):
        talk = self.talk(*QUICK)
        nodes = {name: talk.node(name) for name in NODES}
        warnings = talk.process.stderr
        os.kill(nodes["gp-0"], signal.SIGSTOP)
        self.assertRegex(warnings.readline(), "gp-0 .* has not answered")
        for pid in [talk.process.pid, *nodes.values()]:
            os.kill(pid, signal.SIGSTOP)
        stopped = time.monotonic()
        # Beside work, as on a busy computer.
        while time.monotonic() - stopped < 1.5 * QUICK_LIMIT_S:
            subprocess.run([BIN / "pxpl5", "run", "--run-folder", self.folder / "other", "-c",
                            "load phantom:pelvis; surface skin iso=-300; orbit 40"], check=True,
                           stdout=subprocess.DEVNULL, timeout=LIMIT_S)
        continued = time.monotonic()
        os.kill(talk.process.pid, signal.SIGCONT)
        warning = warnings.readline()  # The other nodes are still stopped.
        silence = re.search(r"r-0 .* has not answered for ([\d.]+) s", warning)
        self.assertTrue(silence, warning)
        # The silence begins at most one interval before the host continues. It is rounded to 0.1 s.
        longest = time.monotonic() - continued + QUICK_INTERVAL_S + 0.06
        self.assertLessEqual(float(silence[1]), longest, warning)
        for pid in nodes.values():
            os.kill(pid, signal.SIGCONT)
        self.assertTrue(talk.ask("digest")["ok"])
        self.assertEqual(talk.end()[0], 0)

    def test_removed_sockets_are_named(self):
        talk = self.talk(*QUICK)
        for folder in self.folder.glob("pxpl5-*"):
            shutil.rmtree(folder)
        answer = talk.ask("digest")  # The first frame opens connections.
        self.assertIn("because the socket /", answer["error"])
        self.assertIn("was removed", answer["error"])
        self.assertEqual(talk.end()[0], 1)

    def test_the_command_under_which_the_machine_dies_gets_its_object(self):
        """From -c, from a script and from a pipe."""
        lines = ["load phantom:sphere", "surface bone iso=0", "kill gp-0", "digest", "stats"]
        script = self.folder / "script"
        script.write_text("\n".join(lines) + "\n")
        run = [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder",
               self.folder / "run", *ENDS]
        for words, text in ((["-c", "; ".join(lines)], None), ([script], None),
                            (["-"], script.read_text())):
            with self.subTest(words=words):
                done = subprocess.run([*run, *words], input=text, capture_output=True, text=True,
                                      check=False, timeout=LIMIT_S)
                answers = [json.loads(line) for line in done.stdout.splitlines()]
                self.assertEqual([each["command"] for each in answers], lines[:4])
                self.assertEqual([each["ok"] for each in answers], [True, True, True, False])
                self.assertIn("gp-0 was killed by signal 9", answers[3]["error"])
                self.assertEqual(answers[3]["exit_code"], 137)
                self.assertEqual(done.returncode, 137)

    def test_few_descriptors_are_refused_by_name(self):
        """Before any process is started, for every limit from nearly none."""
        def limit(count):
            return lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (count, count))
        for count in (16, 24, 32):
            done = subprocess.run([BIN / "pxpl5", "run", "--run-folder", self.folder / "run", "-c",
                                   "load phantom:sphere"], capture_output=True, text=True,
                                  check=False, timeout=LIMIT_S, preexec_fn=limit(count))
            with self.subTest(count=count):
                self.assertEqual(done.returncode, 69)
                self.assertRegex(done.stderr, r"error: a machine of \d+ nodes needs \d+ file "
                                 rf"descriptors, but the hard limit is {count}\. Raise")

    def test_a_parent_that_blocks_the_signal_of_dead_children_does_no_harm(self):
        def block():
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGCHLD])
        done = subprocess.run([BIN / "pxpl5", "run", "--run-folder", self.folder / "run", "-c",
                               "load phantom:sphere"], check=False, timeout=LIMIT_S,
                              stdout=subprocess.DEVNULL, preexec_fn=block)
        self.assertEqual(done.returncode, 0)


if __name__ == "__main__":
    unittest.main()
