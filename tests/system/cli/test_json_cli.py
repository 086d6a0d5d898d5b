#!/usr/bin/env python3
"""Replies of every command as JSON: against the schema, and the schema against its page.

usage: test_json_cli.py BIN_DIR [--write-page | unittest arguments]
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import jsonschema
except ImportError:
    sys.exit("SKIPPED: python3-jsonschema is not installed")

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
COMMANDS = pathlib.Path(__file__).resolve().parents[3] / "host/commands"
SCHEMA = json.loads((COMMANDS / "reply.schema.json").read_text())
PAGE = COMMANDS / "JSON.md"
LIMIT_S = 120
SPHERE = "load phantom:sphere; surface s iso=0.5; size 64x64"
# One line for each command of the table; {} is the test's folder.
LINES = f"""{SPHERE}; info; info phantom:letters crop=10:29,0:19,5:24; atlas steps=4; histogram 4
slice z 3 slab=4 kind=mean; slice z 3 {{}}/slice.png; oblique 30 10 {{}}/o.png; presets
components s
components s show=largest; certificate; compare s; compare s off; export {{}}/s.stl keep=0.5
view 20 30 pan=1,2; light 1 20 30; light three-point; light
light two-point; clip L; clip off; planes z=3; pick 32 32; why 32 32; planes off
material power=20; background red
tint gaps; antialias 1; detail auto
stereo sbs; stereo off; overlay on
pick 32 32 set=t; pick 0 0; measure 30 32 34 32; why 32 32; snapshot {{}}/s.png
snapshot {{}}/c.png ground=transparent; orbit 2; orbit 2 {{}}/o.webm degrees=90 rate=10 size=32x32
sweep s 0.4 0.5 2 {{}}/sweep.gif; stats; activity; model; digest; trace save; mark; undo
redo; scale gp=2; computers; history; history {{}}/h.txt; remove t; play {{}}/play.txt
load phantom:heart frame=2; surface s iso=242.5; time; time next; cine to=3 {{}}/cine.webm
cine to=2; curve to=3 {{}}/curve.csv
help; help load"""


def type_of(field):
    """The type of a field in words, with a link if it has fields itself."""
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name})"
    if field.get("type") == "array":
        return "list of " + type_of(field["items"])
    if isinstance(field.get("type"), list):
        return " or ".join(field["type"])
    return "1" if "const" in field else str(field["type"])


def table_of(definition):
    """The fields of an object as a Markdown table."""
    rows = []
    for name, field in definition["properties"].items():
        optional = "" if name in definition["required"] else " (optional)"
        rows.append(f"| `{name}` | {type_of(field)} | {field['description']}{optional} |\n")
    return "| field | type | meaning |\n|---|---|---|\n" + "".join(rows) if rows else "No fields.\n"


def page_text():
    """JSON.md as the schema has it."""
    commands = [rule["if"]["properties"]["name"]["const"] for rule in SCHEMA["allOf"]]
    text = """# JSON replies

`pxpl5 run --json` and `pxpl5 render --json` print one JSON object per command on one line.
[reply.schema.json](reply.schema.json) is its schema, and this page is made from the schema:
`python3 tests/system/cli/test_json_cli.py BIN_DIR --write-page`. Millimeters are LPS patient
coordinates, times are in milliseconds, and whole numbers are JSON integers. A new field may appear
in schema 1. If a field goes or changes its meaning, `schema` becomes 2.

"""
    text += table_of(SCHEMA) + "\n## Results of commands\n"
    for name in commands:
        text += f"\n### {name}\n\n{table_of(SCHEMA['$defs'][name])}"
    text += "\n## Objects in results\n"
    for name in sorted(set(SCHEMA["$defs"]) - set(commands)):
        text += f"\n### {name}\n\n{table_of(SCHEMA['$defs'][name])}"
    return text


class Json(unittest.TestCase):
    """Runs the program and checks each line."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_lines(self, lines, *flags):
        """The exit code and the replies, each of which fits the schema."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder",
             os.path.join(self.folder, "run"), *flags, "-c", lines], capture_output=True,
            text=True, timeout=LIMIT_S, cwd=self.folder, check=False)
        replies = [json.loads(line) for line in done.stdout.splitlines()]
        for reply in replies:
            jsonschema.validate(reply, SCHEMA)
        return done.returncode, replies

    def test_the_reply_of_every_command_fits_the_schema(self):
        pathlib.Path(self.folder, "play.txt").write_text("view 1 2\n")
        code, replies = self.run_lines(LINES.replace("{}", self.folder))
        self.assertEqual([(each["command"], each["error"]) for each in replies if not each["ok"]],
                         [])
        self.assertEqual(code, 0)
        _, [helped] = self.run_lines("help")
        names = {each["name"] for each in helped["result"]["commands"]} - {"quit", "kill"}
        self.assertEqual(names - {each["name"] for each in replies}, set())

    def test_the_certificate_beside_a_mesh_fits_the_schema(self):
        raw = pathlib.Path(self.folder, "a.raw")
        raw.write_bytes(bytes(9 if x == y == z == 2 else 0
                              for z in range(5) for y in range(5) for x in range(5)))
        code, replies = self.run_lines(
            f"load '{raw}' raw=5x5x5,uint8,0 spacing=1,1,1 gradient=smooth; surface s iso=4; "
            f"export {self.folder}/a.ply; export {self.folder}/b.stl keep=0.5")
        self.assertEqual((code, [each["ok"] for each in replies]), (0, [True] * 4))
        for reply in replies[2:]:
            beside = json.loads(pathlib.Path(reply["result"]["certificate"]).read_text())
            jsonschema.validate(beside, {"$ref": "#/$defs/certificate_file",
                                         "$defs": SCHEMA["$defs"]})
            self.assertEqual(beside["volume"]["read_as"]["raw"], "5x5x5,uint8,0")
            self.assertEqual(beside["volume"]["read_as"]["gradient"], "smooth")

    def test_a_simplified_mesh_is_watertight_and_states_its_bound(self):
        path = os.path.join(self.folder, "simple.ply")
        code, replies = self.run_lines(
            f"{SPHERE}; export {self.folder}/exact.ply; export {path} detail=2; certificate {path}")
        self.assertEqual((code, [each["ok"] for each in replies]), (0, [True] * 6))
        exact, simple = replies[3]["result"], replies[4]["result"]
        self.assertLess(simple["triangles"], exact["triangles"] / 4)
        self.assertGreater(simple["surfaces"][0]["within_mm"], 0)
        self.assertNotIn("within_mm", exact["surfaces"][0])
        beside = json.loads(pathlib.Path(simple["certificate"]).read_text())
        jsonschema.validate(beside, {"$ref": "#/$defs/certificate_file", "$defs": SCHEMA["$defs"]})
        self.assertEqual(beside["detail"], 2)
        self.assertEqual(beside["surfaces"][0]["within_mm"], simple["surfaces"][0]["within_mm"])
        for certificate in (beside["surfaces"][0]["certificate"],
                            replies[5]["result"]["certificates"][0]):
            self.assertTrue(certificate["watertight"])
            self.assertEqual(certificate["open_edges"], 0)

    def test_warnings_name_what_an_export_would_change(self):
        _, replies = self.run_lines(
            f"{SPHERE}; surface none iso=9000; clip L 0; certificate s; "
            f"export {self.folder}/a.stl; export {self.folder}/b.stl surfaces=none")
        self.assertEqual(replies[5]["warnings"],
                         ["of the whole surface; `export` cuts the mesh by 1 clip plane"])
        self.assertIn("none has no triangles and is not in the file", replies[6]["warnings"])
        self.assertFalse(replies[7]["ok"])
        self.assertIn("none without triangles", replies[7]["error"])

    def test_kill_and_an_archive_fit_the_schema(self):
        archive = COMMANDS.parent / "phigs/archives/molecule.phigs"
        code, replies = self.run_lines(f"load '{archive}'; info; kill gp-0")
        self.assertEqual([each["ok"] for each in replies], [True] * 3)
        self.assertNotEqual(code, 0)

    def test_warnings_of_the_text_are_in_json(self):
        path = os.path.join(self.folder, "empty.png")
        _, replies = self.run_lines(
            f"load phantom:sphere; surface s iso=9000; snapshot {path}; view; "
            f"orbit 2 {self.folder}/empty.gif; orbit 2; surface s iso=0.5; "
            f"orbit 2 {self.folder}/full.gif")
        self.assertIn("no surface there", replies[1]["warnings"][0])
        self.assertEqual(replies[2]["warnings"], ["nothing is visible in it"])
        self.assertEqual(replies[3]["warnings"], [])
        self.assertEqual(replies[4]["warnings"], ["nothing is visible in any of the pictures"])
        self.assertEqual([replies[at]["warnings"] for at in (5, 7)], [[], []])
        self.assertTrue(all(each["ok"] for each in replies))
        _, replies = self.run_lines(f"{SPHERE}; export {self.folder}/s.stl keep=0.5")
        self.assertIn("decimated from", replies[-1]["warnings"][0])

    def raw_volume(self, size, value_of):
        """A file of cubic voxels of 1 mm, and the command that loads it."""
        path = os.path.join(self.folder, "a.raw")
        span = range(size)
        pathlib.Path(path).write_bytes(bytes(
            max(0, min(255, round(128 + 40 * value_of(x, y, z))))
            for z in span for y in span for x in span))
        return f"load {path} raw={size}x{size}x{size},uint8,0 spacing=1,1,1"

    def test_an_open_mesh_warns_and_states_its_holes(self):
        path = os.path.join(self.folder, "a.stl")
        commands = f"load phantom:pelvis; surface bone iso=300; export {path}"
        _, replies = self.run_lines(f"{commands}; certificate {path}; export {path} cap=yes")
        opened, [told], capped = (replies[2]["result"], replies[3]["result"]["certificates"],
                                  replies[4]["result"])
        self.assertFalse(opened["closed"])
        for key in ("triangles", "vertices", "holes", "open_edges"):
            self.assertEqual(opened[key], told[key], key)
            self.assertEqual(opened["surfaces"][0][key], told[key], key)
        self.assertRegex(replies[2]["warnings"][0], "^bone: not closed: 4 holes .*; cap=yes closes")
        self.assertEqual((capped["closed"], capped["holes"], replies[4]["warnings"]),
                         (True, 0, []))
        code, replies = self.run_lines(commands, "--strict")
        self.assertEqual((code, replies[-1]["exit_code"]), (3, 3))
        self.assertIn("bone: not closed", replies[-1]["error"])
        self.assertEqual(self.run_lines(f"{commands} cap=yes", "--strict")[0], 0)

    def test_a_mesh_that_is_not_decimated_as_asked_warns(self):
        load = self.raw_volume(5, lambda *p: 3 if p == (2, 2, 2) else -3)
        _, small = self.run_lines(f"{load}; surface s iso=128; export {self.folder}/s.stl keep=0.9")
        self.assertIn("not decimated", small[-1]["warnings"][0])

    def test_decimation_tells_the_components_that_it_drops(self):
        mesh = os.path.join(self.folder, "s.ply")
        _, replies = self.run_lines(
            f"load phantom:pelvis; surface s iso=20; export {mesh} cap=yes; "
            f"export {mesh} cap=yes keep=0.2; certificate {mesh}")
        [whole], [fewer] = (each["result"]["surfaces"] for each in replies[2:4])
        [told] = replies[4]["result"]["certificates"]
        self.assertNotIn("components_before", whole)
        before, after = fewer["components_before"], fewer["components"]
        self.assertEqual((before, after), (whole["components"], told["components"]))
        self.assertLess(after, before)
        self.assertIn(f"s: closed, manifold, oriented; decimation dropped {before - after} of "
                      f"{before} components", replies[3]["warnings"])
        beside = json.loads(pathlib.Path(mesh + ".certificate.json").read_text())
        self.assertEqual(beside["surfaces"][0]["components_before"], before)
        self.assertEqual(told["degenerate"], 0)

    def test_cavities_are_named_and_follow_the_component_around_them(self):
        def shell(*p):
            r = math.dist(p, (14, 16, 16))
            return max(min(11 - r, r - 6), 2.5 - math.dist(p, (29, 5, 5)))
        mesh = os.path.join(self.folder, "s.stl")
        _, replies = self.run_lines(
            f"{self.raw_volume(34, shell)}; surface s iso=128; components s; "
            f"components s show=largest; components s; export {mesh}; certificate {mesh}; "
            f"components s show=largest cavities=no; export {mesh}; certificate {mesh}; "
            "components s min_ml=3; components s min_ml=0.1 cavities=yes; "
            "components s min_mm2=0 cavities=no; history form=scene")
        results = [each.get("result") for each in replies]
        listed = results[2]["largest"]
        self.assertEqual([each["cavity"] for each in listed], [False, True, False])
        self.assertEqual([each.get("cavity_of") for each in listed], [None, 1, None])
        outer, cavity, island = (each["volume_ml"] for each in listed)
        self.assertAlmostEqual(outer + cavity, 4.66, delta=0.1)
        self.assertEqual([each["drawn"] for each in listed], [True] * 3)
        self.assertEqual([each["drawn"] for each in results[4]["largest"]], [True, True, False])
        for result in results[3:5]:
            self.assertEqual((result["filter"], result["drawn"], result["drawn_cavities"]),
                             ("largest", 2, 1))
            self.assertAlmostEqual(result["drawn_ml"], outer + cavity)
        self.assertAlmostEqual(results[6]["certificates"][0]["volume_ml"], outer + cavity, 3)
        filled = results[7]
        self.assertEqual((filled["drawn"], filled["filled_cavities"]), (1, 1))
        self.assertAlmostEqual(filled["filled_ml"], -cavity)
        self.assertAlmostEqual(results[9]["certificates"][0]["volume_ml"], outer, 3)
        self.assertLess(-cavity, 3)  # Its amount would leave the cavity out.
        self.assertAlmostEqual(results[10]["drawn_ml"], outer + cavity)
        self.assertAlmostEqual(results[11]["drawn_ml"], outer + cavity)
        self.assertGreater(0.1, island)
        self.assertAlmostEqual(results[12]["drawn_ml"], outer + island)
        self.assertIn("components s cavities=no min_mm2=0", json.dumps(results[13]))

    def test_strict_makes_a_warning_an_error(self):
        code, replies = self.run_lines("load phantom:sphere; surface s iso=9000; view", "--strict")
        self.assertEqual(code, 3)
        self.assertEqual([each["ok"] for each in replies], [True, False])
        self.assertEqual(replies[1]["exit_code"], 3)
        self.assertEqual(replies[1]["result"]["triangles"], 0)
        self.assertEqual(self.run_lines(SPHERE, "--strict")[0], 0)

    def test_an_error_fits_the_schema(self):
        code, [reply] = self.run_lines("  surfase s  ")
        self.assertEqual((code, reply["exit_code"], reply["command"]), (64, 64, "surfase s"))
        self.assertIn("did you mean 'surface'?", reply["error"])

    def test_whole_numbers_are_integers(self):
        _, [load] = self.run_lines("load phantom:sphere")
        self.assertTrue(all(isinstance(each, int) for each in load["result"]["dims"]))
        self.assertTrue(all(isinstance(each, int)
                            for each in load["result"]["histogram"]["counts"]))

    def test_the_page_is_made_from_the_schema(self):
        self.assertEqual(PAGE.read_text(), page_text())


if __name__ == "__main__":
    if sys.argv[1:] == ["--write-page"]:
        PAGE.write_text(page_text())
    else:
        unittest.main()
