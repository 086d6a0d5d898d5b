#!/usr/bin/env python3
"""Memory is given back when another volume opens: test_memory.py FOLDER_OF_BINARIES.

Without the trace recording, which keeps the messages of the last seconds, 64 MiB in each node."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from processes import children_of  # noqa: E402

BINARIES = pathlib.Path()  # From the command line.
LARGE = ["load phantom:pelvis resample=440x440x220", "surface bone iso=250",
         "surface skin iso=-300", "surface bone iso=180", "snapshot large.png"]
SMALL = ["load phantom:pelvis", "surface bone iso=250", "snapshot small.png"]


class Session:
    """A session whose commands are read from a pipe."""

    def __init__(self, folder):
        words = ["run", "--json", "--record", "off", "-"]
        self.process = subprocess.Popen([BINARIES / "pxpl5", *words], cwd=folder, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def does(self, lines):
        for line in lines:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
            answer = self.process.stdout.readline()
            assert '"ok":true' in answer.replace(" ", ""), answer

    def memory_mib(self):
        """Of the host and all nodes; what they share counts once."""
        kib = 0
        for pid in [self.process.pid, *children_of(self.process.pid)]:
            try:
                text = pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text()
            except (FileNotFoundError, ProcessLookupError):
                continue  # The io process has ended.
            kib += sum(int(re.search(rf"^{key}: *(\d+)", text, re.M)[1])
                       for key in ("Pss_Anon", "Pss_Shmem"))
        return kib / 1024

    def end(self):
        self.process.stdin.close()
        self.process.stdout.read()
        return self.process.wait(60)


class Memory(unittest.TestCase):
    def test_a_small_volume_after_a_large_one_needs_little_more_than_a_fresh_one(self):
        with tempfile.TemporaryDirectory() as folder:
            fresh = Session(folder)
            fresh.does(SMALL)
            fresh_mib = fresh.memory_mib()
            self.assertEqual(fresh.end(), 0)
            later = Session(folder)
            later.does(LARGE)
            large_mib = later.memory_mib()
            later.does(SMALL)
            later_mib = later.memory_mib()
            self.assertEqual(later.end(), 0)
        told = f"fresh {fresh_mib:.0f}, large {large_mib:.0f}, after it {later_mib:.0f} MiB"
        print(told)
        self.assertGreater(large_mib, 2 * fresh_mib, told)
        # A machine keeps 40 MiB more in some runs, for what io sent, and freed memory (RB-30).
        self.assertLess(later_mib - fresh_mib, (large_mib - fresh_mib) / 2, told)


if __name__ == "__main__":
    BINARIES = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
