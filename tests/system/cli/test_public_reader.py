#!/usr/bin/env python3
"""Reads recorded runs with the public MCAP reader, checksums and embedded schema included.

usage: test_public_reader.py BIN_FOLDER

Needs node, and @mcap/core, fzstd, flatbuffers and flatbuffers_reflection (npm) in NODE_PATH; says
SKIPPED without them.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

READER = pathlib.Path(__file__).with_name("read_mcap.mjs")
MODULES = ["@mcap/core", "fzstd", "flatbuffers", "flatbuffers_reflection"]
COMMANDS = "load phantom:letters;surface a iso=500;orbit 3;trace save"


def check(good, what):
    """Ends the test, saying `what` is wrong, unless `good`."""
    if not good:
        sys.exit(f"FAILED: {what}")


def check_run(program, recording):
    """Records a run and reads all of its traces."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "run", "--record", recording, "--run-folder", folder, "--set",
                        "gp.count=2", "-c", COMMANDS], check=True, stdout=subprocess.DEVNULL)
        files = sorted(pathlib.Path(folder).glob("*/traces/*.mcap"))
        check(len(files) >= 5, f"{len(files)} traces")
        output = subprocess.run(["node", str(READER), *map(str, files)], check=True,
                                stdout=subprocess.PIPE, text=True).stdout
    for path, line in zip(files, output.splitlines(), strict=True):
        report = json.loads(line)
        where = f"{recording} {path.name}: {report}"
        check(report["indexed"] == report["streamed"] == report["counted"] > 0, where)
        check(report["done"] and report["first"]["wall_ns_is_log_time"], where)
        check(report["first"]["body_bytes"] > 0, where)
        check(report["metadata"]["pxpl5"]["recording"] == recording, where)
        if path.name.startswith("renderer"):
            check("/gp-1/RegionPrograms" in report["topics"], where)
        if path.name.startswith("host"):
            check("isa_hash" in report["metadata"]["pxpl5"], where)


def main():
    resolve = "".join(f"require.resolve('{name}');" for name in MODULES)
    if shutil.which("node") is None or subprocess.run(
            ["node", "-e", resolve], stderr=subprocess.DEVNULL, check=False).returncode != 0:
        print(f"SKIPPED: node or its modules {', '.join(MODULES)} are not there (NODE_PATH)")
        return
    for recording in ["flight", "full"]:
        check_run(str(pathlib.Path(sys.argv[1]) / "pxpl5"), recording)
    print("the public reader agrees")


if __name__ == "__main__":
    main()
