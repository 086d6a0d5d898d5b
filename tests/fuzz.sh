#!/usr/bin/env bash
# Builds the fuzz targets and runs each for some minutes, as many at a time as there are cores:
# fuzz.sh [--seed N] [--report] MINUTES [TARGET...]. Prints a table. Inputs that fail go to
# tests/fuzz/regressions. With a seed, two runs try much the same inputs. With --report, an input
# that fails is printed, and only a target that does not run at all is an error.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
seed=0  # 0: another one each time.
report=
while [[ ${1:-} == --* ]]; do
    case $1 in
        --seed) seed=${2:-} && shift $(($# > 1 ? 2 : 1)) ;;
        --report) report=yes && shift ;;
        *) break ;;
    esac
done
if ! [[ $seed =~ ^[0-9]+$ ]] || [ $# -eq 0 ] || ! [[ $1 =~ ^[0-9]+(\.[0-9]+)?$ ]]; then
    echo "usage: fuzz.sh [--seed N] [--report] MINUTES [TARGET...]" >&2
    echo "MINUTES may be a fraction, for example 0.5" >&2
    exit 64
fi
seconds=$(awk "BEGIN { s = int($1 * 60 + 0.5); print (s > 0 ? s : 1) }")
shift
cd "$top"
host/build.sh dev pxpl5_fuzz_targets

folder=$top/build/dev/fuzz
targets=("$@")
[ $# -gt 0 ] || mapfile -t targets <"$folder/targets"
for target in "${targets[@]}"; do
    if ! grep -qx "$target" "$folder/targets"; then
        echo "fuzz: no target '$target'; the targets are: $(tr '\n' ' ' <"$folder/targets")" >&2
        exit 64
    fi
done

# GDCM reserves, and clears, what a length asks for; pxpl5-io has a limit of its own.
limits_of() {
    local limit_mib=512 limit_s=25
    [ "$1" != dicom ] || limit_mib=4096 limit_s=100
    echo "-timeout=$limit_s -rss_limit_mb=$((2 * limit_mib)) -malloc_limit_mb=$limit_mib"
}
# One target: new inputs stay in build/dev, for the next run.
run_target() {
    local folder=$1 top=$2 seconds=$3 seed=$4 target=$5 options
    read -ra options <<<"$(limits_of "$target")"
    local found=$folder/found/$target regressions=$top/tests/fuzz/regressions/$target
    local dictionary=$top/tests/fuzz/$target.dict
    mkdir -p "$found" "$regressions"
    [ ! -f "$dictionary" ] || options+=("-dict=$dictionary")
    local TIMEFORMAT='%U %S'
    {
        time "$folder/fuzz_$target" "$found" "$top/tests/fuzz/corpus/$target" "$regressions" \
            "-max_total_time=$seconds" "-seed=$seed" -print_final_stats=1 -close_fd_mask=1 \
            "-artifact_prefix=$regressions/" "${options[@]}" >"$folder/$target.log" 2>&1 ||
            touch "$folder/$target.failed"
    } 2>"$folder/$target.seconds"
    rmdir --ignore-fail-on-non-empty "$regressions"
}
# The corpus and all inputs that failed once must pass, also with --report.
replay_target() {
    local folder=$1 top=$2 target=$3 inputs=() inputs_of limits
    read -ra limits <<<"$(limits_of "$target")"
    for inputs_of in corpus regressions; do
        inputs_of=$top/tests/fuzz/$inputs_of/$target
        [ ! -d "$inputs_of" ] || inputs+=("$inputs_of")
    done
    "$folder/fuzz_$target" -runs=0 "${limits[@]}" \
        -close_fd_mask=1 "${inputs[@]}" >"$folder/$target.replay.log" 2>&1 && return
    echo "fuzz: $target fails for an input that is known:"
    tail -n 30 "$folder/$target.replay.log"
    return 1
}
export -f limits_of run_target replay_target
export ASAN_OPTIONS=detect_leaks=1
rm -f "$folder"/*.failed
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} \
    bash -c 'replay_target "$@"' _ "$folder" "$top" {}
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} \
    bash -c 'run_target "$@"' _ "$folder" "$top" "$seconds" "$seed" {}

# The table.
failed=0
printf '%-16s %12s %9s %8s %8s  %s\n' target executions "per s" "CPU min" edges result
for target in "${targets[@]}"; do
    log=$folder/$target.log
    result=ok
    if [ -e "$folder/$target.failed" ]; then
        [ -n "$report" ] && grep -aq 'Test unit written to ' "$log" || failed=1
        result=$(grep -ao 'Test unit written to .*' "$log" | tail -n 1 | sed "s|.* $top/||" || true)
        result="FAILED: ${result:-see $log}"
    fi
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$log")
    edges=$(grep -ao 'cov: [0-9]*' "$log" | tail -n 1 | cut -d' ' -f2 || true)
    minutes=$(awk '{ printf "%.1f", ($1 + $2) / 60 }' "$folder/$target.seconds")
    printf '%-16s %12s %9s %8s %8s  %s\n' "$target" "${executions:--}" "${rate:--}" "$minutes" \
        "${edges:--}" "$result"
done
cd "$folder"
awk '{ sum += $1 + $2 } END { printf "processor time in all: %.1f min\n", sum / 60 }' \
    "${targets[@]/%/.seconds}"
for target in "${targets[@]}"; do
    [ -e "$folder/$target.failed" ] || continue
    log=$folder/$target.log
    grep -aE '^broken promise|ERROR: |runtime error|#[0-9] ' "$log" | head -n 25 || true
    # For whoever has the output alone.
    input=$(sed -n 's/^.*Test unit written to //p' "$log" | tail -n 1)
    [ ! -f "$input" ] || echo "$target: the input in base64: $(base64 -w 0 "$input" | head -c 8000)"
done
exit $failed
