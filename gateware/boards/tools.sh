# Functions of the boards' builds: `prepare REQUIREMENTS` installs pinned packages from PyPI into ./venv, `settings
# FAMILY OSCILLATOR_KHZ PHASE_BITS` prints PLL settings as arguments of Yosys' chparam, `quietly LOG COMMAND …` shows
# LOG's end if COMMAND fails.

boards=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rtl=$(cd "$boards/../rtl" && pwd)

prepare() {
    cmp -s "$1" venv/requirements.txt && return
    rm -rf venv
    python3 -m venv venv
    venv/bin/pip install --quiet --disable-pip-version-check --require-hashes -r "$1"
    cp "$1" venv/requirements.txt
}

settings() {
    local found
    found=$(python3 "$boards/clock.py" "$@")
    printf -- '-set OSCILLATOR_KHZ %s -set PHASE_BITS %s ' "$2" "$3"
    sed 's/\(.*\)=\(.*\)/-set \1 \2/' <<<"$found" | tr '\n' ' '
}

quietly() {
    local log=$1
    shift
    "$@" >"$log" 2>&1 || { tail -n 30 "$log" >&2; return 1; }
}
