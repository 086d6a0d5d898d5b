#!/usr/bin/env python3
"""Odd surroundings change no bit: clocks, disks, locales, limits, namespaces, names of files.

usage: test_surroundings.py BIN LIBRARY    LIBRARY is that of other_computer.cpp
"""
import itertools
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN, LIBRARY = pathlib.Path(), ""  # From the command line.
LIMIT_S = 120
SCENE = "load phantom:sphere; surface s iso=0.2; digest"
OTHER_USER = 65534


def limited(*limits):
    def limit():
        for what, value in limits:
            resource.setrlimit(what, (value, value))
    return limit


class Surroundings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.parent = pathlib.Path(cls.enterClassContext(
            tempfile.TemporaryDirectory(prefix="pxpl5-around-")))
        cls.usual = cls.digest_in(cls.parent)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.parent))

    @staticmethod
    def run_in(folder, commands, *words, before=(), env=None, **more):
        variables = {**os.environ, "XDG_STATE_HOME": str(folder / "state"),
                     "XDG_RUNTIME_DIR": ""} if env is None else env
        return subprocess.run(
            [*before, BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", *words, "-c",
             commands], capture_output=True, cwd=folder, timeout=LIMIT_S, check=False,
            env=variables, **more)

    @classmethod
    def digest_in(cls, folder, *words, **more):
        done = cls.run_in(folder, SCENE, *words, **more)
        assert done.returncode == 0, done.stderr.decode()
        return json.loads(done.stdout.splitlines()[-1])["result"]

    def check(self, *words, **more):
        self.assertEqual(self.digest_in(self.folder, *words, **more), self.usual)

    def environment(self, **more):
        return {**os.environ, "XDG_STATE_HOME": str(self.folder / "state"), "XDG_RUNTIME_DIR": "",
                **more}

    def test_wall_clocks(self):
        """Epoch 0, the year 10000, a clock that stands still, and one that runs backwards."""
        for number, clock in enumerate(("0 1", "253402300800 1", "1000000000 0", "1000000000 -50")):
            with self.subTest(clock=clock):
                runs = self.folder / str(number)
                self.check("--run-folder", runs, "--record", "full",
                           env=self.environment(LD_PRELOAD=LIBRARY, OTHER_CLOCK=clock))
                run, = runs.iterdir()
                listed = subprocess.run([BIN / "pxpl5", "trace", "ls", run], check=False,
                                        capture_output=True, text=True, timeout=LIMIT_S)
                self.assertEqual((listed.returncode, listed.stderr), (0, ""))
                self.assertIn("renderer-0", listed.stdout)
        said = subprocess.run(["date", "+%Y"], env=self.environment(
            LD_PRELOAD=LIBRARY, OTHER_CLOCK="253402300800 1", TZ="UTC"), capture_output=True,
            text=True, check=True).stdout
        self.assertEqual(said, "10000\n")  # The library works.

    def test_a_file_that_does_not_reach_the_disk_replaces_none(self):
        """After a power failure it could be empty."""
        files = {"x.stl": "export", "x.obj": "export", "x.png": "snapshot", "x.txt": "history"}
        for file, command in files.items():
            (self.folder / file).write_text("old")
            done = self.run_in(self.folder, f"{SCENE}; {command} {file}",
                               env=self.environment(LD_PRELOAD=LIBRARY, SYNC_FAILS="1"))
            self.assertEqual(done.returncode, 1, done)
            error = json.loads(done.stdout.splitlines()[-1])["error"]
            self.assertRegex(error, f"{file}.* cannot be written: Input/output error")
            self.assertEqual((self.folder / file).read_text(), "old")
        self.assertEqual(sorted(os.listdir(self.folder)), sorted(["state", *files]))

    @unittest.skipUnless(os.geteuid() == 0, "only root can make a namespace of clocks")
    def test_a_monotonic_clock_far_ahead(self):
        before = ["unshare", "--time", "--fork", "--monotonic", "1000000000", "--boottime",
                  "1000000000"]
        if subprocess.run([*before, "true"], check=False, stderr=subprocess.DEVNULL).returncode:
            self.skipTest("this kernel has no namespaces of clocks")
        self.check(before=before)

    def test_locales(self):
        if not shutil.which("localedef") or not pathlib.Path("/usr/share/i18n/locales").exists():
            self.skipTest("the sources of locales are not installed")
        for name, charmap in (("de_DE", "ISO-8859-1"), ("tr_TR", "UTF-8"), ("ar_EG", "UTF-8")):
            subprocess.run(["localedef", "-i", name, "-f", charmap, self.folder / name],
                           check=False, capture_output=True, timeout=LIMIT_S)
            self.assertTrue((self.folder / name / "LC_NUMERIC").exists())
            self.check(env=self.environment(LC_ALL=name, LOCPATH=str(self.folder)))

    def test_a_locale_that_is_not_installed(self):
        self.check(env=self.environment(LC_ALL="xx_YY.UTF-8", LANG="\udcff"))

    def test_limits(self):
        self.check(preexec_fn=limited((resource.RLIMIT_AS, 600 << 20)))
        self.check(preexec_fn=limited((resource.RLIMIT_STACK, 64 << 10),
                                      (resource.RLIMIT_MEMLOCK, 0)))

    def test_without_any_variable(self):
        self.check(env={})

    @unittest.skipUnless(os.geteuid() == 0, "only root can change mounts and capabilities")
    def test_namespaces_and_capabilities(self):
        own_processes = ["unshare", "--mount", "--pid", "--fork", "--mount-proc"]
        hidden = "mount -o remount,hidepid=2 /proc && exec \"$@\""
        other_user = ["setpriv", f"--reuid={OTHER_USER}", f"--regid={OTHER_USER}", "--clear-groups"]
        self.folder.chmod(0o777)
        self.parent.chmod(0o755)
        for name, before in {
                "no capabilities": ["setpriv", "--bounding-set=-all", "--inh-caps=-all"],
                "another user": other_user,
                "no shared memory folder": [
                    "unshare", "--mount", "sh", "-c",
                    "mount -t tmpfs -o ro,size=4k none /dev/shm && exec \"$@\"", "sh"],
                "processes of others hidden": [*own_processes, "sh", "-c", hidden, "sh",
                                               *other_user]}.items():
            with self.subTest(name):
                self.check(before=before)
                shutil.rmtree(self.folder / "state")

    @unittest.skipUnless(os.geteuid() == 0, "only root can unmount /proc")
    def test_without_proc_the_error_says_so(self):
        done = self.run_in(self.folder, SCENE, before=["unshare", "--mount", "sh", "-c",
                                                       "umount -l /proc && exec \"$@\"", "sh"])
        self.assertEqual(done.returncode, 69, done)
        self.assertIn(b"/proc/self/exe: No such file or directory. Run it where /proc is mounted",
                      done.stderr)

    def test_names_of_files(self):
        """A name in quotes is one word, whatever is in it."""
        long = "/".join(["x" * 250] * 8)
        (self.folder / long).mkdir(parents=True)
        lines, files = [*SCENE.split("; ")], []
        writers = itertools.cycle((("export", ".ply"), ("snapshot", ".png")))
        for name in ("a b", "\u00e4\u65e5\u672c", "a;b", "#a", "a'b", "{0}", "%s%n", "-a", "~",
                     "$(touch x)", "\udcff", f"{long}/a"):
            command, suffix = next(writers)
            quote = '"' if "'" in name else "'"
            lines.append(f"{command} {quote}{name}{suffix}{quote}")
            files.append(self.folder / f"{name}{suffix}")
        done = self.run_in(self.folder, "\n".join(lines))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.decode().splitlines()), len(lines))
        for file in files:
            self.assertGreater(file.stat().st_size, 100, ascii(file))
        self.assertFalse((self.folder / "x").exists())

    def test_a_run_folder_that_goes_away(self):
        runs = self.folder / "runs"
        with subprocess.Popen(
                [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder", runs,
                 "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                text=True) as program:
            for line in SCENE.split("; ")[:-1]:
                program.stdin.write(line + "\n")
                program.stdin.flush()
                self.assertTrue(json.loads(program.stdout.readline())["ok"])
            shutil.rmtree(runs)
            out, errors = program.communicate("digest\n", LIMIT_S)
        self.assertEqual(program.returncode, 0, errors)
        self.assertEqual(json.loads(out)["result"], self.usual)

    def test_a_volume_that_is_cut_while_it_is_read(self):
        """The voxels of before, or an error that names the file. Both can come."""
        volume = self.folder / "v.raw"
        for bytes_left in (0, 1 << 20, (1 << 24) - 1):
            volume.write_bytes(bytes(1 << 24))
            with subprocess.Popen(
                    [BIN / "pxpl5", "run", "--json", "--topology", "one-of-each", "--run-folder",
                     self.folder / "runs", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE, text=True) as program:
                program.stdin.write(f"load {volume} raw=256x256x256,uint8 spacing=1,1,1\n")
                program.stdin.flush()
                os.truncate(volume, bytes_left)
                out, errors = program.communicate("digest\n", LIMIT_S)
            first = json.loads(out.splitlines()[0])
            if not first["ok"]:
                self.assertIn("v.raw", first["error"])
                self.assertIn(program.returncode, (65, 69), errors)


if __name__ == "__main__":
    LIBRARY = str(pathlib.Path(sys.argv.pop(2)).resolve())
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
