#!/usr/bin/env python3
"""The prompt of `pxpl5 run` at a terminal: test_prompt_cli.py BIN_DIR."""
import os
import pathlib
import pty
import re
import select
import signal
import sys
import tempfile
import unittest

from processes import ENDS, children_of, name_of

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 120


def signal_renderer(pid, number):
    os.kill(next(node for node in children_of(pid) if name_of(node) == "pxpl5-renderer"), number)


def kill_renderer(_, pid):
    signal_renderer(pid, signal.SIGKILL)


class Prompt(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def at_a_terminal(self, act, *words):
        """Runs the prompt and act(terminal, pid) when it is there. Returns exit code and screen."""
        pid, terminal = pty.fork()
        if pid == 0:
            os.chdir(self.folder.name)
            os.execve(BIN / "pxpl5", ["pxpl5", "run", "--topology", "one-of-each", *words],
                      {**os.environ, "TERM": "dumb", "XDG_RUNTIME_DIR": self.folder.name})
        screen = self.read_until(terminal, b"pxpl5> ")
        act(terminal, pid)
        screen += self.read_until(terminal, None)
        os.close(terminal)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        self.assertEqual(list(pathlib.Path(self.folder.name).glob("pxpl5-*")), [], "sockets")
        return code, screen.decode()

    def read_until(self, terminal, text):
        """The output up to `text`, or to the end."""
        screen = b""
        try:
            while text is None or text not in screen:
                self.assertTrue(select.select([terminal], [], [], LIMIT_S)[0], screen)
                part = os.read(terminal, 4096)
                if not part:
                    break
                screen += part
        except OSError:
            pass  # Linux says EIO when the other side is gone.
        self.assertTrue(text is None or text in screen, screen)
        return screen

    def test_the_prompt_takes_commands_and_quit(self):
        code, screen = self.at_a_terminal(
            lambda terminal, _: os.write(terminal, b"load phantom:sphere\nquit\n"))
        self.assertEqual(code, 0, screen)
        self.assertIn("distributed in", screen)

    def test_ctrl_c_at_the_prompt_ends_the_program_as_an_interrupt(self):
        code, screen = self.at_a_terminal(lambda terminal, _: os.write(terminal, b"\x03"))
        self.assertEqual(code, 128 + 2, screen)
        self.assertIn("interrupted by SIGINT", screen)
        self.assertNotIn("still running", screen)

    def test_ctrl_c_during_a_command_ends_the_command_alone(self):
        def interrupt(terminal, _):
            os.write(terminal, b"load phantom:heart\nsurface blood iso=70\n")
            self.read_until(terminal, b"triangles")
            for command in (b"curve\n", b"orbit 2000\n", b"cine f{}.png\n"):
                os.write(terminal, command)
                self.read_until(terminal, b"(Ctrl-C cancels)")
                os.write(terminal, b"\x03")
                self.read_until(terminal, b"canceled")
            os.write(terminal, b"time\ncertificate\nquit\n")
        code, screen = self.at_a_terminal(interrupt)
        self.assertEqual(code, 0, screen)
        self.assertIn("volume 1 of 30", screen)
        self.assertIn("blood", screen)

    def test_a_line_has_several_commands(self):
        code, screen = self.at_a_terminal(lambda terminal, _: os.write(
            terminal, b"load phantom:sphere; surface a iso=0.5  # a; surface b iso=0.6\n"
                      b"surface c iso=0.7; surface d iso=0.8;\nhistory; quit; remove a\n"))
        self.assertEqual(code, 0, screen)
        told = screen.rsplit("history; quit; remove a", 1)[1]
        self.assertEqual(re.findall(r"\nsurface (\w)", told), ["a", "c", "d"], screen)

    def test_a_line_ends_with_the_command_that_fails_or_is_canceled(self):
        def act(terminal, _):
            os.write(terminal, b"load phantom:heart; surface blood iso=70\n")
            self.read_until(terminal, b"triangles")
            os.write(terminal, b"orbit 2000; export left-out.ply\n")
            self.read_until(terminal, b"(Ctrl-C cancels)")
            os.write(terminal, b"\x03")
            self.read_until(terminal, b"canceled")
            os.write(terminal, b"nonsense; surface other iso=71\nexport made.ply\nhistory; quit\n")
        code, screen = self.at_a_terminal(act)
        self.assertEqual(code, 0, screen)
        self.assertEqual([path.name for path in pathlib.Path(self.folder.name).glob("*.ply")],
                         ["made.ply"])
        self.assertNotIn("surface other", screen.rsplit("history; quit", 1)[1])

    def test_a_notice_leaves_the_typed_text(self):
        def act(terminal, pid):
            os.write(terminal, b"load phantom:sphere; vi")
            self.read_until(terminal, b"; vi")
            signal_renderer(pid, signal.SIGSTOP)
            stopped = self.read_until(terminal, b"pxpl5> load phantom:sphere; vi")
            self.assertIn(b"warning: renderer-0 (process ", stopped)
            signal_renderer(pid, signal.SIGKILL)
            killed = self.read_until(terminal, b"pxpl5> load phantom:sphere; vi")
            self.assertIn(b"note: The machine runs again", killed)
            os.write(terminal, b"ew 10 20; quit\n")
        code, screen = self.at_a_terminal(act, "--set", "heartbeat.interval_ms=50", "--set",
                                          "heartbeat.misses=1000")
        self.assertEqual(code, 0, screen)
        self.assertIn("distributed in", screen)

    def test_errors_and_warnings_begin_at_the_left_border(self):
        """They clear a progress bar, and ^C, which stand in their line."""
        def act(terminal, pid):
            os.write(terminal, b"load phantom:heart\nsurface blood iso=70\norbit 2000\n")
            self.read_until(terminal, b"(Ctrl-C cancels)")
            kill_renderer(terminal, pid)
            restart = self.read_until(terminal, b"note: The machine runs again")
            os.write(terminal, b"\x03")
            for word, screen in (("warning", restart), ("note", restart),
                                 ("error", self.read_until(terminal, b"error: "))):
                self.assertIn(f"\r\x1b[K{word}: ".encode(), screen)
            os.write(terminal, b"quit\n")
        self.at_a_terminal(act)

    def test_a_node_killed_at_the_prompt_is_replaced(self):
        def kill(terminal, pid):
            kill_renderer(terminal, pid)
            self.read_until(terminal, b"The machine runs again")
            os.write(terminal, b"load phantom:sphere\nquit\n")
        code, screen = self.at_a_terminal(kill)
        self.assertEqual(code, 0, screen)
        self.assertIn("distributed in", screen)

    def test_a_node_killed_at_the_prompt_ends_the_program_if_the_plan_says_so(self):
        code, screen = self.at_a_terminal(kill_renderer, *ENDS)
        self.assertEqual(code, 128 + 9, screen)
        self.assertIn("renderer-0 was killed by signal 9", screen)


if __name__ == "__main__":
    unittest.main(verbosity=2)
