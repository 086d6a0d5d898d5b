"""Programs on the computers of a cluster, started from outside."""
import os
import pathlib
import select
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/cli"))
from processes import children_of  # noqa: E402

LIMIT_S = 30
# Reports that the program is inside, then becomes the program.
ENTER = 'fd=$1 folder=$2; echo >&$fd; exec {fd}>&-; cd "$folder" || exit 126; shift 2; exec "$@"'


class Program(subprocess.Popen):
    """A program on a computer. Signals reach the program itself, from kill() as well.

    A program that outlives its parent, or that has lost it, stays until its computer is off.
    """

    def __init__(self, first, argv, user, cwd, **more):
        """`first` is the first process of the computer."""
        entered_out, entered_in = os.pipe()
        self.inside = None  # A pidfd of the program.
        as_user = [] if user == "root" else [
            "setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups"]
        try:
            super().__init__(
                ["nsenter", f"--target={first}", "--mount", "--uts", "--ipc", "--net", "--pid",
                 "/bin/bash", "-c", ENTER, "bash", str(entered_in), str(cwd), *as_user,
                 *map(str, argv)], pass_fds=[entered_in, *more.pop("pass_fds", ())], **more)
        finally:
            os.close(entered_in)
        with open(entered_out, "rb") as entered:
            select.select([entered], [], [], LIMIT_S)
        for pid in children_of(self.pid):
            try:
                self.inside = os.pidfd_open(pid)
            except ProcessLookupError:
                pass  # It has ended already.

    def send_signal(self, sig):
        if self.poll() is None and self.inside is not None:
            try:
                signal.pidfd_send_signal(self.inside, sig)
            except ProcessLookupError:
                pass  # It has ended meanwhile.

    def __exit__(self, *_):
        """The end of a `with` block ends the program, also one that a failed test has left."""
        self.end()

    def end(self):
        """Ends the program, its process group, and the reading of what it writes."""
        self.kill()
        super().send_signal(signal.SIGKILL)
        self.wait(LIMIT_S)
        for stream in (self.stdin, self.stdout, self.stderr):
            if stream:
                stream.close()
        self.forget()

    def forget(self):
        if self.inside is not None:
            os.close(self.inside)
            self.inside = None
