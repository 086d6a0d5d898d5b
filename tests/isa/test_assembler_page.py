"""Runs the command lines of isa/ASSEMBLER.md in an empty folder: test_assembler_page.py BIN."""
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from png_pixels import rows_of  # pylint: disable=wrong-import-position

BIN = pathlib.Path(sys.argv[1]).resolve()
PAGE = pathlib.Path(__file__).resolve().parents[2] / "isa" / "ASSEMBLER.md"


def blocks(kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE.read_text(), re.S | re.M)


class Page(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for text in blocks("pxasm"):
            name = re.match(r"; (\w+\.pxasm):", text)[1]
            (self.folder / name).write_text(text)

    def run_line(self, line):
        words = shlex.split(line)
        self.assertEqual(words[0], "pxpl5", line)
        done = subprocess.run([BIN / "pxpl5", *words[1:]], cwd=self.folder, text=True,
                              capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, f"{line}\n{done.stderr}")
        return done.stdout

    def test_every_command_succeeds_and_the_pictures_are_as_described(self):
        lines = [line for block in blocks("sh") for line in block.splitlines()]
        output = {line: self.run_line(line) for line in lines}
        self.assertGreaterEqual(len(output), 5)
        disc, curtain = (rows_of(self.folder / f"{name}.png") for name in ("disc", "curtain"))
        self.assertEqual(disc[64][64], (255, 0, 0))
        self.assertEqual(disc[4][3], (0, 0, 255))
        self.assertEqual(curtain[10][95], (0, 0, 0))
        self.assertEqual(curtain[10][96], (255, 255, 0))
        listing = output["pxpl5 dis disc.bin --numbered"]
        self.assertIn("QUADgeZERO :16  128 128 -5692 -1 0 -1", listing)
        # Pixels 60..67 are in bars 3 and 4: 108 and 144.
        bars = output["pxpl5 exec bars.pxasm --print rgb --window 60..67,63 --hex"]
        self.assertEqual(re.findall(r"\b(6c6c6c|909090)\b", bars), ["6c6c6c"] * 4 + ["909090"] * 4)

    def test_every_kind_of_command_in_the_table_of_tools_succeeds(self):
        rows = re.findall(r"^\| `(pxpl5 [^`]*)` \|", PAGE.read_text(), re.M)
        self.assertEqual(len(rows), 8)
        for row in rows:
            self.run_line(re.sub(r"\bA\.", "bars.", row))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
