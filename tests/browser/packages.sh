#!/usr/bin/env bash
# Fetches what the browser tests need into FOLDER/node_modules, as package-lock.json pins it.
# A registry that cannot be reached is no failure: run_test.sh then says what is missing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=$1
mkdir -p "$folder"
stamp="$folder/packages.stamp"
if cmp -s "$here/package-lock.json" "$stamp"; then
    exit 0
fi
cp "$here/package.json" "$here/package-lock.json" "$folder"
if (cd "$folder" && npm ci --no-audit --no-fund); then
    cp "$here/package-lock.json" "$stamp"
else
    echo "the packages of the browser tests could not be fetched; these tests will be skipped"
fi
