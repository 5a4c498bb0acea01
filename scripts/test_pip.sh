#!/usr/bin/env bash
# Test the package as pip installs it where there is no DOLFINx: nothing from apt, DOLFINx from PyPI.
set -euo pipefail

usage() {
    cat <<EOF
scripts/test_pip.sh [OPTION]... [-- COMMAND...]

Makes a virtual environment with the newest Python from 3.12 on that is found (on PATH, or of
pyenv), installs this checkout with [solver,mesh,plot,dev], and runs the whole suite on one rank and
a demo with its pictures on one and two ranks. The environment is kept for a week.

  -- COMMAND...  run this instead of the tests; the environment's programs are first on PATH
  --fresh        make the environment anew
Exit code 3: not tested, because there is no such Python or no network.
EOF
}

cd -P "$(dirname "$0")/.."
checkout=$PWD
cache=${XDG_CACHE_HOME:-$HOME/.cache}/turbine_fenicsx/pip
venv=$cache/venv
log=$cache/pip.log
command=()
while [ $# -gt 0 ]; do
    case $1 in
    -h | --help) usage && exit ;;
    --fresh) rm -rf "$venv" ;;
    --) shift && command=("$@") && break ;;
    *) usage >&2 && exit 2 ;;
    esac
    shift
done

# The newest python from 3.12 on that can make environments.
newest_python() {
    local program
    {
        compgen -c python3 | sort -u | while read -r program; do type -P "$program" || true; done
        compgen -G "${PYENV_ROOT:-$HOME/.pyenv}/versions/3.*/bin/python3" || true
    } | while read -r program; do
        "$program" -c 'import ensurepip, sys, venv
if sys.version_info >= (3, 12): print(*sys.version_info[:2], sys.executable)' 2>/dev/null || true
    done | sort -k1,1n -k2,2n | tail -n 1 | cut -d ' ' -f 3-
}

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

python=$(newest_python)
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
    logged "$venv/bin/python" -m pip install --disable-pip-version-check "$checkout[solver,mesh,plot,dev]"
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
# the command, which does not import the checkout's package
pytest -n 2 --dist worksteal --progress=build/tests_pip -o console_output_style=classic tests

echo "== pip: demos and pictures"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for name in hybrid_stiff flexible_tower; do
    turbine-fenicsx run demos/*/$name.toml -o "$out/$name" --quiet --set time.end=0.2 output.fields_every=0.1
    turbine-fenicsx plot "$out/$name" -o "$out/plots_$name"
    turbine-fenicsx render "$out/$name" --times 0,0.2 --movie "$out/$name.mp4"
    turbine-fenicsx report "$out/$name"
done
mpiexec -n 2 turbine-fenicsx run demos/paper/hybrid_stiff.toml -o "$out/ranks" --quiet --set time.end=0.2
