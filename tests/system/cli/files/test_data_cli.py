#!/usr/bin/env python3
"""Bad files one after another in one session: each is refused by name, and the host goes on.

usage: test_data_cli.py BIN_DIR DATA_DIR [unittest arguments]
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
DATA = pathlib.Path(sys.argv.pop(1))
LIMIT_S = 280
# These may be read leniently.
LENIENT = {"dcm_no_meta.dcm", "dcm_badVR.dcm"}
# Not volumes themselves.
PARTS = {"short.raw"}


class Malformed(unittest.TestCase):
    def test_each_is_refused_and_the_host_goes_on(self):
        files = sorted(path for path in (DATA / "malformed").iterdir()
                       if path.name not in PARTS)
        commands = []
        for path in files:
            commands += [f"load '{path.resolve()}'", "load phantom:sphere",
                         "surface sphere iso=0.5"]
        with tempfile.TemporaryDirectory(prefix="pxpl5-test-") as folder:
            done = subprocess.run(
                [BIN / "pxpl5", "run", "--json", "--keep-going", "--topology", "one-of-each",
                 "--run-folder", folder, "-c", "\n".join(commands)],
                capture_output=True, text=True, timeout=LIMIT_S, check=False)
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(len(answers), len(commands), done.stderr)
        for path, answer in zip(files, answers[::3]):
            with self.subTest(path.name):
                if path.name.startswith("00_good"):
                    self.assertTrue(answer["ok"], answer)
                elif path.name not in LENIENT or not answer["ok"]:
                    self.assertFalse(answer["ok"], answer)
                    self.assertEqual(answer["exit_code"], 65, answer)
                    self.assertIn(path.name, answer["error"])
        for answer in answers[1::3] + answers[2::3]:
            self.assertTrue(answer["ok"], answer)
        self.assertEqual(done.returncode, 65)


if __name__ == "__main__":
    if not (DATA / "malformed").is_dir():
        print(f"SKIPPED: {DATA} is not there")
        sys.exit(0)
    unittest.main()
