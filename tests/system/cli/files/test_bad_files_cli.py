#!/usr/bin/env python3
"""Files and places that cannot be read or written, as the user meets them.

usage: test_bad_files_cli.py BIN_DIR [unittest arguments]
"""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
LIMIT_S = 120
BAD_DATA = 65
RAW, RLE = b"1.2.840.10008.1.2.1\0", b"1.2.840.10008.1.2.5\0"


def element(group, number, kind, value):
    value = struct.pack("<H", value) if isinstance(value, int) else value
    value += b" " * (len(value) % 2)
    size = struct.pack("<HI", 0, len(value)) if kind in ("OB", "OW") else struct.pack(
        "<H", len(value))
    return struct.pack("<HH", group, number) + kind.encode() + size + value


def item(value=b""):
    return struct.pack("<HHI", 0xfffe, 0xe000, len(value)) + value


def dicom(syntax, pixels, z_mm=0):
    """A slice of 2 x 2 voxels of 16 bits."""
    meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", b"1.2.840.10008.5.1.4.1.1.2\0") +
            element(2, 3, "UI", b"1.2.3.4\0") + element(2, 0x10, "UI", syntax))
    body = [(8, 0x60, "CS", b"CT"), (0x20, 0xe, "UI", b"1.2.3\0"),
            (0x20, 0x32, "DS", b"0\\0\\%d" % z_mm), (0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0"),
            (0x28, 2, "US", 1), (0x28, 4, "CS", b"MONOCHROME2"), (0x28, 0x10, "US", 2),
            (0x28, 0x11, "US", 2), (0x28, 0x30, "DS", b"1\\1"), (0x28, 0x100, "US", 16),
            (0x28, 0x101, "US", 16), (0x28, 0x102, "US", 15), (0x28, 0x103, "US", 0)]
    return (bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta +
            b"".join(element(*each) for each in body) + pixels)


def damaged(z_mm=0):
    """The pixels state 3 segments of RLE, of which values of 2 bytes need 2. GDCM would assert."""
    frame = struct.pack("<16I", 3, 64, 66, 68, *[0] * 12) + b"\xff\1" * 3
    pixels = struct.pack("<HH2sHI", 0x7fe0, 0x10, b"OW", 0, 0xffffffff)
    return dicom(RLE, pixels + item() + item(frame) + struct.pack("<HHI", 0xfffe, 0xe0dd, 0), z_mm)


DAMAGE = ("frame 1 of its RLE pixels has 3 segments, values of 2 bytes need 2. The file is "
          "damaged")


class BadFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_lines(self, *lines, output=False):
        """The exit code, and the last line of standard error or the whole output."""
        done = subprocess.run(
            [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder",
             self.folder / "run", "-c", "\n".join(lines)], capture_output=True, text=True,
            timeout=LIMIT_S, cwd=self.folder, check=False)
        if output:
            return done.returncode, done.stdout
        return done.returncode, done.stderr.splitlines()[-1] if done.stderr else ""

    def test_a_file_on_which_the_dicom_library_would_assert_is_refused_by_name(self):
        (self.folder / "x.dcm").write_bytes(damaged())
        code, error = self.run_lines("load x.dcm")
        self.assertEqual(code, BAD_DATA)
        self.assertEqual(error, f"error: x.dcm: {DAMAGE}")

    def test_the_damaged_file_of_a_folder_is_named_and_left_out(self):
        (self.folder / "ct").mkdir()
        for z_mm in (0, 1, 3):
            pixels = element(0x7fe0, 0x10, "OW", bytes(8))
            (self.folder / "ct" / f"{z_mm}.dcm").write_bytes(dicom(RAW, pixels, z_mm))
        (self.folder / "ct" / "2.dcm").write_bytes(damaged(2))
        code, text = self.run_lines("load ct", output=True)
        self.assertEqual(code, 0)
        self.assertIn(f"missing slices: ct/2.dcm: {DAMAGE}: this file is left out", text)
        self.assertIn("2 x 2 x 3 voxels", text)

    def test_an_archive_opens_as_its_folder_and_a_cut_one_is_refused_by_name(self):
        (self.folder / "ct").mkdir()
        for z_mm in range(3):
            pixels = element(0x7fe0, 0x10, "OW", bytes([z_mm, 0] * 4))
            (self.folder / "ct" / f"{z_mm}.dcm").write_bytes(dicom(RAW, pixels, z_mm))
        draw = ["surface a iso=0.5", "digest"]
        code, text = self.run_lines("load ct", *draw, output=True)
        self.assertEqual(code, 0, text)
        digest = text.splitlines()[-1]
        for name, form in (("ct.zip", "zip"), ("ct.tar", "tar"), ("ct.tar.gz", "gztar"),
                           ("ct.tar.bz2", "bztar"), ("ct.tar.xz", "xztar")):
            with self.subTest(name=name):
                shutil.make_archive(self.folder / "ct", form, self.folder, "ct")
                code, text = self.run_lines(f"load {name}", *draw, output=True)
                self.assertEqual(code, 0, text)
                self.assertEqual(text.splitlines()[-1], digest)
                whole = (self.folder / name).read_bytes()
                (self.folder / name).write_bytes(whole[:len(whole) * 2 // 3])
                code, error = self.run_lines(f"load {name}")
                self.assertEqual(code, BAD_DATA)
                self.assertRegex(error, f"^error: {name}.*(damaged|cut)")
        self.assertEqual(sorted(each.name for each in self.folder.iterdir()),
                         ["ct", "ct.tar", "ct.tar.bz2", "ct.tar.gz", "ct.tar.xz", "ct.zip", "run"])

    def test_what_is_no_file_is_named_by_what_it_is(self):
        os.mkfifo(self.folder / "pipe.nii")
        for line, words in (("load pipe.nii", "pipe.nii: is a FIFO, not a file"),
                            ("load /dev/zero", "/dev/zero: is a device, not a file"),
                            ("load /dev/zero raw=2x2x2,uint8 spacing=1,1,1",
                             "/dev/zero: is a device, not a file"),
                            ("load none.raw raw=2x2x2,uint8 spacing=1,1,1",
                             "none.raw: does not exist"),
                            ("certificate none.stl", "none.stl: does not exist")):
            with self.subTest(line=line):
                code, error = self.run_lines(line)
                self.assertEqual(code, BAD_DATA)
                self.assertEqual(error, "error: " + words)

    def test_files_of_the_kernel_are_refused_before_they_are_read(self):
        """A second read of /proc/kmsg waits for the next message of the kernel."""
        for name in ("link.nii.gz", "link.stl"):
            (self.folder / name).symlink_to("/proc/kmsg")
        reason = "is a file of the kernel, not a stored file"
        for line, name in (("load /proc/kmsg", "/proc/kmsg"), ("load /proc/kmsg", "/proc/kmsg"),
                           ("load /proc/self/mem", "/proc/self/mem"),
                           ("load /proc/self/mem raw=2x2x2,uint8 spacing=1,1,1", "/proc/self/mem"),
                           ("load link.nii.gz", "link.nii.gz"),
                           ("certificate link.stl", "link.stl")):
            with self.subTest(line=line):
                self.assertEqual(self.run_lines(line), (BAD_DATA, f"error: {name}: {reason}"))
        for folder in ("/proc", "/proc/self", "/sys/kernel"):
            with self.subTest(folder=folder):
                self.assertEqual(self.run_lines(f"load {folder}"), (
                    BAD_DATA,
                    f"error: {folder}: is a folder of the kernel, not of stored files"))

    def test_info_of_a_file_of_the_kernel_ends(self):
        for name in ("/proc/kmsg", "/proc/self/mem", "/dev/zero"):
            done = subprocess.run([BIN / "pxpl5", "info", name], capture_output=True, text=True,
                                  timeout=LIMIT_S, cwd=self.folder, check=False)
            self.assertEqual(done.returncode, BAD_DATA, done)
            self.assertRegex(done.stderr, f"^error: {name}: is a .*, not a (stored )?file\n$")

    def test_an_output_that_is_a_folder_is_named_as_one(self):
        (self.folder / "m.stl").mkdir()
        (self.folder / "plain").mkdir()
        for line, name in (("export m.stl", "m.stl"), ("export plain", "plain"),
                           ("snapshot plain", "plain"), ("snapshot m.stl/", "m.stl/")):
            with self.subTest(line=line):
                code, error = self.run_lines("load phantom:sphere", "surface a iso=0", line)
                self.assertEqual(code, 1)
                self.assertEqual(error, f"error: {name}: is a folder, not a file: give the name of "
                                        "a file in it")

    def test_an_output_that_is_a_link_is_followed(self):
        (self.folder / "far").mkdir()
        for name in ("m.stl", "p.png", "s.txt"):
            (self.folder / name).symlink_to(pathlib.Path("far") / ("other-" + name))
        (self.folder / "far" / "other-m.stl").write_text("old")
        code, error = self.run_lines("load phantom:sphere", "surface a iso=0", "export m.stl",
                                     "snapshot p.png size=64x64", "history s.txt",
                                     "certificate m.stl")
        self.assertEqual((code, error), (0, ""))
        for name in ("m.stl", "p.png", "s.txt"):
            self.assertTrue((self.folder / name).is_symlink())
            self.assertGreater((self.folder / "far" / ("other-" + name)).stat().st_size, 20)
        self.assertEqual(len(list((self.folder / "far").iterdir())), 3)
        self.assertTrue((self.folder / "m.stl.certificate.json").exists())


if __name__ == "__main__":
    unittest.main()
