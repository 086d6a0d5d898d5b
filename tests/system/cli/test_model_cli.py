#!/usr/bin/env python3
"""The model as a user meets it: recorded runs on the machine of 1993, and on others.

usage: test_model_cli.py BIN_DIR [unittest arguments]
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
LIMIT_S = 120
COMMANDS = ("load phantom:sphere; surface s iso=0.5; size 300x128; digest; "
            "surface t iso=0.3; view 30 10; digest")
STEPS = ["load", "build", "frame", "build", "frame"]


class ModelCli(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="pxpl5-model-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.small = cls.recorded("small", 1, 1, COMMANDS)
        cls.large = cls.recorded("large", 3, 2, COMMANDS)

    @classmethod
    def recorded(cls, name, gps, renderers, commands):
        """A new run folder with the traces of these commands."""
        done = cls.pxpl5("run", "--record", "full", "--topology", "one-of-each", "--set",
                         f"gp.count={gps}", "--set", f"renderer.count={renderers}", "--run-folder",
                         name, "-c", commands)
        assert done.returncode == 0, done.stderr
        runs = list(pathlib.Path(cls.folder.name, name).iterdir())
        assert len(runs) == 1, runs
        return str(runs[0])

    @classmethod
    def pxpl5(cls, *arguments):
        return subprocess.run([BIN / "pxpl5", *arguments], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=cls.folder.name)

    def output(self, *arguments):
        done = self.pxpl5(*arguments)
        self.assertEqual(done.returncode, 0, (arguments, done.stderr))
        return done.stdout

    def model(self, *arguments):
        return json.loads(self.output("model", self.small, "--json", *arguments))

    def refusal(self, code, *arguments):
        done = self.pxpl5("model", *arguments)
        self.assertEqual(done.returncode, code, (arguments, done.stdout, done.stderr))
        return done.stderr

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def test_the_same_bytes_each_time_and_whoever_ran_it(self):
        for more in ([], ["--json"], ["--sweep", "gp.count=1..64*2"]):
            first = self.output("model", self.small, *more)
            self.assertEqual(self.output("model", self.small, *more), first)
            self.assertEqual(self.output("model", self.large, *more), first)
        self.assertIn("36 GPs at 40 MHz, 16 Renderers at 40 MHz", first)

    def test_steps_follow_each_other_and_channels_sum_to_the_ring(self):
        told = self.model()
        self.assertEqual([step["kind"] for step in told["steps"]], STEPS)
        self.assertEqual(told["missing"], [])
        for before, after in zip(told["steps"], told["steps"][1:]):
            self.assertLess(before["begin_ns"], before["end_ns"])
            self.assertLessEqual(before["begin_ns"], after["begin_ns"])
        self.assertEqual([frame["frame"] for frame in told["frames"]], [0, 1])
        for one in told["steps"] + told["frames"]:
            greatest = max(one["use"], key=lambda use: use["busiest"])
            self.assertEqual(one["limit"], greatest["unit"] if greatest["busiest"] >= 0.9
                             else "waiting")
            self.assertLessEqual(greatest["busiest"], 1)
        for count in ("packets", "words"):
            self.assertEqual(sum(row[count] for row in told["ring"]),
                             sum(row[count] for row in told["channels"]))
        ways = {row["name"] for row in told["ring"]}
        self.assertLessEqual({"host -> GPs", "GPs -> Renderers", "Renderers -> frame buffers",
                              "frame buffers -> host"}, ways)
        self.assertEqual(len(told["channels"]), 8)

    def test_another_machine_is_another_time(self):
        def build(*arguments):
            step = self.model(*arguments)["steps"][1]
            return step["end_ns"] - step["begin_ns"]
        self.assertGreater(build("--set", "gp.count=1"), 3 * build())
        told = self.model("--set", "gp.count=54", "--set", "ring.channel_mb_s=160")
        self.assertEqual(told["machine"]["gp.count"], 54)
        self.assertEqual(told["machine"]["ring.channel_mb_s"], 160)
        self.assertEqual(self.model("--topology", "one-of-each")["machine"]["gp.count"], 1)

    def test_more_gps_than_run_and_why_they_do_not_load_faster(self):
        words = {}
        for gps in (1, 2, 4, 128):
            told = self.model("--set", f"gp.count={gps}")
            self.assertEqual(told["machine"]["gp.count"], gps)
            words[gps] = next(row["words"] for row in told["ring"] if row["name"] == "host -> GPs")
        for gps, copies in ((2, 2), (4, 4), (128, 4)):
            self.assertAlmostEqual(words[gps] / words[1], copies, delta=0.3)
        swept = self.output("model", self.small, "--sweep", "gp.count=64..1024*4")
        self.assertIn("each adds a copy of the volume on the host's link", swept)
        self.assertRegex(swept, r"(?m)^ *1024 ")

    def test_one_frame_of_several(self):
        told = self.model("--frame", "1")
        self.assertEqual([step["kind"] for step in told["steps"]], ["load", "build", "build",
                                                                    "frame"])
        self.assertEqual([frame["frame"] for frame in told["frames"]], [1])

    def test_a_picture_of_several_samples_is_shown_as_one(self):
        smooth = self.recorded("smooth", 1, 1, COMMANDS + "; antialias 4; digest")
        rates = ["frames_per_s", "latency_ns", "limit", "use"]
        told = json.loads(self.output("model", smooth, "--json", "--csv", self.path("4.csv")))
        self.assertEqual([(one["frame"], one["samples"]) for one in told["frames"]],
                         [(0, 1), (1, 1), (2, 4)])
        self.assertEqual([step["kind"] for step in told["steps"]], STEPS + 4 * ["frame"])
        single, picture = told["frames"][1:]
        self.assertLess(picture["frames_per_s"], single["frames_per_s"] / 2)
        self.assertGreater(picture["latency_ns"], single["latency_ns"])
        with open(self.path("4.csv"), encoding="utf-8") as file:
            shown = [row["frames_per_s"] for row in csv.DictReader(file)]
        self.assertEqual(shown[5:8], 3 * [""])
        self.assertEqual(float(shown[8]), picture["frames_per_s"])
        self.assertIn("frames 2..5, 4 samples", self.output("model", smooth))
        for frame in ([], ["--frame", "3"]):  # Any of its passes is the picture.
            swept = json.loads(self.output("model", smooth, "--json", "--sweep", "gp.count=36",
                                           *frame))
            self.assertEqual((swept["frame"], swept["samples"]), (2, 4))
            self.assertEqual([swept["machines"][0][rate] for rate in rates],
                             [picture[rate] for rate in rates])

    def test_a_sweep_is_a_table_and_a_plot(self):
        sweep = ["--sweep", "gp.count=1,2,8", "--sweep", "renderer.count=1..3"]
        told = self.model(*sweep, "--csv", self.path("s.csv"), "--plot", self.path("s.svg"))
        self.assertEqual(told["frame"], 1)
        with open(self.path("s.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["gp.count"], row["renderer.count"]) for row in rows],
                         [(g, r) for g in "128" for r in "123"])
        self.assertEqual([float(row["frames_per_s"]) for row in rows],
                         [machine["frames_per_s"] for machine in told["machines"]])
        self.assertEqual([int(row["build_ns"]) for row in rows],
                         [machine["build_ns"] for machine in told["machines"]])
        plot = xml.etree.ElementTree.parse(self.path("s.svg")).getroot()
        self.assertTrue(plot.tag.endswith("svg"))
        text = "".join(plot.itertext())
        for word in ("gp.count", "renderer.count 3", "frames/s", "ms to build"):
            self.assertIn(word, text)
        one = self.model("--set", "gp.count=2", "--set", "renderer.count=3", "--frame", "1")
        self.assertEqual(told["machines"][5]["frames_per_s"], one["frames"][0]["frames_per_s"])

    def test_a_table_of_steps(self):
        told = self.model("--csv", self.path("steps.csv"))
        with open(self.path("steps.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["kind"] for row in rows], STEPS)
        self.assertEqual([int(row["end_ns"]) for row in rows],
                         [step["end_ns"] for step in told["steps"]])
        self.assertEqual([row["frames_per_s"] != "" for row in rows],
                         [kind == "frame" for kind in STEPS])

    def test_what_is_asked_wrongly_is_said(self):
        self.assertIn("did you mean 'gp.count'?",
                      self.refusal(64, self.small, "--set", "gp.cuont=3"))
        self.assertIn("did you mean 'gp.count'?",
                      self.refusal(64, self.small, "--sweep", "gp.cuont=1..3"))
        self.assertIn("gp.count is 1025, must be 1..1024",
                      self.refusal(64, self.small, "--sweep", "gp.count=1020..1025"))
        self.assertIn("8 is greater than 4", self.refusal(64, self.small, "--sweep",
                                                          "gp.count=8..4"))
        self.assertIn("--plot needs --sweep", self.refusal(64, self.small, "--plot", "x.svg"))
        self.assertIn("share is 'own', but an axis needs numbers",
                      self.refusal(64, self.small, "--sweep", "share=own", "--plot", "x.svg"))
        self.assertIn("frame 7 is not in this run; it has 0, 1",
                      self.refusal(64, self.small, "--frame", "7"))
        self.assertIn("no topology 'paper'", self.refusal(64, self.small, "--topology", "paper"))
        self.assertIn("there is no such run", self.refusal(65, "nowhere"))
        self.assertIn("recorded assignment", self.refusal(65, self.large, "--set",
                                                          "assignment=recorded"))

    def test_what_is_asked_wrongly_is_said_before_anything_is_read(self):
        self.assertIn("gp.count is 1025, must be 1..1024",
                      self.refusal(64, "nowhere", "--sweep", "gp.count=1,1025"))
        self.assertIn("gp.count: the key is there twice",
                      self.refusal(64, "nowhere", "--sweep", "gp.count=1", "--sweep", "gp.count=2"))
        self.assertIn("share is 'own', but an axis needs numbers",
                      self.refusal(64, "nowhere", "--sweep", "share=own", "--plot", "x.svg"))

    def test_a_file_that_fails_costs_neither_the_old_one_nor_the_results(self):
        old = pathlib.Path(self.path("old.svg"))
        old.write_text("old", encoding="utf-8")
        sweep = [self.small, "--sweep", "share=own,even"]
        self.refusal(64, *sweep, "--plot", str(old))
        self.refusal(65, self.large, "--sweep", "gp.count=1,2", "--set", "assignment=recorded",
                     "--plot", str(old))
        self.assertEqual(old.read_text(encoding="utf-8"), "old")
        told = self.output("model", *sweep)
        done = self.pxpl5("model", *sweep, "--csv", self.path("nowhere/s.csv"))
        self.assertEqual((done.returncode, done.stdout), (1, told))
        self.assertIn("nowhere/s.csv", done.stderr)

    def test_several_computers_of_today(self):
        told = self.model("--cluster", "1")
        self.assertEqual((told["gps"], told["renderers"], told["frame"]), (1, 1, 1))
        self.assertEqual(told["crossings"], [])
        apart = ["--cluster", "2,3", "--set", "gp.computer=n1", "--set", "renderer.computer=n2",
                 "--link-mbit", "100", "--csv", self.path("c.csv")]
        told = self.model(*apart)
        self.assertEqual([point["computers"] for point in told["computers"]], [2, 3])
        self.assertEqual(told["computers"][0]["limit"], "link")
        values = {row["name"]: row["value"] for row in told["parameters"]}
        self.assertEqual(values["link.mbit"], 100)
        self.assertLessEqual({"bins", "pixels"}, {row["kind"] for row in told["crossings"]})
        with open(self.path("c.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([float(row["frames_per_s"]) for row in rows],
                         [point["frames_per_s"] for point in told["computers"]])
        text = self.output("model", self.small, *apart)
        self.assertIn(f"{told['computers'][0]['frames_per_s']:.1f}", text)
        plain = self.model(*apart, "--cluster-set", "link.mbit=200")
        self.assertAlmostEqual(plain["computers"][0]["frames_per_s"] /
                               told["computers"][0]["frames_per_s"], 2, delta=0.01)

    def test_nodes_of_several_computers_are_those_of_the_run_unless_named(self):
        def nodes(run, *more):
            told = json.loads(self.output("model", run, "--json", "--cluster", "2", *more))
            return told["gps"], told["renderers"]
        self.assertEqual(nodes(self.large), (3, 2))
        self.assertEqual(nodes(self.large, "--set", "gp.count=5"), (5, 2))
        self.assertEqual(nodes(self.large, "--topology", "paper-1993"), (36, 16))

    def test_what_is_asked_wrongly_of_several_computers(self):
        for words, part in (
                (["--cluster", "0"], "must be a number of computers, 1 to 256"),
                (["--cluster", "2", "--link", "1t"], "must be one of 1g, 10g"),
                (["--cluster", "2", "--cores", "0"], "cores is 0 per computer, must be 1 to 4096"),
                (["--cluster", "2", "--cluster-set", "core=1"], "must be one of link.mbit"),
                (["--cluster", "2", "--set", "gp.computer=n3"], "only n1, n2 are there"),
                (["--cluster", "2", "--sweep", "gp.count=1,2"], "give only one"),
                (["--link", "10g"], "go with --cluster")):
            with self.subTest(words):
                self.assertIn(part, self.refusal(64, self.small, *words))

    def test_a_run_without_frames_or_without_anything(self):
        loaded = self.recorded("loaded", 1, 1, "load phantom:sphere")
        self.assertIn("no complete picture", self.output("model", loaded))
        self.assertIn("--sweep times a frame, and none could be counted",
                      self.refusal(65, loaded, "--sweep", "gp.count=1,2"))
        idle = self.recorded("idle", 1, 1, "size 64x64")
        self.assertIn("loaded no volume, built no surface and drew no frame",
                      self.refusal(65, idle))


if __name__ == "__main__":
    unittest.main()
