#!/usr/bin/env python3
"""The reading tools as a user meets them: a recorded run, listed, dumped, counted, exported.

usage: test_trace_cli.py BIN_DIR [unittest arguments]
"""
import collections
import csv
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
LIMIT_S = 120
FRAMES = 2


def png_size(path):
    """Width and height from a PNG's header."""
    header = pathlib.Path(path).read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n", header
    return int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big")


class TraceCli(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="pxpl5-trace-")
        cls.addClassCleanup(cls.folder.cleanup)
        done = cls.pxpl5("run", "--record", "full", "--topology", "one-of-each", "-c",
                         "load phantom:sphere; surface s iso=0.5; size 200x128; digest; "
                         "view 30 10; digest")
        assert done.returncode == 0, done.stderr
        runs = list(pathlib.Path(cls.folder.name, "state", "pxpl5").iterdir())
        assert len(runs) == 1, runs
        cls.run_folder = runs[0]

    @classmethod
    def pxpl5(cls, *arguments, **more):
        return subprocess.run([BIN / "pxpl5", *arguments], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=cls.folder.name,
                              env={**os.environ, "XDG_STATE_HOME": cls.path("state")}, **more)

    def output(self, *arguments, code=0):
        done = self.pxpl5(*arguments)
        self.assertEqual(done.returncode, code, (arguments, done.stderr))
        return done.stdout

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def test_ls_tells_nodes_and_frames_and_which_run_was_taken(self):
        done = self.pxpl5("trace", "ls")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(self.run_folder.name, done.stderr)
        for text in ("phantom:sphere", "framebuffer-0", "200x128", "complete"):
            self.assertIn(text, done.stdout)
        table = json.loads(self.output("trace", "ls", str(self.run_folder), "--json"))
        self.assertEqual([frame["frame"] for frame in table["frames"]], list(range(FRAMES)))
        self.assertTrue(all(f["done"] and f["executable"] == f["regions"] == 2
                            for f in table["frames"]))
        self.assertEqual({node["name"] for node in table["nodes"]},
                         {"host", "gp-0", "renderer-0", "framebuffer-0"})

    def test_dump_lists_messages_in_order_and_says_what_it_leaves_out(self):
        lines = self.output("trace", "dump", "--frame", "1").splitlines()
        kinds = [line.split()[5] for line in lines[2:]]
        self.assertEqual(kinds[0], "DrawFrame")
        self.assertEqual(collections.Counter(kinds),
                         {"DrawFrame": 1, "BeginFrame": 2, "RegionPrograms": 1, "RegionPixels": 1,
                          "FrameDone": 1})
        clocks = [int(line.split()[0]) for line in lines[2:]]
        self.assertEqual(clocks, sorted(clocks))
        short = self.output("trace", "dump", "--frame", "1", "--lines", "4").splitlines()
        self.assertEqual(len(short), 2 + 4 + 1)
        self.assertIn("2 of 6 messages left out", short[-1])

    def test_dump_shows_instructions_with_results(self):
        text = self.output("trace", "dump", "latest", "--frame", "0", "--region", "1,0", "--lines",
                           "100")
        self.assertIn("0 -> 16384", text)
        self.assertRegex(text, r"; primitive 0: cell \(\d+, \d+, \d+\), case 0x")
        self.assertRegex(text, r"surface 0 -> 1 +IMMintoMEM")
        self.assertRegex(text.splitlines()[-1], r"left out: [\d,]+ instructions")
        whole = self.output("trace", "dump", "--frame", "0", "--region", "1,0", "--all")
        listed = sum(1 for line in whole.splitlines() if line and line[0] == " ")
        table = json.loads(self.output("trace", "stats", "--frame", "0", "--region", "1,0",
                                       "--json"))
        self.assertEqual(listed, table["instructions"])

    def test_a_reader_that_goes_is_no_error(self):
        done = subprocess.run(["bash", "-o", "pipefail", "-c",
                               f"'{BIN}/pxpl5' trace dump --instructions --all | head -n 3"],
                              capture_output=True, text=True, timeout=LIMIT_S,
                              cwd=self.folder.name,
                              env={**os.environ, "XDG_STATE_HOME": self.path("state")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 3)
        self.assertNotIn("error", done.stderr)

    def test_stats_equal_what_renderers_told(self):
        table = json.loads(self.output("trace", "stats", "--json"))
        self.assertEqual(table["regions"], 2 * FRAMES)
        self.assertEqual(table["regions_told"], 2 * FRAMES)
        self.assertEqual(table["differences"], 0)
        rows = list(csv.DictReader(io.StringIO(self.output("trace", "stats", "--csv"))))
        for key in ("instructions", "cycles", "words"):
            self.assertEqual(sum(int(row[key]) for row in rows), table[key], key)
        by_op = {row["name"]: row["instructions"] for row in table["by_instruction"]}
        primitives = sum(row["primitives"] for row in table["by_frame"])
        self.assertEqual(by_op["TREEltMEM"], primitives)  # Each triangle tests z once.
        self.assertIn("equal the counts that their Renderers reported",
                      self.output("trace", "stats"))

    def test_a_timeline_is_a_trace_of_events(self):
        self.output("trace", "export", "--chrome", self.path("t.json"))
        timeline = json.loads(pathlib.Path(self.path("t.json")).read_text())
        phases = collections.Counter(event["ph"] for event in timeline["traceEvents"])
        self.assertEqual(phases["b"], FRAMES)
        self.assertEqual(phases["e"], FRAMES)
        self.assertEqual(phases["s"], phases["f"])
        self.assertGreater(phases["s"], 0)
        for event in timeline["traceEvents"]:
            self.assertIsInstance(event["pid"], int)
            self.assertIsInstance(event["name"], str)
            if event["ph"] != "M":
                self.assertGreaterEqual(event["ts"], 0)
        messages = json.loads(self.output("trace", "export", "--messages", "json"))
        slices = [e for e in timeline["traceEvents"] if e["ph"] == "X" and e["cat"] == "message"]
        self.assertEqual(len(slices), len(messages))
        rows = list(csv.DictReader(io.StringIO(self.output("trace", "export", "--messages",
                                                           "csv"))))
        self.assertEqual([row["kind"] for row in rows], [m["kind"] for m in messages])

    def test_exported_streams_draw_the_region_again(self):
        folder = pathlib.Path(self.path("streams"))
        self.output("trace", "export", "--streams", str(folder), "--frame", "1")
        files = sorted(str(path) for path in (folder / "frame-1").glob("region-0.*.pxasm"))
        self.assertGreaterEqual(len(files), 3)
        text = self.output("exec", *files, "--executor", "both", "--picture", "readout", "-o",
                           self.path("r.png"))
        self.assertIn("reference and fast agree on all pixels", text)
        self.assertEqual(png_size(self.path("r.png")), (128, 128))
        table = json.loads(self.output("trace", "stats", "--frame", "1", "--region", "0",
                                       "--json"))
        self.assertIn(f"{table['instructions']:,} instructions, {table['cycles']:,} cycles", text)
        for path in files:
            self.output("asm", path, "-o", self.path("w"))
            again = self.output("dis", self.path("w"))
            instructions = [line for line in pathlib.Path(path).read_text().splitlines()
                            if line and not line.startswith(";")]
            self.assertEqual(again.splitlines(), instructions)

    def test_a_trace_that_was_cut_is_read_up_to_there(self):
        cut = pathlib.Path(self.path("cut"))
        cut.mkdir(exist_ok=True)
        for path in (self.run_folder / "traces").glob("*.mcap"):
            data = path.read_bytes()
            kept = len(data) * 2 // 3 if path.name.startswith("host") else len(data)
            (cut / path.name).write_bytes(data[:kept])
        table = json.loads(self.output("trace", "ls", str(cut), "--json"))
        whole = {node["name"]: node["complete"] for node in table["nodes"]}
        self.assertEqual(whole, {"host": False, "gp-0": True, "renderer-0": True,
                                 "framebuffer-0": True})
        self.assertIn("cut: ", self.output("trace", "ls", str(cut)))
        self.output("trace", "dump", str(cut))
        self.assertEqual(json.loads(self.output("trace", "stats", str(cut), "--json"))["regions"],
                         2 * FRAMES)

    def test_what_cannot_be_is_64_and_names_it(self):
        for arguments, text in ((["trace", "dump", "--frame", "x"], "--frame 'x'"),
                                (["trace", "dump", "--op", "TREX*"], "TREX*"),
                                (["trace", "dump", "--op", "NOP", "--kind", "Credit"], "not both"),
                                (["trace", "dump", "--pixel", "900", "5"], "900"),
                                (["trace", "dump", "--region", "77"], "no region is selected"),
                                (["trace", "export"], "--chrome"),
                                (["trace", "stats", "--json", "--csv"], "only one"),
                                (["why", "256", "200"], "X and Y of the pixel are missing"),
                                (["trace", "map", "cost", "-o", "m.gif"], "m.gif"),
                                (["trace"], "")):
            done = self.pxpl5(*arguments)
            self.assertEqual(done.returncode, 64, (arguments, done))
            self.assertIn(text, done.stderr, arguments)

    def test_the_usage_of_map_names_run_and_map(self):
        self.assertIn("trace map [OPTIONS] [run] [map]", self.output("trace", "map", "--help"))

    def test_bad_files_are_65(self):
        bad = self.path("bad.mcap")
        pathlib.Path(bad).write_bytes(b"this is no trace")
        for arguments in (["trace", "ls", bad], ["trace", "ls", "no-such-run"],
                          ["asm", self.path("absent")], ["exec", bad], ["dis", "--hex", bad]):
            done = self.pxpl5(*arguments)
            self.assertEqual(done.returncode, 65, (arguments, done))
            self.assertTrue(done.stderr.startswith("error: "), done.stderr)

    def test_programs_are_read_from_files_alone_and_to_a_limit(self):
        fifo = self.path("fifo")
        os.mkfifo(fifo)
        for tool in ("asm", "exec", "dis"):
            for path, reason in ((fifo, "is a FIFO, not a file"), ("/dev/zero", "not a file"),
                                 ("/proc/self/mem", "is a file of the kernel"),
                                 (self.path("absent"), "does not exist")):
                done = self.pxpl5(tool, path)
                self.assertEqual(done.returncode, 65, (tool, path, done))
                self.assertIn(f"{path}: {reason}" if path != "/dev/zero" else reason, done.stderr)
            done = subprocess.run([BIN / "pxpl5", tool, "-"], stdin=open("/dev/zero", "rb"),
                                  capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 65, (tool, done))
            self.assertIn("is the most that a program may have", done.stderr)
        for word, reason in ((fifo, "is no run: give the folder of a run, or a trace (*.mcap)"),
                             (self.path("absent"), "there is no such run")):
            done = self.pxpl5("trace", "ls", word)
            self.assertEqual((done.returncode, done.stderr), (65, f"error: {word}: {reason}\n"))
        done = self.pxpl5("trace", "ls", "x" * 300)
        self.assertEqual((done.returncode, done.stderr),
                         (65, f"error: {'x' * 300}: cannot be read: File name too long\n"))
        done = self.pxpl5("asm", "-o", fifo, "-", input="NOP\n")
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("fifo: it is a FIFO, not a file", done.stderr)
        large = self.path("large")
        with open(large, "wb") as file:
            file.truncate(1 << 30)
        done = self.pxpl5("asm", large)
        self.assertEqual(done.returncode, 65, done)
        self.assertRegex(done.stderr, r"large: 1,073,741,824 bytes; at most [\d,]+ are read")


if __name__ == "__main__":
    unittest.main(verbosity=2)
