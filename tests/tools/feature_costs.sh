#!/usr/bin/env bash
# Usage: feature_costs.sh STEPS SCENE_DIR OUT_DIR
# What parts of the model cost in scenes that do not use them, in instructions a step counted by callgrind: those of
# the source lines of the part's own functions, inlined or not, in the difference of two runs, so that loading counts for
# nothing. STEPS: tests/tools/steps.cpp, optimized, with lines. Writes features.md; exit code 1 if a part costs more than
# a branch and the call around it.
set -euo pipefail
program=$1 scenes=$2 out=$3
steps=100
tools=$(dirname "$0")
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
awk -f "$tools/function_lines.awk" "$tools"/../../sim/*/*.cpp "$tools"/../../sim/*/*.h >"$work/functions"

# most instructions a step (60: some calls and their tests; 400 and 1100: stages that find nothing to do, their empty loops) | part |
# scene without it, and what is set in it | regular expressions, each without a space: FILE:LINE and SIGNATURE of its functions
parts='60|friction|bouncing_ball|friction
60|friction, in batches|tower lattice.box.count=[9,9,1] lattice.box.spacing=[2,2,2] body.floor.friction=0 lattice.box.body.friction=0|block/friction
60|energy of collisions|tower|keep_energy energy_owed energy_by
60|joints|sliding_block|solve/joint drive_work energy_in_springs
60|springs and motors|pendulum_chain|drive_position target_drive keep_limits spring_energy find_responses
60|kinematic bodies|tower|model/motion model/key_curve kinematic_velocity work_by work_of_pass
60|search for impacts|tower|is_impact[(] stop_at_impact[(] plan_until_impact[(] .time_of_impact[(]
60|hulls, cylinders, capsules|tower|collide/convex collide/separating_direction collide/ccd_bridge model/polytope
60|compounds|rolling_ball|Compound
60|gyroscopic term of a ball|rolling_ball|symmetric_rotation
60|boxes against boxes|bouncing_ball|collide/box_box collide/axes_kernel collide/faces_kernel
1100|contacts, of a lone body|free_rotation|block/ solve/contact_ solve/rest collide/box_ collide/axes_ collide/faces_ collide/narrow_ collide/convex collide/separating collide/ccd_
400|collisions, of a lone body|free_rotation|solve/collision_solver'

# FILE:LINE and instructions, of a run of N steps of a scene.
count() {
    local n=$1 scene=$2 file="$work/$3.$1"
    shift 3
    [ -e "$file" ] && return
    valgrind --tool=callgrind --callgrind-out-file="$file.out" "$program" "$scenes/$scene.toml" "$n" "$@" >/dev/null 2>&1
    awk -f "$tools/callgrind_lines.awk" "$file.out" >"$file"
}

# Instructions of all lines of a file of counts, and of those whose function matches.
sum() {
    awk -F'\t' -v pattern="$1" '
        FNR == NR { signature[$1] = $2; next }
        { total += $2; if (($1 in signature) && ($1 " " signature[$1]) ~ pattern) sum += $2 }
        END { printf "%d %d\n", total, sum }' "$work/functions" "$2"
}

status=0
{
    echo '| part of the model | scene without it | instructions a step | of them in the part | at most |'
    echo '| --- | --- | --- | --- | --- |'
    while IFS='|' read -r most name scene patterns; do
        for pattern in $patterns; do
            grep -qE "$pattern" <(tr '\t' ' ' <"$work/functions") || { echo "no function is called $pattern" >&2; exit 2; }
        done
        pattern=${patterns// /|}
        read -ra words <<<"$scene"
        key=$(tr -c 'a-z0-9\n' _ <<<"$scene")
        for n in $steps $((2 * steps)); do
            count "$n" "${words[0]}" "$key" "${words[@]:1}"
        done
        read -r total_1 part_1 < <(sum "$pattern" "$work/$key.$steps")
        read -r total_2 part_2 < <(sum "$pattern" "$work/$key.$((2 * steps))")
        part=$(((part_2 - part_1) / steps))
        note=
        if [ "$part" -gt $most ]; then
            note=" **too many**"
            status=1
        fi
        echo "| $name | $scene | $(((total_2 - total_1) / steps)) | $part$note | $most |"
    done <<<"$parts"
} >"$out/features.md"
cat "$out/features.md"
exit $status
