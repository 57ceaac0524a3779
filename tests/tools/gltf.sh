#!/usr/bin/env bash
# Usage: gltf.sh TUMBLE WORK_DIR SCENE...
# What `tumble export --gltf` writes, judged by others: the Khronos validator finds no fault, and three.js in a browser shows
# half a second into the film the same body as tumble's picture at all but 0.2 % of the pixels; at its start, where glTF cannot
# move the camera as we do. Writes SCENE.png: ours, theirs, the pixels that differ. Exit code 1 if either fails.
set -euo pipefail
program=$(realpath "$1") work=$2 tools=$(realpath "$(dirname "$0")")
shift 2
mapfile -t scenes < <(realpath "$@")
mkdir -p "$work"
cd "$work"
[ -d node_modules/three ] && [ -d node_modules/gltf-validator ] ||
    npm install --silent --no-fund --no-audit gltf-validator@2.0.0-dev.3.10 three@0.187.0
status=0
for scene in "${scenes[@]}"; do
    name=$(basename "$scene" .toml)
    "$program" run "$scene" --quiet --no-video --body-ids --size 640x360 --duration 1 --fps 20 --set output.shutter=0 --out .
    "$program" export "$name" --gltf "$name.glb" | tee "$name.txt"
    frame=000010 time=0.5
    ! grep -q opening "$name.txt" || frame=000000 time=0
    node "$tools/gltf.cjs" "$name.glb" "$name/frames/frame_$frame" $time >"$name.html" || status=1
    verdict=
    for try in 1 2 3; do # on a busy machine the browser's time may be over before the page is
        chromium --headless --no-sandbox --allow-file-access-from-files --enable-unsafe-swiftshader \
            --virtual-time-budget=200000 --user-data-dir="$PWD/profile" --dump-dom "file://$PWD/$name.html" \
            >"$name.dom" 2>/dev/null
        verdict=$(sed -n 's:.*<p id="verdict">\([^<]*\).*:\1:p' "$name.dom")
        [ -z "$verdict" ] || break
    done
    sed -n 's:.*<p id="sheet">\([^<]*\).*:\1:p' "$name.dom" | base64 -d >"$name.png"
    echo "$name: ${verdict:-no picture}"
    [[ $verdict == same* ]] || status=1
done
exit $status
