#!/usr/bin/env python3
"""Runs clang-tidy on the product's sources: clang_tidy.py BUILD [PATH...].

BUILD is a folder that CMake configured and in which the generated headers exist, for example
build/release. PATH selects sources by the beginning of their path below the repository.

clang-tidy spends most of its time on the headers that every source includes. Therefore these are
precompiled, and many sources are parsed as one: a group is a file that includes them. Sources
whose names clash do not compile together; a syntax check finds them, and they move to a later
group. Sometimes a clash hides another one. Then clang-tidy stops, and its group is formed again.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

PRODUCT = ("isa/", "ringbus/", "gp_firmware/", "renderer_firmware/", "host/")
COMPILER, TOOL = "clang++-19", "clang-tidy-19"  # Older versions cannot parse all of C++20.
GROUP_SIZE = 64
OPTIONS = [
    "-std=c++20", "-w", "-ferror-limit=0",
    "-DHWY_COMPILE_ONLY_STATIC"]  # One vector target: the others repeat the same source.
HEADERS = "ringbus/CMakeFiles/pxpl5_ringbus.dir/cmake_pch.hxx"
Group = collections.namedtuple("Group", "path sources")


def sources_in(file):
    """The sources that a compiled file stands for: itself, or those that a unity build put in."""
    if "/Unity/unity_" not in file:
        return [file]
    return re.findall(r'^#include "(.*)"$', pathlib.Path(file).read_text(), re.MULTILINE)


def read_commands(build, root):
    """The compile command of each product source, by its path below `root`."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        for source in sources_in(entry["file"]):
            path = os.path.relpath(source, root)
            if path.startswith(PRODUCT):
                commands.setdefault(path, shlex.split(entry["command"]))
    return commands


def shared_options(commands):
    """The definitions and the include folders of all commands."""
    options = []
    for command in commands.values():
        for word, following in zip(command, command[1:]):
            if word.startswith(("-D", "-I")) and word not in options:
                options.append(word)
            if word == "-isystem" and following not in options:
                options += [word, following]
    return options


def precompile(build, folder, options):
    """Compiles the headers that most sources include. Returns the options that use the result."""
    result = folder / "headers.pch"
    subprocess.run([COMPILER, *options, "-x", "c++-header", build / HEADERS, "-o", result],
                   check=True)
    return ["-include-pch", str(result)]


class Checker:
    """Forms groups of sources that compile together and runs clang-tidy on them."""

    def __init__(self, build, root):
        self.root = root
        self.commands = read_commands(build, root)
        self.folder = build / "clang_tidy"
        self.folder.mkdir(exist_ok=True)
        self.options = OPTIONS + shared_options(self.commands)
        self.options += precompile(build, self.folder, self.options)

    def write_group(self, name, sources):
        path = self.folder / f"{name}.cpp"
        path.write_text("".join(f'#include "{self.root / source}"\n' for source in sources))
        return Group(path, sources)

    def failing(self, group):
        """The sources of `group` that do not compile beside the others, and the errors."""
        done = subprocess.run([COMPILER, *self.options, "-fsyntax-only", group.path],
                              capture_output=True, text=True, check=False)
        included = re.escape(f"In file included from {group.path}") + r":(\d+):$"
        failed, errors, line = set(), [], 0
        for text in done.stderr.splitlines():
            if match := re.match(included, text):
                line = int(match[1])
            elif re.search(r": (fatal )?error: ", text):
                failed.add(group.sources[max(line - 1, 0)])
                errors.append(text)
        return failed, errors

    def form_groups(self, run, sources, name=""):
        """Groups that compile, and the errors of the sources that do not compile alone.

        `run` is map() or that of a pool. `name` begins the names of the groups.
        """
        groups, errors, size, number = [], [], GROUP_SIZE, 0
        while sources:
            tried = [self.write_group(f"{name}{number}_{first // size}",
                                      sources[first:first + size])
                     for first in range(0, len(sources), size)]
            left = []
            for group, (failed, texts) in zip(tried, run(self.failing, tried)):
                if good := [source for source in group.sources if source not in failed]:
                    groups.append(self.write_group(group.path.stem, good))
                left += [source for source in group.sources if source in failed]
                errors += texts if len(group.sources) == 1 else []
            if size == 1:
                break
            size = 1 if len(left) == len(sources) else size
            sources, number = left, number + 1
        return groups, errors

    def findings(self, group):
        """What clang-tidy prints about each fault of a group."""
        found = self.tool_findings(group)
        is_broken = any("[clang-diagnostic-error]" in block for block in found)
        if not is_broken or len(group.sources) == 1:
            return found
        groups, errors = self.form_groups(map, group.sources, f"{group.path.stem}_")
        return errors + [block for part in groups for block in self.findings(part)]

    def tool_findings(self, group):
        """What clang-tidy prints about each fault of a group and about each error."""
        done = subprocess.run(
            [TOOL, "--quiet", f"--config-file={self.root / '.clang-tidy'}", group.path, "--",
             *self.options],
            capture_output=True, text=True, check=False)
        found = blocks(done.stdout)
        return found if found or done.returncode == 0 else [done.stdout + done.stderr]


def blocks(text):
    """Splits clang-tidy's output into findings with their notes and source lines."""
    found, current = [], []
    for line in text.splitlines():
        if re.match(r"\S+:\d+:\d+: (warning|error): ", line):
            current = []
            found.append(current)
        current.append(line)
    return ["\n".join(block) for block in found]


def main(arguments):
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 64
    start = time.monotonic()
    root = pathlib.Path(__file__).resolve().parents[2]
    checker = Checker(pathlib.Path(arguments[0]).resolve(), root)
    chosen = [path for path in checker.commands
              if path.startswith(tuple(arguments[1:]) or PRODUCT)]
    seen = {}
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        groups, errors = checker.form_groups(pool.map, sorted(chosen))
        for error in errors:
            print(error)
        print(f"clang-tidy: {len(chosen)} sources in {len(groups)} groups, "
              f"{time.monotonic() - start:.0f} s", flush=True)
        done = {pool.submit(checker.findings, group): group for group in groups}
        for count, future in enumerate(concurrent.futures.as_completed(done), 1):
            for block in future.result():
                if block not in seen:
                    print(block.replace(f"{root}/", ""))
                    seen[block] = True
            print(f"  [{count}/{len(groups)}, {time.monotonic() - start:.0f} s] "
                  f"{done[future].sources[0]} ...", flush=True)
    print(f"clang-tidy: {len(seen)} findings, {len(errors)} errors")
    return 1 if seen or errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
