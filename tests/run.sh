#!/usr/bin/env bash
# Sets up, builds and tests everything: optimised, then with address and undefined-behaviour
# sanitizers and warnings as errors. With arguments it runs the optimised build only and hands them
# to ctest, e.g. tests/run.sh -L unit
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

"$top/host/setup.sh"
cd "$top"
"$top/host/build.sh" release
ctest --preset release -LE bench --output-junit "$top/build/release/junit.xml" "$@"
if [ $# -eq 0 ]; then
    "$top/host/build.sh" dev
    ctest --preset dev -L 'unit|system' --output-junit "$top/build/dev/junit.xml"
fi
