#!/usr/bin/env bash
# Sets up, builds and launches the machine. Without arguments it draws the five surfaces of the
# paper and says where the pictures are; with arguments it hands them to pxpl5, e.g.
#   host/launch.sh render scan.nrrd --iso 300 -o bone.png
#   host/launch.sh --serve scan.nrrd       # the viewer in the browser
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

"$top/host/setup.sh"
"$top/host/build.sh" release pxpl5 pxpl5-gp pxpl5-renderer pxpl5-framebuffer pxpl5-io

if [ $# -eq 0 ]; then
    set -- report --paper --pictures "$top/run/pictures"
fi
if [ "$1" = --serve ]; then
    shift
    set -- serve "$@"
fi
exec "$top/build/release/bin/pxpl5" "$@"
