#!/usr/bin/env bash
# The release build configured as where there is no OSMesa: a small film of it is that of the build with OSMesa, which is
# what build/ holds afterwards. What differs is one source and two links. Without EGL, too, nothing is configured.
set -euo pipefail
cd "$(dirname "$0")/../.."

film() { # folder
    build/tumble run tests/golden/features.toml --size 320x180 --duration 0.1 --quiet --out "$1"
}

if said=$(cmake --preset release -DTUMBLE_OSMESA=OFF -DTUMBLE_EGL=OFF 2>&1) || [[ $said != *libosmesa6-dev*libegl-dev* ]]; then
    echo "without_osmesa.sh: configured with nothing that draws, expected an error that names packages: $said" >&2
    exit 1
fi
cmake --preset release -DTUMBLE_OSMESA=OFF --log-level=WARNING
cmake --build build --target tumble
if ldd build/tumble-draw | grep -i osmesa || build/tumble devices | grep '^osmesa'; then
    echo "without_osmesa.sh: configured without OSMesa, the program draws with it" >&2
    exit 1
fi
film out/osmesa/without
cmake --preset release --log-level=WARNING
cmake --build build --target tumble
film out/osmesa/with
build/tumble compare out/osmesa/with/features out/osmesa/without/features --fail-on noise
