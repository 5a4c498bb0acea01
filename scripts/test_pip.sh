#!/usr/bin/env bash
# Test the package as pip installs it where there is no DOLFINx: nothing from apt, DOLFINx from PyPI.
set -euo pipefail

usage() {
    cat <<EOF
scripts/test_pip.sh [OPTION]... [-- COMMAND...]

Makes a virtual environment with the newest Python from 3.12 on that is found (on PATH, or of
pyenv), installs this checkout with [solver,mesh,plot,vtkhdf,dev], and runs the whole suite on one rank and
demos with their pictures, one of them on two ranks. The environment is kept for a week.

  -- COMMAND...  run this instead of the tests; the environment's programs are first on PATH
  --fresh        make the environment anew
  --subset       only the tests of scripts/test_subset.sh, without slow ones
Exit code 3: not tested, because there is no such Python or no network.
EOF
}

cd -P "$(dirname "$0")/.."
checkout=$PWD
cache=${XDG_CACHE_HOME:-$HOME/.cache}/turbine_fenicsx/pip
venv=$cache/venv
log=$cache/pip.log
command=()
subset=
while [ $# -gt 0 ]; do
    case $1 in
    -h | --help) usage && exit ;;
    --fresh) rm -rf "$venv" ;;
    --subset) subset=yes ;;
    --) shift && command=("$@") && break ;;
    *) usage >&2 && exit 2 ;;
    esac
    shift
done

logged() {
    "$@" >>"$log" 2>&1 || {
        if grep -qE 'Temporary failure|NewConnectionError|NameResolutionError|timed out' "$log"; then
            echo "== pip: not tested, no network (log: $log)"
            exit 3
        fi
        tail -n 20 "$log" >&2
        echo "test_pip: error: $* (log: $log)" >&2
        exit 1
    }
}

python=$(scripts/newest_python.sh)
if [ -z "$python" ]; then
    echo "== pip: not tested, there is no Python 3.12 or newer here"
    exit 3
fi
mkdir -p "$cache"
exec 9>"$cache/lock"
flock 9
: >"$log"
key="$python $(cksum <pyproject.toml)"
find "$cache" -maxdepth 1 -name stamp -mtime +6 -delete
if [ "$(cat "$cache/stamp" 2>/dev/null)" != "$key" ] || [ ! -x "$venv/bin/python" ]; then
    echo "== pip: a new environment in $venv from $python"
    rm -rf "$venv" "$cache/stamp"
    logged "$python" -m venv "$venv"
    logged "$venv/bin/python" -m pip install --disable-pip-version-check "$checkout[solver,mesh,plot,vtkhdf,dev]"
    logged scripts/install_turbines.sh "$venv/bin/python"
    echo "$key" >"$cache/stamp"
fi
logged "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps --force-reinstall "$checkout"

export PATH=$venv/bin:$PATH
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
unset PYTHONPATH VIRTUAL_ENV
if [ ${#command[@]} -gt 0 ]; then
    "${command[@]}"
    exit
fi

turbine-fenicsx info
echo "== pip: tests on 1 rank"
tests=(tests)
if [ -n "$subset" ]; then
    mapfile -t tests < <(scripts/test_subset.sh --list)
    tests+=(-m "not slow")
fi
# The command, which does not import the checkout's package.
pytest -n 2 --dist worksteal --progress=build/tests_pip -o console_output_style=classic "${tests[@]}"

echo "== pip: demos and pictures"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$out" # nothing of the checkout is here
for name in hybrid_stiff flexible_tower; do
    turbine-fenicsx demo $name
    turbine-fenicsx run $name.toml -o $name --quiet --set time.end=0.2 output.fields_every=0.1
    turbine-fenicsx plot $name -o plots_$name
    turbine-fenicsx render $name --times 0,0.2 --movie $name.mp4
    turbine-fenicsx report $name
done
mpiexec -n 2 turbine-fenicsx run hybrid_stiff.toml -o ranks --quiet --set time.end=0.2
