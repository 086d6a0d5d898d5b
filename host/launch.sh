#!/usr/bin/env bash
# Sets up, builds and launches the machine. Without arguments it draws the five surfaces of the
# paper and says where the pictures are; with arguments it hands them to pxpl5, e.g.
#   host/launch.sh render scan.nrrd --iso 300 -o bone.png
#   host/launch.sh --serve scan.nrrd       # the viewer in the browser
#   host/launch.sh --engine slurm --serve scan.nrrd    # the same on the computers of a Slurm job
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

engine=()
while [[ ${1:-} == --engine || ${1:-} == --computers ]]; do
    if [ $# -lt 2 ]; then
        echo "launch.sh: $1 needs a word, for example --engine slurm or --computers n1,n2" >&2
        exit 64
    fi
    engine+=("$1" "$2")
    shift 2
done

"$top/host/setup.sh"
"$top/host/build.sh" release pxpl5 pxpl5-gp pxpl5-renderer pxpl5-framebuffer pxpl5-io

if [ $# -eq 0 ]; then
    set -- report --paper --pictures "$top/run/pictures"
fi
if [ "$1" = --serve ]; then
    shift
    set -- serve "$@"
fi
exec "$top/build/release/bin/pxpl5" "$@" "${engine[@]}"
