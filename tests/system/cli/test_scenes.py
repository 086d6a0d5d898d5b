#!/usr/bin/env python3
"""Scenes that are saved and opened again: test_scenes.py BIN_DIR.

One machine draws random scenes, and saves each as a script with its numbers and pictures. A second
machine, which has drawn other things, opens the scripts again. PXPL5_SEED chooses other scenes.
"""
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
ARCHIVES = pathlib.Path(__file__).resolve().parents[3] / "host/phigs/archives"
LIMIT_S = 240
SCENES = 30
SEED = int(os.environ.get("PXPL5_SEED", "16"))

ISOVALUES = {"phantom:sphere": (-900, 1500), "phantom:letters": (60, 900),
             "phantom:torus": (29500, 31000)}
LOADS = ["", "", " smooth=2", " crop=4:59,4:55,4:27", " gradient=smooth"]
VIEWS = ["anterior", "left", "superior"]
SIZE = (150, 110)


class Dice(random.Random):
    """Random commands of a session."""

    def number(self, low, high):
        """A number with as many digits as a mouse gives."""
        return round(self.uniform(low, high), self.choice([0, 2, 13]))

    def surface(self, name, isovalues):
        line = f"surface {name} iso={self.number(*isovalues)}"
        options = [f" opacity={self.number(0.05, 1)}", f" color=#{self.getrandbits(24):06x}",
                   f" rim={self.number(0, 1)}", " visible=no", " table=lorensen1987",
                   " table=asymptotic"]
        return line + "".join(option for option in options[:3] if self.random() < 0.5) + (
            self.choice(options[3:]) if self.random() < 0.3 else "")

    def pixel(self):
        return f"{self.randrange(58, 92)} {self.randrange(42, 68)}"

    def changes(self, names, isovalues):
        """Commands that may change the scene after its surfaces are there; some fail."""
        a, b = self.choice(names), self.choice(names)
        number = self.number
        return [
            f"view {number(-180, 180)} {number(-90, 90)} zoom={number(0.7, 3)} "
            f"roll={number(-180, 180)} pan={number(-9, 9)},{number(-9, 9)}",
            f"view {self.choice(VIEWS)} zoom={number(0.7, 2)}",
            f"clip {self.choice('LRPASI')} {number(-20, 20)}", f"clip {self.choice('LRPASI')}",
            "clip box 5,5,5 40,30.5,20", "clip off",
            f"planes {self.choice('xyz')}={self.randrange(0, 40)} window={number(10, 900)}",
            f"planes {self.choice('xyz')}={self.randrange(0, 20)}",
            f"planes {self.choice('xyz')}=off", "planes off",
            f"light 1 {number(-90, 90)} {number(-80, 80)} intensity={number(0, 2)}",
            f"light 3 {number(-90, 90)} {number(-80, 80)}", "light 1 off",
            f"material ambient={number(0, 1)} specular={number(0, 1)} power={self.randrange(1, 9)}",
            f"background #{self.getrandbits(24):06x}", "overlay off", "overlay on", "antialias 4",
            f"surface {a} opacity={number(0.05, 1)}", f"surface {a} visible=no",
            f"surface {a} rim={number(0, 1)}", f"surface {a} visible=yes",
            self.surface(a, isovalues), f"remove {b}",
            f"components {a} show=largest", f"components {a} min_mm2={number(0, 9000)}",
            f"components {a} min_ml={number(0, 20)}",
            f"components {a} at={self.randrange(50, 100)},{self.randrange(40, 70)}",
            f"compare {a}", f"compare {a} off", f"size {SIZE[0]}x{SIZE[1]}", "size 131x97",
            "tint gaps color=red", "undo", "undo", "redo", "mark"]

    def session(self):
        """Lines of one session, and the questions and pictures at its end."""
        volume = self.choice(list(ISOVALUES))
        names = ["skin", "my bone"[:self.choice([2, 7])].strip().replace(" ", "-"), "s=1"][
            :self.randrange(1, 4)]
        names = [name if "=" not in name else f"'{name}'" for name in names]
        options = self.choice(LOADS)
        if "crop" in options and volume == "phantom:torus":
            options = " resample=60x50x30"
        lines = [f"size {SIZE[0]}x{SIZE[1]}", f"load {volume}{options}"]
        lines += [self.surface(name, ISOVALUES[volume]) for name in names]
        for _ in range(self.randrange(3, 14)):
            lines.append(self.choice(self.changes(names, ISOVALUES[volume])))
        questions = ["digest"] + [f"measure {self.pixel()} {self.pixel()}" for _ in range(3)]
        questions += [f"pick {self.pixel()}", "clip", "planes", "light", "view",
                      "material"]
        questions += [f"surface {name}" for name in names]
        window = f"window={self.number(10, 900)} level={self.number(-500, 900)}"
        pictures = ["snapshot {}.png", f"slice {self.choice('xyz')} 20 {{}}-slice.png {window}"]
        return lines, questions, pictures[:self.choice([1, 1, 2])]


def numbers_of(outcome):
    """What an outcome says, without times and numbers that count for the whole session."""
    def kept(value):
        if isinstance(value, dict):
            return {key: kept(each) for key, each in value.items()
                    if not key.endswith("_ms") and key not in ("file", "gp_memory_bytes")}
        return [kept(each) for each in value] if isinstance(value, list) else value
    return (outcome["command"], outcome["ok"], kept(outcome.get("result")),
            outcome.get("error"), outcome.get("warnings"))


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)

    def run_lines(self, lines):
        """Outcomes of all lines, on one machine."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--keep-going", "--topology", "one-of-each",
             "--set", "gp.count=2"], input="\n".join(lines) + "\n", capture_output=True, text=True,
            timeout=LIMIT_S, cwd=self.at, check=False)
        outcomes = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(len(outcomes), len(lines), done.stderr)
        return outcomes

    def test_a_saved_scene_opened_again_has_the_same_numbers_and_pictures(self):
        print("seed", SEED)
        dice = Dice(SEED)
        sessions = [dice.session() for _ in range(SCENES)]
        first, second, asked = [], [], []  # asked: index of the first question
        for i, (lines, questions, pictures) in enumerate(sessions):
            first += lines
            asked.append(len(first))
            first += questions + [picture.format(f"saved-{i}") for picture in pictures]
            first.append(f"history {i}.pxpl5 form=scene")
        saved = self.run_lines(first)
        for i in reversed(range(SCENES)):  # What comes before a scene is another one.
            _, questions, pictures = sessions[i]
            second += [f"play {i}.pxpl5"] + questions
            second += [picture.format(f"opened-{i}") for picture in pictures]
        opened = iter(self.run_lines(second))
        shown, measured = set(), 0
        for i in reversed(range(SCENES)):
            lines, questions, pictures = sessions[i]
            script = (self.at / f"{i}.pxpl5").read_text()
            about = "\n".join([f"session {i}"] + lines + ["saved as", script])
            self.assertTrue(next(opened)["ok"], about)
            before = saved[asked[i]:]
            for question in before[:len(questions)]:
                self.assertEqual(numbers_of(question), numbers_of(next(opened)), about)
                measured += question["name"] == "measure" and question["ok"]
            for picture, outcome in zip(pictures, before[len(questions):]):
                self.assertEqual(outcome["ok"], next(opened)["ok"], about)
                name = next(word for word in picture.split() if word.endswith(".png")).format
                if outcome["ok"]:
                    written = (self.at / name(f"saved-{i}")).read_bytes()
                    self.assertEqual(written, (self.at / name(f"opened-{i}")).read_bytes(), about)
                    shown.add(written)
            for word in ("snapshot", "export", "orbit", "trace", "slice"):
                self.assertNotRegex(script, rf"(?m)^{word}\b", "opening a scene writes no file")
        self.assertGreater(len(shown), SCENES, "the scenes differ")
        self.assertGreater(measured, SCENES, "most scenes show surfaces to measure")

    def test_a_scene_is_not_opened_with_another_volume(self):
        values = bytes(range(256)) * 16
        (self.at / "scan.raw").write_bytes(values)
        raw = "load scan.raw raw=16x16x16,uint8 spacing=1,1,1"
        lines = [raw, "surface s iso=100", "history a.pxpl5 form=scene"]
        self.assertEqual([each["ok"] for each in self.run_lines(lines)], [True] * 3)
        self.assertTrue(self.run_lines(["play a.pxpl5"])[0]["ok"])
        (self.at / "scan.raw").write_bytes(values[::-1])
        refused = self.run_lines(["play a.pxpl5"])[0]
        self.assertFalse(refused["ok"])
        self.assertIn("is not the volume that was wanted", refused["error"])

    def write_nrrd(self, spacing):
        """scan.nhdr with voxels of `spacing` mm, and the same values each time."""
        (self.at / "scan.raw").write_bytes(bytes(range(256)) * 16)
        (self.at / "scan.nhdr").write_text(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
            f"sizes: 16 16 16\nspace directions: ({spacing},0,0) (0,{spacing},0) (0,0,{spacing})\n"
            "space origin: (0,0,0)\nencoding: raw\ndata file: scan.raw\n")

    def test_a_scene_is_not_opened_with_the_same_voxels_of_another_size(self):
        self.write_nrrd(1)
        lines = ["load scan.nhdr", "surface s iso=100.5", "history a.pxpl5 form=scene"]
        self.assertEqual([each["ok"] for each in self.run_lines(lines)], [True] * 3)
        self.assertTrue(self.run_lines(["play a.pxpl5"])[0]["ok"])
        self.write_nrrd(2)
        refused = self.run_lines(["play a.pxpl5"])[0]
        self.assertFalse(refused["ok"], "lengths would be twice as long")
        self.assertIn("the digest of its size and place is", refused["error"])

    def test_a_scene_of_an_archive_is_opened_from_another_folder(self):
        shutil.copy(ARCHIVES / "tree.phigs", self.at)
        lines = ["load tree.phigs", "view 10 20", "digest", "history deep/a.pxpl5 form=scene"]
        (self.at / "deep").mkdir()
        saved = self.run_lines(lines)
        self.assertEqual([each["ok"] for each in saved], [True] * 4)
        self.at /= "deep"
        opened = self.run_lines(["play a.pxpl5", "digest"])
        self.assertTrue(opened[0]["ok"], opened[0].get("error"))
        self.assertEqual(opened[1]["result"]["frame"], saved[2]["result"]["frame"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
