#!/usr/bin/env bash
# What a cluster adds to processor time: a film in 16 slices and a study of 200 points on two nodes of one core each, which
# are processes of this machine, beside the same with --on local; and a task's share that is not work.
#   slurm.sh PROGRAM    writes out/bench/slurm.md
# The tasks' processor time is that of the tumble they call; what Slurm's daemons take is not in it.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=$PWD/out/bench/slurm
rm -rf "$work"
mkdir -p "$work/bin" "$work/real" "$work/costs"
cp "$1" "$1-draw" "$work/real/" # another build may go on meanwhile
program=$work/real/tumble
TIMEFORMAT='%U %S %R'

# The tumble that tasks call: what each took goes to a file of its own.
cp "$1-draw" "$work/bin/tumble-draw"
cat >"$work/bin/tumble" <<SCRIPT
#!/usr/bin/env bash
TIMEFORMAT='%U %S %R'
{ time "$program" "\$@" 2>&3; } 3>&2 2>"$work/costs/\$1-\$\$"
SCRIPT
chmod +x "$work/bin/tumble"

cluster=$(mktemp -d /tmp/tumble-cluster.XXXXXX)
trap 'tests/tools/cluster.sh stop "$cluster"; rm -rf "$cluster"' EXIT
CLUSTER_CORES=1 tests/tools/cluster.sh start "$cluster"
export SLURM_CONF=$cluster/slurm.conf

cost() { # command...: processor time [s] of it
    { time "$@" >/dev/null 2>&3; } 3>&2 2>"$work/cost"
    awk '{ printf "%.2f", $1 + $2 }' "$work/cost"
}
tasks() { # kind: "number processor-seconds" of the tasks since the last call
    cat "$work/costs/$1"-* 2>/dev/null | awk '{ n++; t += $1 + $2 } END { printf "%d %.2f\n", n, t }'
    rm -f "$work/costs/$1"-*
}
ratio() { awk -v local="$1" -v caller="$2" -v all="$3" 'BEGIN { printf "%.3f", (caller + all) / local }'; }

film=(run scenes/funnel.toml --quiet)
film_local=$(cost "$program" "${film[@]}" --out "$work/local")
film_caller=$(cost "$work/bin/tumble-draw" "${film[@]}" --out "$work/cluster" --on slurm --slices 16)
cmp "$work/local/funnel/funnel.mp4" "$work/cluster/funnel/funnel.mp4"
cmp "$work/local/funnel/trajectory.h5" "$work/cluster/funnel/trajectory.h5"
read -r _ simulate < <(tasks simulate)
read -r slices draw < <(tasks render)
read -r _ join < <(tasks join)

# 64 cubes fall for 4 s: five settings of 40 seeds, and 40 converged solutions.
study=(study scenes/funnel.toml --set 'lattice.cube.count=[4,4,4]' --duration 4 --knobs tolerance --seeds 40 --no-film --quiet)
study_local=$(cost "$program" "${study[@]}" --jobs 2 --out "$work/local/study")
study_caller=$(cost "$work/bin/tumble-draw" "${study[@]}" --on slurm --out "$work/cluster/study")
read -r study_count study_tasks < <(tasks study)
points=$(find "$work/cluster/study/funnel/points" -name '*.json' | wc -l)

# A slice's start: one frame, less what one frame of ten more takes; of the first records and of the last.
slice() { cost "$program" render "$work/local/funnel/trajectory.h5" --frames "$1" --out "$work/slice" --quiet; }
first_one=$(slice 0:1) first_more=$(slice 1:11) last_one=$(slice 359:360) last_more=$(slice 349:359)
start=$(cost "$program" devices)

film_ratio=$(ratio "$film_local" "$film_caller" "$(awk "BEGIN { print $simulate + $draw + $join }")")
study_ratio=$(ratio "$study_local" "$study_caller" "$study_tasks")
{
    echo "| processor time [s] | --on local | --on slurm | tasks | caller | ratio | at most |"
    echo "| --- | --- | --- | --- | --- | --- | --- |"
    echo "| funnel.toml, 360 frames of 1280x720, $slices slices | $film_local |" \
        "$(awk "BEGIN { printf \"%.2f\", $simulate + $draw + $join + $film_caller }") |" \
        "simulation $simulate, slices $draw, join $join | $film_caller | $film_ratio | 1.1 |"
    echo "| study of 200 points and 40 converged solutions ($points files), $study_count tasks | $study_local |" \
        "$(awk "BEGIN { printf \"%.2f\", $study_tasks + $study_caller }") | $study_tasks | $study_caller |" \
        "$study_ratio | 1.15 |"
    echo
    echo "A slice that begins at frame 0 takes $(awk "BEGIN { printf \"%.3f\", $first_one - $first_more / 10 }") s beside its" \
        "frames, one that begins at the last $(awk "BEGIN { printf \"%.3f\", $last_one - $last_more / 10 }") s; a frame" \
        "$(awk "BEGIN { printf \"%.3f\", ($first_more - $first_one) / 9 }") to" \
        "$(awk "BEGIN { printf \"%.3f\", ($last_more - $last_one) / 9 }") s; the program with a context of OpenGL $start s."
} | tee out/bench/slurm.md
awk "BEGIN { exit !($film_ratio <= 1.1 && $study_ratio <= 1.15) }"
