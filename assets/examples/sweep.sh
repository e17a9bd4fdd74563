#!/usr/bin/env bash
# How strong the weaker of two foci, one above the other, can be, against their distance: a sweep by GNU parallel.
#
#   assets/examples/sweep.sh > sweep.csv
#
# Every job is one `sonoglyph batch` that answers eight scenes. On more machines: --sshlogin (see man parallel).
set -euo pipefail
sonoglyph=${SONOGLYPH:-sonoglyph}

# A scene per line. The last one is no scene: its lower focus lies in the array.
scenes() {
    seq 5 5 200 | awk '{
        half = $1 / 2000
        printf "{\"id\": %d, \"target\": [{\"at\": [0, 0, %.4f]}, {\"at\": [0, 0, %.4f]}]}\n", $1, 0.1 - half, 0.1 + half
    }'
}

echo '"distance_mm","weaker_pa","error"'
scenes |
    parallel --pipe --keep-order --max-replace-args 8 "$sonoglyph" batch --no-limits --threads 1 |
    jq --raw-output '[.id, .quality.min_pressure, .error] | @csv'
