#!/usr/bin/env bash
# Runs one file of browser tests with node's test runner, or another program of node with its
# arguments; or says why it is skipped.
set -euo pipefail
skip() {
    echo "SKIPPED: $1"
    exit 0
}
command -v node >/dev/null || skip "node is not installed"
command -v chromium-headless-shell >/dev/null || command -v chromium >/dev/null ||
    skip "chromium-headless-shell is not installed"
[ -d "$PXPL5_NODE_MODULES/playwright-core" ] || skip "playwright-core is not in $PXPL5_NODE_MODULES"
case "$1" in
    *.test.js) exec node --test --test-reporter=spec "$@" ;;
    *) exec node "$@" ;;
esac
