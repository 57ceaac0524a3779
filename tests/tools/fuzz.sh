#!/usr/bin/env bash
# Usage: fuzz.sh PROGRAM NAME SECONDS [OPTION...]
# Runs a fuzzer from tests/fuzz/corpus/NAME and what earlier runs found (found.tar.gz there). Inputs that lead somewhere
# new go to out/fuzz/NAME/, those that fail to out/fuzz/NAME-*.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=$1 name=$2 seconds=$3 out=out/fuzz
shift 3
mkdir -p "$out/$name"
tar -xzf tests/fuzz/corpus/found.tar.gz -C "$out" "$name"
words=()
if [ "$name" = scene ]; then
    # What is quoted on the page of keys, which is made from the reader's own table.
    words=("-dict=$out/scene.dict")
    grep -oE '`[a-z_0-9]+`|"[a-z_]+"' scenes/README.md | tr -d '`"' | sort -u | sed 's/.*/"&"/' >"$out/scene.dict"
fi
exec "$program" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -detect_leaks=0 -print_final_stats=1 \
    -artifact_prefix="$out/$name-" "${words[@]}" "$@" "$out/$name" "tests/fuzz/corpus/$name"
