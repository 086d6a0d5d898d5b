#!/usr/bin/env python3
"""Runs the commands of every Markdown page as a reader pastes them: test_pages.py BIN_DIR.

README.md has a test of its own, test_readme.py. A block of commands is fenced as `sh`. A command
that cannot run here is in EXCUSED, with its reason.
"""
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import pages

BIN = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else None
README = "README.md"
BENCH = "tests/bench/README.md"
CLUSTER = "tests/cluster/README.md"
COMPUTERS = "host/machine/computers/README.md"
KUBERNETES = "host/kubernetes/README.md"
PODS = "needs a cluster; system/kubernetes checks the manifests and runs their programs"
SEVERAL = "needs several computers; cluster/machines runs the engines where they are"
ROOT = "needs root and namespaces; cluster/harness runs the program where they are"
MINUTES = "takes minutes; the bench tests run the same program for a short time"
LONG = "takes minutes and needs the peers or a quiet machine"
FUZZ = "builds with sanitizers and takes minutes; CI runs the same script for 20 s per target"
SERVE = "host/serve/README.md"
SESSIONS = "host/machine/sessions/README.md"
RUNNING = "needs a running session; system/sessions starts some"
EXCUSED = {
    (README, "host/launch.sh"): "installs packages as root and builds the release preset",
    (README, "export PATH=$PWD/build/release/bin:$PATH"): "every test has the binaries in its PATH",
    ("host/report/README.md", "pxpl5 report --paper --data FOLDER"):
        "needs the real volumes; system/report_data runs the command where they are",
    ("host/report/README.md", "pxpl5 report --paper --sensitivity --fit"):
        "takes minutes with sanitizers; system/paper_fit and system/report run both parts",
    ("tests/isa/conformance/README.md", "python3 tests/isa/conformance/generate.py --record"):
        "writes a file of the repository",
    ("tests/fuzz/README.md", "tests/fuzz.sh 10"): FUZZ,
    ("tests/fuzz/README.md", "tests/fuzz.sh 0.5 volume dicom"): FUZZ,
    ("tests/fuzz/README.md", "tests/fuzz.sh --report 0.33"): FUZZ,
    ("tests/fuzz/README.md", "tests/fuzz.sh --seed 1 0.33"): FUZZ,
    (CLUSTER, "host/setup.sh cluster"): "installs packages as root, from the network",
    (CLUSTER, "sudo python3 tests/cluster/cluster.py"): ROOT,
    (CLUSTER, "sudo python3 tests/cluster/cluster.py --computers 8 --on n2 --user root hostname"):
        ROOT,
    (COMPUTERS, "pxpl5 run --engine ssh --computers n1,n2,n3 -c 'load knee.nii.gz; surface bone; "
                "snapshot bone.png'"): SEVERAL,
    (COMPUTERS, "pxpl5 render knee.nii.gz -o bone.png --engine slurm"): SEVERAL,
    (COMPUTERS, "sbatch --nodes=3 --time=2:00:00 host/slurm-session.sbatch knee.nii.gz"): SEVERAL,
    (COMPUTERS, "pxpl5 serve knee.nii.gz --engine mpirun --computers n1:8,n2:16"): SEVERAL,
    (COMPUTERS, "pxpl5 serve knee.nii.gz --engine wait --set wait=2"): SEVERAL,
    (COMPUTERS, "pxpl5 serve --engine wait --set wait=2 --listen 0.0.0.0:5755 --key-file "
                "session.key"): SEVERAL,
    (COMPUTERS, "pxpl5 join tcp://n1:5755 --key-file session.key --wait 600 --again"): SEVERAL,
    (COMPUTERS, "pxpl5 run --engine slurm -"): SEVERAL,
    (COMPUTERS, "sbatch -N2 --wrap 'srun pxpl5 join tcp://n1:40001 --key-file .../join.key'"):
        SEVERAL,
    (SERVE, "pxpl5 serve knee.nii.gz --engine slurm --nodes 3 --time-limit 90 "
            "--sbatch-option=--partition=gpu"): "needs Slurm; cluster/jobs submits such jobs",
    (SERVE, "pxpl5 serve knee.nii.gz --bind 0.0.0.0 --insecure --allow-host ondemand.example.edu"):
        "serves until Ctrl-C; browser/portal opens the page behind a portal",
    (SERVE, "pxpl5 serve knee.nii.gz --sessions 30 --port 8000 --bind 0.0.0.0 --insecure"):
        "serves until Ctrl-C; system/class serves classes",
    (SERVE, "pxpl5 serves a class: 30 sessions at the same time, each with a machine of its own"):
        "is printed by the command above it",
    (SESSIONS, "pxpl5 sessions show latest"): RUNNING,
    (SESSIONS, "pxpl5 sessions end 4711"): RUNNING,
    (KUBERNETES, "pxpl5 key | kubectl create secret generic pxpl5-key --from-file=key=/dev/stdin"):
        PODS,
    (KUBERNETES, "kubectl apply -f host/kubernetes/session.yaml"): PODS,
    (KUBERNETES, "kubectl get pods -l app=pxpl5"): PODS,
    (KUBERNETES, "kubectl logs -f job/pxpl5-host"): PODS,
    (KUBERNETES, "kubectl port-forward job/pxpl5-host 8080"): PODS,
    (KUBERNETES, "kubectl delete -f host/kubernetes/session.yaml"): PODS,
    (KUBERNETES, "kubectl delete secret pxpl5-key"): PODS,
    (BENCH, "ninja -C build/release"): "builds the release preset",
    (BENCH, "../../build/release/tests/stage_bench --benchmark_min_time=0.1"): MINUTES,
    (BENCH, "python3 machine.py ../../build/release/bin/pxpl5 --check"): MINUTES,
    (BENCH, "python3 machine.py ../../build/release/bin/pxpl5 --only all --check"): MINUTES,
    (BENCH, "python3 machine.py ../../build/release/bin/pxpl5 --topology paper-1993,one-of-each "
            "--size 512x512 --only loads,memory,start"): MINUTES,
    (BENCH, "python3 compare.py ../../build/release/bin/pxpl5 --topology default,paper-1993 --big "
            "--json figures.json"): LONG,
    (BENCH, "python3 scaling.py ../../build/release/bin/pxpl5 --long"): LONG,
    (BENCH, "python3 stereo.py ../../build/release/bin/pxpl5 --check"): MINUTES,
    (BENCH, "PXPL5_BIN_DIR=$PWD/../../build/release/bin PXPL5_SHOTS_DIR=/tmp "
            "PXPL5_NODE_MODULES=$PWD/../../build/release/browser/node_modules "
            "../browser/run_test.sh ./viewer.js --volume ../../../shared/data/ct/torso_3mm.nii.gz "
            "--load resample=512x512x275 --surface 'bone iso=150' --surface 'skin iso=-300'"):
        MINUTES,
    (BENCH, "apt-get install python3-vtk9 xvfb xauth libgl1-mesa-dri libegl-dev libgl-dev"):
        "installs packages as root, from the network",
}
PROGRAM = re.compile(r"(?:[$>] *)?(?:sudo )?(?:pxpl5[\w-]*|python3?|bash|sh|cmake|ctest|ninja|make|"
                     r"npm|npx|node|apt-get|apt|pip3?|git|gdb|cd|export|curl|ssh|\.{0,2}/?"
                     r"(?:[\w.-]+/)+[\w.-]+\.sh)(?: |$)")
INDENTED = re.compile(r"(?<=\n\n)(?:    .*\n)+")
COMMENT = re.compile(r"\s+# .*")


def all_pages() -> list:
    """The Markdown pages below ROOT, but for what is built."""
    hidden = ("build", "run", "node_modules")
    return sorted(path for path in pages.ROOT.rglob("*.md")
                  if not any(part in hidden or part.startswith(".")
                             for part in path.relative_to(pages.ROOT).parts))


def shell_blocks(text: str) -> list:
    """The commands of each block that is fenced as `sh`, without comments."""
    return [[COMMENT.sub("", command) for command in pages.commands_of(block)]
            for language, block in pages.FENCED.findall(text) if language == "sh"]


def unmarked_commands(text: str) -> list:
    """Commands of blocks that are not fenced as `sh`."""
    blocks = [block for language, block in pages.FENCED.findall(text) if language != "sh"]
    blocks += INDENTED.findall(pages.FENCED.sub("", text))
    return [COMMENT.sub("", command) for block in blocks for command in pages.commands_of(block)
            if PROGRAM.match(command)]


class Pages(unittest.TestCase):
    def folder_for(self, text: str) -> pathlib.Path:
        """A folder that looks like the top of the repository, with the files that pages name."""
        folder = pathlib.Path(tempfile.mkdtemp(prefix="pxpl5-pages-"))
        self.addCleanup(shutil.rmtree, folder)
        for entry in pages.ROOT.iterdir():
            if not entry.name.startswith(".") and entry.name not in ("build", "run"):
                (folder / entry.name).symlink_to(entry)
        pages.write_nrrd(folder / "scan.nrrd", 24, 8)
        for language, block in pages.FENCED.findall(text):
            if language == "pxasm" and (name := re.match(r"; (\w+\.pxasm):", block)):
                (folder / name[1]).write_text(block, encoding="utf-8")
        return folder

    def failures_of(self, page: str, text: str) -> list:
        """Runs what is not excused. Returns a text per block that fails."""
        folder, failures = self.folder_for(text), []
        for block in shell_blocks(text):
            wanted = [command for command in block if (page, command) not in EXCUSED]
            done = pages.paste("\n".join(wanted), folder, BIN)
            if done.returncode != 0:
                failures.append(f"{page}: exit code {done.returncode}:\n" + "\n".join(wanted) +
                                f"\n{done.stdout}\n{done.stderr}")
        return failures

    def test_every_block_runs(self):
        for path in all_pages():
            page = path.relative_to(pages.ROOT).as_posix()
            if page != README:
                with self.subTest(page):
                    self.assertEqual(self.failures_of(page, path.read_text(encoding="utf-8")), [])

    def test_every_command_is_run_or_excused(self):
        known = set()
        for path in all_pages():
            page, text = path.relative_to(pages.ROOT).as_posix(), path.read_text(encoding="utf-8")
            unmarked = {(page, command) for command in unmarked_commands(text)}
            self.assertEqual(unmarked - EXCUSED.keys(), set(), "fence the block as sh")
            known |= unmarked | {(page, command) for block in shell_blocks(text)
                                 for command in block}
        self.assertEqual(EXCUSED.keys() - known, set(), "excused, but on no page")
        self.assertTrue(all(len(reason) > 10 for reason in EXCUSED.values()))

    def test_a_planted_block_is_found(self):
        for block in ("```\n$ pxpl5 info x.nrrd\n```\n", "```console\npxpl5 run\n```\n",
                      "Text:\n\n    python3 tests/bench/gone.py\n\n",
                      "```bash\ntests/run.sh\n```\n"):
            self.assertEqual(len(unmarked_commands("# x\n\n" + block)), 1, block)
        for block in ("```\nhost --Go--> child\n```\n", "Text:\n\n    a    b   c\n",
                      "```sh\npxpl5 run  # words\n```\n"):
            self.assertEqual(unmarked_commands("# x\n\n" + block), [], block)
        self.assertEqual(shell_blocks("```sh\npxpl5 a \\\n    b  # c\n\n# d\ne\n```\n"),
                         [["pxpl5 a b", "e"]])
        self.assertEqual(self.failures_of("x.md", "```sh\npxpl5 info scan.nrrd\n```\n"), [])
        for planted in ("pxpl5 info gone.nrrd", "pxpl5 rendre scan.nrrd", "false | true", "gone"):
            failures = self.failures_of("x.md", f"```sh\n{planted}\n```\n")
            self.assertEqual(len(failures), 1, planted)


if __name__ == "__main__":
    if BIN is None:
        sys.exit(__doc__)
    unittest.main()
