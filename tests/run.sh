#!/usr/bin/env bash
# Sets up, builds and tests everything, optimized. Arguments go to ctest, e.g. tests/run.sh -L unit.
# tests/run.sh --sanitizers runs unit and system tests with address and undefined-behavior
# sanitizers instead, and prints the coverage. tests/run.sh --quick leaves out the slow tests.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

"$top/host/setup.sh" tests
cd "$top"
jobs=$(($(nproc) + 1))  # Some tests wait for the nodes of their machine.
if [ "${1:-}" = --sanitizers ]; then
    "$top/host/build.sh" dev
    find build/dev -name '*.gcda' -delete
    ctest --preset dev -L 'unit|system' -j "$jobs" --output-junit "$top/build/dev/junit.xml"
    python3 -B tests/coverage.py build/dev
else
    left_out=bench
    if [ "${1:-}" = --quick ]; then
        left_out='bench|slow'
        shift
    fi
    "$top/host/build.sh" release
    ctest --preset release -LE "$left_out" \
        -j "$jobs" --output-junit "$top/build/release/junit.xml" "$@"
fi
