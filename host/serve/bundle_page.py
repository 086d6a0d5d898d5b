#!/usr/bin/env python3
"""Bundles the page: one module and two style sheets instead of about 100 files.

usage: bundle_page.py ESBUILD PAGE OUT

Writes main.js, page.css, light.css, their source maps and index.html to OUT. index.html names
these files with a hash of their bytes (main.js?v=...), so that a browser may keep them until they
change. What main.js imports later (the texts of another language) has a file of its own, which
main.js names in the same way (de.js?v=...). Names of files stay the same, so that a running server,
which knows its files by name, finds them after a change.
"""
import hashlib
import pathlib
import re
import subprocess
import sys

ENTRIES = ("main.js", "page.css", "light.css")
# esbuild's name of a later file, "de.v.HASH.js", is as long as its address, "de.js?v=HASH". So
# columns of main.js stay where its source map has them.
LATER = re.compile(r"(\w+)\.v\.([0-9A-Z]{8})\.js")


def with_hashes(page, folder):
    """`page`, index.html's text, with the hash of each bundled file after its name."""
    for name in ENTRIES:
        digest = hashlib.sha256((folder / name).read_bytes()).hexdigest()[:16]
        page, count = re.subn(rf'(="{re.escape(name)})"', rf'\1?v={digest}"', page)
        if count != 1:
            sys.exit(f"bundle_page.py: index.html names {name} {count} times, expected once")
    return page


def name_later_files(folder):
    """Renames "de.v.HASH.js" to "de.js", which main.js then imports as "de.js?v=HASH"."""
    entry = folder / "main.js"
    text = entry.read_text(encoding="utf-8")
    for found in {match.group(): match for match in LATER.finditer(text)}.values():
        old, new = found.group(), f"{found.group(1)}.js"
        later = (folder / old).read_text(encoding="utf-8").replace(f"{old}.map", f"{new}.map")
        if other := LATER.search(later):
            sys.exit(f"bundle_page.py: {old} imports {other.group()}, but only main.js may")
        (folder / new).write_text(later, encoding="utf-8")
        (folder / old).unlink()
        (folder / f"{old}.map").replace(folder / f"{new}.map")
        text = text.replace(old, f"{new}?v={found.group(2)}")
    entry.write_text(text, encoding="utf-8")


def main(esbuild, source, out):
    source, out = pathlib.Path(source), pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    subprocess.run([esbuild, *ENTRIES, "--bundle", "--splitting", "--chunk-names=[name].v.[hash]",
                    "--minify", "--format=esm", "--target=es2022", "--sourcemap",
                    "--log-level=warning", f"--outdir={out.resolve()}"], cwd=source, check=True)
    name_later_files(out)
    page = (source / "index.html").read_text(encoding="utf-8")
    (out / "index.html").write_text(with_hashes(page, out), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
