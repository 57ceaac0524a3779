#!/usr/bin/env bash
# Usage: feature_costs.sh TUMBLE_DRAW SCENE_DIR OUT_DIR
# What parts of the model cost in scenes that do not use them, in instructions a step counted by callgrind: those of
# the part's own functions, in the difference of two runs, so that loading counts for nothing. Writes features.md; exit
# code 1 if a part costs more than a branch and the call around it.
set -euo pipefail
program=$1 scenes=$2 out=$3
most=60            # instructions a step: a call, its frame and a test
steps=200
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# part | scene without it | functions
parts='joints|sliding_block|sim::JointSolver::|sim::make_joint
shock propagation|tower|contact_levels|shock_propagation
stopping at impacts|tower|time_of_impact|is_impact|stop_at_impact|plan_until_impact
hulls, cylinders, capsules (libccd)|tower|convex_contacts|convex_separation|convex_plane|find_separation|penetration_direction|ccd|support_
compounds|rolling_ball|Compound
gyroscopic term|rolling_ball|symmetric_rotation|asymmetric_rotation|angular_momentum
boxes against boxes|bouncing_ball|box_box|find_box_contacts|axes_kernel|PlacedBoxRow|update_axes
contacts and collisions|free_rotation|contact_blocks|CollisionSolver::|sim::block_|solve_block|find_contacts'

# Instructions in all functions, and in those that match, of a run of N steps.
count() {
    local scene=$1 n=$2 pattern=$3 file="$work/$1.$2"
    if [ ! -e "$file.txt" ]; then
        valgrind --tool=callgrind --callgrind-out-file="$file.out" "$program" simulate "$scenes/$scene.toml" \
            --threads 1 --quiet --out "$work/out" --set output.fps=1000 --duration "$(awk "BEGIN{print $n / 1000}")" \
            --time-step 1/1000 --record-every 1000000 >/dev/null 2>&1
        callgrind_annotate --threshold=100 --show-percs=no "$file.out" >"$file.txt" 2>/dev/null
    fi
    awk -v pattern="$pattern" '
        /PROGRAM TOTALS/ { gsub(",", "", $1); total = $1 }
        /^ *[0-9,]+  / && !/PROGRAM TOTALS/ { if ($0 ~ pattern) { gsub(",", "", $1); sum += $1 } }
        END { printf "%d %d\n", total, sum }' "$file.txt"
}

status=0
{
    echo '| part of the model | scene without it | instructions a step | of them in the part |'
    echo '| --- | --- | --- | --- |'
    while IFS='|' read -r name scene pattern; do
        read -r total_1 part_1 < <(count "$scene" $steps "$pattern")
        read -r total_2 part_2 < <(count "$scene" $((2 * steps)) "$pattern")
        part=$(((part_2 - part_1) / steps))
        note=
        if [ "$part" -gt $most ]; then
            note=" **more than $most**"
            status=1
        fi
        echo "| $name | $scene | $(((total_2 - total_1) / steps)) | $part$note |"
    done <<<"$parts"
} >"$out/features.md"
cat "$out/features.md"
exit $status
