#!/usr/bin/env bash
# Installs what the build needs (Debian 12). Quiet and quick when nothing is missing. Arguments:
#   tests     also what the tests and checks need
#   cluster   also the daemons that tests/cluster starts in namespaces. They are installed, but
#             neither started nor enabled on this machine. As root where systemd does not run, in
#             a container, "tests" includes them.
set -euo pipefail

packages=(
    g++ cmake ninja-build pkg-config git python3
    libzmq3-dev cppzmq-dev libflatbuffers-dev flatbuffers-compiler
    libglm-dev libhwy-dev libuv1-dev libedit-dev libcli11-dev libfmt-dev nlohmann-json3-dev
    libopenimageio-dev libgdcm-dev zlib1g-dev libbz2-dev libpng-dev libzstd-dev
    libseccomp-dev libexpat1-dev libblosc-dev libarchive-dev libzip-dev
    libcairo2-dev fonts-dejavu-core libmeshoptimizer-dev libassimp-dev
    libwebsockets-dev libturbojpeg0-dev libvpx-dev libavformat-dev esbuild libnlopt-dev
    doctest-dev libbenchmark-dev jq
)
has_tests=false has_cluster=false
for argument in "$@"; do
    case $argument in
    tests) has_tests=true ;;
    cluster) has_cluster=true ;;
    *)
        echo "setup: no set of packages is called $argument; there are tests and cluster" >&2
        exit 64
        ;;
    esac
done
if $has_tests; then
    packages+=(chromium-headless-shell libwebm-dev python3-jsonschema python3-yaml clang-format
        clang-19 clang-tidy-19 lld-19 libclang-rt-19-dev llvm-19 gcovr)
    # Node may have come from elsewhere than Debian, which then must not be asked for another.
    command -v node >/dev/null || packages+=(nodejs)
    command -v npm >/dev/null || packages+=(npm)
    if [ "$(id -u)" -eq 0 ] && [ ! -d /run/systemd/system ]; then
        has_cluster=true
    fi
fi
declare -A services=()  # By package.
if $has_cluster; then
    services=([munge]=munge [openssh-server]=ssh [slurmctld]=slurmctld [slurmd]=slurmd)
    packages+=("${!services[@]}" slurm-client openssh-client openmpi-bin iproute2 util-linux)
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
    if ! command -v sudo >/dev/null; then
        echo "setup: ${#missing[@]} packages are missing, and there is no sudo to install them." \
            "As root: apt-get install ${missing[*]}" >&2
        exit 69
    fi
fi
policy=/usr/sbin/policy-rc.d  # Packages ask it whether they may start their services.
if $has_cluster && [ ! -e $policy ]; then
    trap '"${as_root[@]}" rm -f $policy' EXIT
    printf '#!/bin/sh\nexit 101\n' | "${as_root[@]}" tee $policy >/dev/null
    "${as_root[@]}" chmod 755 $policy
fi
log=$(mktemp)
echo "setup: installing ${#missing[@]} packages: ${missing[*]}"
# A new machine may be installing its own updates: both wait for that to end.
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600)
if ! { "${apt[@]}" update &&
    "${apt[@]}" install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "setup: apt-get failed; the whole log is $log" >&2
    exit 69
fi
rm -f "$log"
for package in "${missing[@]}"; do
    if [ -n "${services[$package]:-}" ]; then
        "${as_root[@]}" update-rc.d "${services[$package]}" disable
    fi
done
echo "setup: done"
