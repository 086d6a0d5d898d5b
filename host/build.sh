#!/usr/bin/env bash
# Configures and builds a preset: build.sh PRESET [TARGET...]. Prints progress.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
preset=$1
shift

cd "$top"
echo "build: configuring the preset $preset"
log=$(mktemp)
if ! cmake --preset "$preset" >"$log" 2>&1; then
    cat "$log" >&2
    echo "build: cmake could not configure the preset '$preset'" >&2
    exit 1
fi
rm -f "$log"
targets=()
if [ $# -gt 0 ]; then
    targets=(--target "$@")
fi
echo "build: preset $preset"
NINJA_STATUS='  [%f/%t, %e s] ' cmake --build --preset "$preset" "${targets[@]}"
