#!/usr/bin/env bash
# Installs what the build needs (Debian 12), with the argument "tests" also what the tests and
# checks need. Quiet and quick when nothing is missing.
set -euo pipefail

packages=(
    g++ cmake ninja-build pkg-config git python3
    libzmq3-dev cppzmq-dev libflatbuffers-dev flatbuffers-compiler
    libglm-dev libhwy-dev libuv1-dev libedit-dev libcli11-dev libfmt-dev nlohmann-json3-dev
    libopenimageio-dev libgdcm-dev zlib1g-dev libbz2-dev libpng-dev libzstd-dev
    libseccomp-dev
    libcairo2-dev fonts-dejavu-core libmeshoptimizer-dev libassimp-dev
    libwebsockets-dev libturbojpeg0-dev node-d3 libnlopt-dev
    doctest-dev libbenchmark-dev
)
if [ "${1:-}" = tests ]; then
    packages+=(chromium python3-jsonschema clang-format clang-19 clang-tidy-19 lld-19
        libclang-rt-19-dev llvm-19 gcovr jq)
    # Node may have come from elsewhere than Debian, which then must not be asked for another.
    command -v node >/dev/null || packages+=(nodejs)
    command -v npm >/dev/null || packages+=(npm)
fi

missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
        missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
fi
log=$(mktemp)
echo "setup: installing ${#missing[@]} packages: ${missing[*]}"
if ! { "${as_root[@]}" apt-get update &&
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y --no-install-recommends \
        "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "setup: apt-get failed; the whole log is $log" >&2
    exit 69
fi
rm -f "$log"
echo "setup: done"
