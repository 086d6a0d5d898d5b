"""A running pxpl5 that takes commands and answers with JSON, one at a time."""
import json
import subprocess
import sys
import tempfile
import time
from typing import Callable, List, Optional


class MeasureError(Exception):
    """Nothing can be measured, for a reason that its text tells whoever asked."""


class CommandFailed(MeasureError):
    """A command was refused, or pxpl5 ended. Says the command and why."""


def parse_answer(line: str, command: str) -> dict:
    """The result in an answering line. Raises CommandFailed if it is not one, or tells an error."""
    try:
        answer = json.loads(line)
    except json.JSONDecodeError as error:
        raise CommandFailed(f"'{command}': the answer is not JSON: {line[:200]!r}") from error
    if not answer.get("ok"):
        raise CommandFailed(f"'{command}': {answer.get('error', line)}")
    return answer["result"]


def run_line(machine, line: str) -> dict:
    """The result of a command of `machine`, a program with pipes. Raises CommandFailed."""
    machine.stdin.write(line + "\n")
    machine.stdin.flush()
    answer = machine.stdout.readline()
    if not answer:
        raise CommandFailed(f"'{line}': pxpl5 has ended: {machine.stderr.read()}")
    return parse_answer(answer, line)


class Session:
    """pxpl5 run --json on one topology, fed through its standard input.

    settings  As of --set: ["gp.count=3"].
    record    off, flight or full.
    """

    def __init__(self, program: str, topology: str = "default", record: str = "flight",
                 settings: Optional[List[str]] = None):
        self._folder = tempfile.TemporaryDirectory(prefix="pxpl5-bench-")
        self._errors = tempfile.TemporaryFile(mode="w+")
        command = [program, "run", "--json", "--topology", topology, "--record", record,
                   "--run-folder", self._folder.name]
        for setting in settings or []:
            command += ["--set", setting]
        self.started_s = time.perf_counter()
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=self._errors, text=True)
        except OSError as error:
            raise MeasureError(f"{program}: {error.strerror}; give the path of pxpl5") from None

    def send(self, command: str):
        """Hands a command over without waiting for its answer."""
        try:
            self.process.stdin.write(command + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            raise CommandFailed(f"'{command}': pxpl5 has ended: {self._told()}") from None

    def answer(self, command: str) -> dict:
        """The next answer: that of `command`."""
        line = self.process.stdout.readline()
        if not line:
            raise CommandFailed(f"'{command}': pxpl5 has ended: {self._told()}")
        return parse_answer(line, command)

    def run(self, command: str) -> dict:
        """The result of a command. Raises CommandFailed."""
        self.send(command)
        return self.answer(command)

    def _told(self) -> str:
        self.process.wait()
        self._errors.seek(0)
        return self._errors.read().strip() or f"exit code {self.process.returncode}"

    def close(self):
        """Ends the machine and waits until it has gone."""
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()
        self._errors.close()
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def told_errors(main: Callable[[], int]) -> int:
    """main()'s exit code; what cannot be measured is one line on standard error, and 65."""
    try:
        return main()
    except (MeasureError, subprocess.CalledProcessError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 65
