#!/usr/bin/env python3
"""The program as a user meets it: real processes, command lines, exit codes, pictures.

usage: test_cli.py BIN_DIR [unittest arguments]
"""
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

from processes import ENDS, children_of, name_of

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 120


def png_size(path):
    """Width and height from a PNG's header."""
    header = pathlib.Path(path).read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n", header
    return int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big")


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def pxpl5(self, *arguments, topology="one-of-each", machine=True):
        """Runs the program to its end."""
        flags = ["--run-folder", self.path("run"), "--topology", topology] if machine else []
        return subprocess.run([BIN / "pxpl5", *arguments, *flags], capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=self.folder.name)

    def test_every_vector_target_gives_the_same_bits(self):
        digests = {}
        for target in ("sse4", "avx2", "avx512"):
            done = self.pxpl5("run", "--vector-target", target, "--set", "gp.count=2", "-c",
                              "load phantom:fetus;surface face;surface inner iso=140 opacity=0.5;"
                              "size 300x200;digest")
            if done.returncode != 0:  # An older computer.
                self.assertIn(f'vector target "{target}" is not available on this computer',
                              done.stderr)
                print(f"SKIPPED here: {target}")
                continue
            digests[target] = done.stdout.splitlines()[-3:]
            self.assertEqual([line.split()[0] for line in digests[target]],
                             ["frame", "mesh", "mesh"])
        self.assertGreaterEqual(len(digests), 1)
        self.assertEqual(len({tuple(lines) for lines in digests.values()}), 1, digests)
        # A name that no computer knows ends every role, GPs too.
        done = self.pxpl5("run", "--set", "gp.env=PXPL5_TARGET=mmx", "-c",
                          "load phantom:sphere;surface s iso=0.5")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('vector target "mmx" is not available on this computer', done.stderr)

    def test_version(self):
        done = self.pxpl5("--version", machine=False)
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"^pxpl5 \d+\.\d+\.\d+\n$")

    def test_render_writes_a_picture_of_the_asked_size(self):
        done = self.pxpl5("render", "phantom:sphere", "--iso", "0.5", "--size", "200x150",
                          "-o", self.path("s.png"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(png_size(self.path("s.png")), (200, 150))

    def test_json_is_one_object_per_command(self):
        done = self.pxpl5("run", "--json", "-c",
                          "load phantom:sphere; surface s iso=0.5; size 64x64; digest; stats")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["command"].split()[0] for line in lines],
                         ["load", "surface", "size", "digest", "stats"])
        self.assertTrue(all(line["ok"] and line["ms"] >= 0 for line in lines))
        self.assertGreater(lines[1]["result"]["triangles"], 0)
        self.assertGreater(lines[4]["result"]["frame"]["instructions"], 0)

    def test_script_file_stops_at_the_first_failure_with_its_code(self):
        script = self.path("a.txt")
        pathlib.Path(script).write_text("# a comment\nload phantom:sphere\nview nowhere\nstats\n")
        done = self.pxpl5("run", script)
        self.assertEqual(done.returncode, 64)
        self.assertIn("there is no view 'nowhere'", done.stderr)
        self.assertNotIn("last frame", done.stdout)

    def test_usage_errors_are_64_and_name_the_values(self):
        for arguments, text in ((["run", "-c", "snapshit x"], "did you mean 'snapshot'"),
                                (["run", "-c", "load phantom:pelvix"], "phantom:pelvis"),
                                (["run", "-c", "surface a iso=1"], "no volume is loaded"),
                                (["run", "-c", "size 0x5"], "0 is outside 1"),
                                (["render", "scan.nrrd", "-o", "x.png"], "--iso"),
                                (["run", "--set", "gp.count=65"], "65"),
                                (["run", "--set", "gp.cout=2"], "count")):
            done = self.pxpl5(*arguments)
            self.assertEqual(done.returncode, 64, (arguments, done))
            self.assertIn(text, done.stderr, arguments)

    def test_the_shell_command_line_names_the_nearest_word(self):
        for arguments, text in (
                (["rendr", "x"], "pxpl5 has no subcommand 'rendr'; did you mean 'render'?"),
                (["trace", "bogus", "--help"], "trace has no subcommand 'bogus'"),
                (["trace"], "error: trace needs a subcommand: ls, dump, "),
                (["join", "tcp://127.0.0.1:4711"], "1 option from [--key-file,"),
                (["render", "phantom:sphere", "--opacty", "1", "-o", "x.png"],
                 "did you mean '--opacity'?"),
                (["run", "-c", "help", "extra"], "unexpected argument 'extra'"),
                (["render", "phantom:sphere", "--isovalue", "1", "-o", "x.png"],
                 "no option '--isovalue'; did you mean '--iso'?"),
                (["render", "phantom:sphere", "--iso", "-o", "x.png"],
                 "--iso needs a value V; found '-o'"),
                (["render"], "usage: pxpl5 render VOLUME [KEY=VALUE ...] -o FILE\n"),
                (["atlas", "chart.png"],
                 "'atlas' is a command: pxpl5 run -c \"load FILE; atlas ...\""),
                (["load", "a.nrrd"], "'load' is a command: pxpl5 run -c \"load ...\""),
                (["why", "256", "200"], "X and Y of the pixel are missing"),
                (["why-not", "latest"], "for example: why-not latest-recorded 256 200"),
                (["why-not", "latest", "1", "1", "--surface", "bone"],
                 "--surface must be a number, but is 'bone'"),
                (["run", "-c", "surface a threshold=0"], "did you mean 'iso'?"),
                (["run", "-c", "load phantom:sphere; view front"], "did you mean 'anterior'?"),
                (["run", "--set", "gps=2"], "did you mean 'gp.count'?"),
                (["--json", "info", "phantom:sphere"],
                 "'--json' goes behind 'info', whose option it is: pxpl5 info VOLUME"),
                (["info", ""], "the name of the volume is empty"),
                (["run", "-c", "surface a --iso 0"], "write iso=0, not --iso 0"),
                (["run", "-c", "light three-point 3"], "light three-point: takes no further words"),
                (["run", "-c", "light 1"], "light 1: give azimuth and elevation, or off"),
                (["help", "snapsot"], "did you mean 'snapshot'? 'help' lists the commands"),
                (["render", "phantom:sphere", "-o", "x.jps"],
                 "render: x.jps holds a picture for each eye, but stereo is off"),
                (["render", "phantom:sphere", "--stereo", "off", "-o", "x.MPO"],
                 "render: x.MPO holds a picture for each eye, but stereo is off")):
            done = self.pxpl5(*arguments, machine=False)
            self.assertEqual(done.returncode, 64, (arguments, done))
            self.assertIn(text, done.stderr, arguments)
        self.assertIn("Usage: pxpl5 [OPTIONS]", self.pxpl5(machine=False).stdout)

    def test_help_tells_of_the_program_a_subcommand_or_a_command(self):
        for words, text in (((), "Usage: pxpl5 [OPTIONS]"), (("render",), "Usage: render"),
                            (("snapshot",), "snapshot FILE")):
            done = self.pxpl5("help", *words, machine=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), done)
            self.assertIn(text, done.stdout)

    def test_the_certificate_of_no_triangles_warns(self):
        done = self.pxpl5("run", "--json", "-c",
                          "load phantom:sphere; surface s iso=9000; certificate s")
        self.assertEqual(done.returncode, 0, done)
        self.assertEqual(json.loads(done.stdout.splitlines()[-1])["warnings"], ["s: no triangles"])

    def test_an_option_takes_one_value_and_the_volume_may_follow(self):
        done = self.pxpl5("render", "--surface", "bone=300", "--light", "1 30 20", "--opacity",
                          "0.5", "phantom:pelvis", "--json", "-o", self.path("x.png"))
        self.assertEqual(done.returncode, 0, done)
        lines = [json.loads(line)["command"] for line in done.stdout.splitlines()]
        self.assertEqual(lines, ["light 1 30 20", "load phantom:pelvis",
                                 "surface bone iso=300 opacity=0.5", "view fit=yes",
                                 f"snapshot {self.path('x.png')}"])

    def test_outputs_are_checked_before_any_work(self):
        for output, code in (("x.jpg", 64), ("/no/such/folder/x.png", 1)):
            done = self.pxpl5("render", "phantom:pelvis", "-o", output)
            self.assertEqual(done.returncode, code, done)
            self.assertEqual(done.stdout, "")
            self.assertFalse(os.path.exists(self.path("run")))

    def test_questions_leave_no_run_folder(self):
        for arguments in (["run", "-c", "help surface"], ["info", "phantom:sphere"]):
            done = self.pxpl5(*arguments, machine=False)
            self.assertEqual(done.returncode, 0, done)
            self.assertEqual(os.listdir(self.folder.name), [])

    def test_a_closed_pipe_does_not_stop_the_work(self):
        done = subprocess.run(
            f"'{BIN}/pxpl5' run --topology one-of-each -c 'load phantom:sphere; "
            f"surface s iso=0.5; stats; snapshot s.png' | head -1; exit ${{PIPESTATUS[0]}}",
            shell=True, executable="/bin/bash", capture_output=True, text=True, timeout=LIMIT_S,
            cwd=self.folder.name, check=False)
        self.assertEqual(done.returncode, 0, done)
        self.assertEqual(done.stderr, "")
        self.assertEqual(png_size(self.path("s.png")), (512, 512))

    def test_unknown_machine_is_named(self):
        done = self.pxpl5("run", "-c", "stats", topology="paper-1994")
        self.assertEqual(done.returncode, 64)
        self.assertIn("paper-1994", done.stderr)

    def test_bad_files_are_65_by_name_and_the_machine_goes_on(self):
        bad = self.path("bad.nrrd")
        pathlib.Path(bad).write_text("this is not a volume\n")
        done = self.pxpl5("render", bad, "--iso", "1", "-o", self.path("x.png"))
        self.assertEqual(done.returncode, 65, done)
        self.assertIn("bad.nrrd", done.stderr)
        self.assertFalse(os.path.exists(self.path("x.png")))
        done = self.pxpl5("run", "--keep-going", "-c",
                          f"load '{bad}'; load phantom:sphere; surface surface; "
                          f"snapshot '{self.path('s.png')}'")
        self.assertEqual(done.returncode, 65, done)
        self.assertEqual(png_size(self.path("s.png")), (512, 512))
        missing = self.pxpl5("info", self.path("absent.nii"), machine=False)
        self.assertEqual(missing.returncode, 65, missing)
        self.assertIn("absent.nii", missing.stderr)

    def test_a_small_local_memory_is_a_fault_that_says_how_many_gps_would_do(self):
        done = self.pxpl5("run", "--set", "gp.memory_mib=1", "-c", "load phantom:pelvis")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"\d+ GPs")

    def start(self, topology):
        """A machine that waits for commands, with its processes."""
        child = subprocess.Popen(
            [BIN / "pxpl5", "run", "-", "--run-folder", self.path("run"), "--topology", topology,
             *ENDS],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            cwd=self.folder.name, env={**os.environ, "XDG_RUNTIME_DIR": self.folder.name})
        child.stdin.write("load phantom:sphere\n")
        child.stdin.flush()
        self.wait_for(child, "distributed in")
        nodes = children_of(child.pid)
        self.assertGreaterEqual(len(nodes), 3)
        return child, nodes

    def wait_for(self, child, text):
        """Reads what the program prints up to the line that holds `text`."""
        for line in child.stdout:
            if text in line:
                return
        self.fail(f"the program ended before it printed '{text}': {child.stderr.read()}")

    def assert_all_ended(self, child, nodes):
        for pid in nodes:
            self.assertFalse(os.path.exists(f"/proc/{pid}"), f"process {pid} is still there")
        self.assertFalse(children_of(child.pid))

    def test_killing_any_process_ends_the_run_by_name_and_leaves_none(self):
        for victim in ("pxpl5-gp", "pxpl5-renderer", "pxpl5-framebuff"):
            child, nodes = self.start("one-of-each")
            pid = next(pid for pid in nodes if name_of(pid) == victim)
            os.kill(pid, signal.SIGKILL)
            child.stdin.write("surface a iso=0.5\norbit 1000\n")
            child.stdin.close()
            child.wait(timeout=LIMIT_S)
            error = child.stderr.read()
            self.assertEqual(child.returncode, 128 + 9, error)
            names = {"pxpl5-gp": "gp-0", "pxpl5-renderer": "renderer-0"}
            self.assertIn(names.get(victim, "framebuffer-0"), error)
            self.assertIn("SIGKILL", error)
            self.assert_all_ended(child, nodes)
            child.stdout.close()
            child.stderr.close()

    def test_kill_names_its_victim_and_the_run_ends_of_it(self):
        for commands in ("kill gp-0", "kill gp-0; digest"):
            done = self.pxpl5("run", *ENDS, "-c",
                              "load phantom:sphere; surface s iso=0.5; " + commands)
            self.assertEqual(done.returncode, 128 + signal.SIGKILL, done.stderr)
            self.assertIn("gp-0 killed", done.stdout)
            self.assertNotIn("frame ", done.stdout)
            self.assertIn("gp-0 was killed by signal 9", done.stderr.splitlines()[-1])
        done = self.pxpl5("run", "-c", "kill gp-7")
        self.assertEqual(done.returncode, 64, done.stderr)
        self.assertIn("there is no node 'gp-7'; did you mean 'gp-0'?", done.stderr)

    def test_activity_tells_what_54_processes_did(self):
        done = self.pxpl5("run", "--json", "-c", "load phantom:sphere; surface s iso=0.5;"
                          "activity; orbit 4; activity", topology="paper-1993")
        self.assertEqual(done.returncode, 0, done.stderr)
        machine = json.loads(done.stdout.splitlines()[-1])["result"]
        self.assertEqual(machine["frames"], 4)
        self.assertEqual(len(machine["nodes"]), 54)
        for node in machine["nodes"]:
            self.assertTrue(node["answered"], node)
            self.assertLessEqual(node["busy"], 1)
            if node["role"] != "host":
                self.assertEqual(node["frames"], 4, node["name"])
            if node["role"] == "gp":
                programs = sum(sent["messages"] for sent in node["sent"]
                               if sent["kind"] == "RegionPrograms")
                self.assertEqual(programs, 4 * 16, node["name"])
        self.assertEqual(len(machine["channels"]), 8)
        self.assertTrue(all(channel["messages"] > 0 for channel in machine["channels"]))
        regions = machine["frame"]["regions"]
        self.assertEqual((regions["columns"], regions["rows"]), (4, 4))
        self.assertEqual(len(regions["renderer"]), 16)
        self.assertGreater(machine["frame"]["renderer_ms_1993"], 0)

    def test_interrupt_leaves_no_process(self):
        child, nodes = self.start("one-of-each")
        child.stdin.write("surface a iso=0.5\norbit 100000\n")
        child.stdin.flush()
        self.wait_for(child, "triangles")
        child.send_signal(signal.SIGINT)
        _, error = child.communicate(timeout=LIMIT_S)
        self.assertEqual(child.returncode, 128 + 2, error)
        self.assert_all_ended(child, nodes)

    def test_the_1993_machine_draws_the_same_frame_as_the_smallest(self):
        commands = "load phantom:letters; surface surface; size 300x200; view 30 20; digest"
        digests = set()
        for topology in ("one-of-each", "default", "paper-1993"):
            done = self.pxpl5("run", "--json", "-c", commands, topology=topology)
            self.assertEqual(done.returncode, 0, done.stderr)
            digests.add(json.dumps(json.loads(done.stdout.splitlines()[-1])["result"]))
        self.assertEqual(len(digests), 1)

    def assert_killed_by_the_host(self, child, nodes, code, text):
        """The program, whose input stays open, has ended by itself for that reason."""
        child.wait(timeout=LIMIT_S)
        error = child.stderr.read()
        self.assertEqual(child.returncode, code, error)
        self.assertIn(text, error)
        self.assertNotIn("still running", error)
        self.assert_all_ended(child, nodes)
        self.assertEqual(list(pathlib.Path(self.folder.name).glob("pxpl5-*")), [], "sockets")
        for stream in (child.stdin, child.stdout, child.stderr):
            stream.close()

    def test_a_signal_ends_a_host_that_waits_for_a_line(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            child, nodes = self.start("one-of-each")
            child.send_signal(number)
            self.assert_killed_by_the_host(child, nodes, 128 + number, "interrupted by " +
                                           signal.Signals(number).name)

    def test_ctrl_c_in_a_load_ends_a_script(self):
        child, nodes = self.start("one-of-each")
        gp = next(pid for pid in nodes if name_of(pid) == "pxpl5-gp")
        os.kill(gp, signal.SIGSTOP)
        child.stdin.write("load phantom:head\nload phantom:letters\n")
        child.stdin.flush()
        self.assertTrue(any("warning: gp-0" in line for line in child.stderr))
        child.send_signal(signal.SIGINT)
        os.kill(gp, signal.SIGCONT)
        self.assert_killed_by_the_host(child, nodes, 128 + signal.SIGINT, "interrupted by SIGINT")

    def test_a_node_killed_while_the_host_waits_for_a_line_ends_the_run(self):
        child, nodes = self.start("one-of-each")
        os.kill(next(pid for pid in nodes if name_of(pid) == "pxpl5-gp"), signal.SIGKILL)
        self.assert_killed_by_the_host(child, nodes, 128 + 9, "gp-0 was killed by signal 9")

    def test_a_script_may_come_through_a_named_pipe(self):
        os.mkfifo(self.path("script"))
        child = subprocess.Popen(
            [BIN / "pxpl5", "run", self.path("script"), "--topology", "one-of-each"],
            stdout=subprocess.PIPE, text=True, cwd=self.folder.name)
        with open(self.path("script"), "w") as script:
            script.write("load phantom:sphere\nload phantom:")
            script.flush()
            self.wait_for(child, "distributed in")
            script.write("sphere")  # The last line needs no newline.
        output, _ = child.communicate(timeout=LIMIT_S)
        self.assertEqual(child.returncode, 0, output)
        self.assertIn("distributed in", output)

    def test_a_line_without_an_end_is_refused(self):
        done = subprocess.run([BIN / "pxpl5", "run", "--topology", "one-of-each"],
                              input="x" * 2000000, capture_output=True, text=True,
                              timeout=LIMIT_S, cwd=self.folder.name)
        self.assertEqual(done.returncode, 64, done.stderr[-200:])
        self.assertIn("a line has more than 1048576 bytes", done.stderr[-200:])

    def test_output_that_cannot_be_written_is_an_error(self):
        for flags in ([], ["--json"], ["--keep-going"]):
            with open("/dev/full", "w") as full:
                done = subprocess.run(
                    [BIN / "pxpl5", "run", "-c", "load phantom:sphere; stats", "--topology",
                     "one-of-each", *flags], stdout=full, stderr=subprocess.PIPE, text=True,
                    timeout=LIMIT_S, cwd=self.folder.name)
            self.assertEqual(done.returncode, 1, (flags, done))
            self.assertEqual(done.stderr, "error: standard output cannot be written: "
                             "No space left on device\n")

    def test_a_picture_beyond_the_file_size_limit_is_an_error_that_leaves_no_file(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (20 * 1024, 20 * 1024))
        pathlib.Path(self.path("pictures")).mkdir()
        for suffix in ("png", "tif", "exr"):
            done = subprocess.run(
                [BIN / "pxpl5", "run", "--topology", "one-of-each", "-c",
                 "load phantom:pelvis; surface bone; size 1024x1024; "
                 f"snapshot '{self.path('pictures/p.' + suffix)}'"],
                capture_output=True, text=True, timeout=LIMIT_S, cwd=self.folder.name,
                preexec_fn=limit)
            self.assertEqual(done.returncode, 1, (suffix, done))
            self.assertIn("p." + suffix + ": cannot be written", done.stderr)
            self.assertEqual(os.listdir(self.path("pictures")), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
