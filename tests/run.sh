#!/usr/bin/env bash
# Sets up, builds and tests everything. Arguments go to ctest, e.g. tests/run.sh -L unit
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

"$top/host/setup.sh"
"$top/host/build.sh" release
cd "$top"
ctest --preset release -LE bench --output-junit "$top/build/release/junit.xml" "$@"
