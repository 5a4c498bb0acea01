#!/usr/bin/env bash
# Run the tests on one rank, several at a time, and those marked "parallel" again on two ranks.
# Tests marked "slow" are left out but for --all, which comes first. Other arguments go to pytest, as in
# scripts/test.sh -k joints. An -m of yours takes the place of all this: -m "" runs every test on one and
# on two ranks. --slowest [N] lists the longest tests of the last run and runs none.
# Ctrl-C ends it at once; a test that hangs ends after five minutes, more on a busy machine
# (tests/progress.py). There is no limit for all tests together.
set -euo pipefail
cd "$(dirname "$0")/.."

# The mpirun that belongs to the python of the virtual environment.
venv=$(realpath -m "${VENV:-.venv}")
PATH=$venv/bin:$PATH
mpirun=$venv/bin/mpirun
[ -x "$mpirun" ] || mpirun=$(python -c 'import os, sys; print(os.path.dirname(sys._base_executable))')/mpirun
[ -x "$mpirun" ] || mpirun=mpirun

# Open MPI 4, 5 and 6: allow root, more ranks than cores, no binding, no talk of missing hardware.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
export OMPI_MCA_mpi_yield_when_idle=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_btl=^tcp,openib
case $("$mpirun" --version) in
*"Open MPI) 5."*)
    export PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe PRTE_MCA_hwloc_default_binding_policy=none
    ;;
*) export PRTE_MCA_mapby=:oversubscribe PRTE_MCA_bindto=none ;;
esac

# Run a command in a process group of its own, so that all it has started can be ended with it.
ranks=1
group=
run_group() {
    local rc=0
    set -m
    "$@" </dev/null &
    group=$!
    set +m
    wait "$group" || rc=$?
    kill -KILL -- "-$group" 2>/dev/null || true
    group=
    return $rc
}

# What pytest could not show itself, because it was ended before.
show_failures() {
    local failed=build/tests_$ranks/failed.txt
    [ -e "$failed" ] || return 0
    echo "== pytest was ended on $ranks rank(s); tests that had failed until then: $(grep -c ^FAILED "$failed")"
    cat "$failed"
}

# End the group: as by Ctrl-C, and what is left after five seconds for good.
stop() {
    trap '' INT TERM
    if [ -n "$group" ]; then
        kill -INT -- "-$group" 2>/dev/null || true
        set -m
        (sleep 5 && kill -KILL -- "-$group" 2>/dev/null) &
        set +m
        wait "$group" 2>/dev/null || true
        kill -KILL -- "-$group" "-$!" 2>/dev/null || true
    fi
    show_failures
    echo "== stopped by SIG$1"
    exit "$2"
}
trap 'stop INT 130' INT
trap 'stop TERM 143' TERM

if [ "${1:-}" = --slowest ]; then
    PYTHONPATH=tests/support exec python tests/progress.py "${@:2}"
fi
on_one="not slow" on_two="parallel and not slow"
if [ "${1:-}" = --all ]; then
    on_one="" on_two=parallel
    shift
fi
options=(-o console_output_style=classic)
workers=$(env -u OMP_NUM_THREADS nproc)
[ "$workers" -le 8 ] || workers=8
[ $# -gt 0 ] || set -- tests

echo "== tests on 1 rank, $workers at a time"
run_group python -m pytest -n "$workers" --dist worksteal --progress=build/tests_1 "${options[@]}" -m "$on_one" "$@" || {
    rc=$?
    show_failures
    exit $rc
}

ranks=2
echo "== tests on 2 ranks"
other=build/test_rank1.log
color=no # under mpirun everything looks like a terminal
[ ! -t 1 ] || color=yes
# shellcheck disable=SC2016 # expanded on each rank
run_group "$mpirun" -n 2 bash -o pipefail -c '
    [ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = 0 ] || exec >"$0" 2>&1
    "$@" 2>&1 | cat' "$other" \
    python -m pytest --color=$color -p no:cacheprovider --progress=build/tests_2 "${options[@]}" -m "$on_two" "$@" || {
    rc=$?
    show_failures
    echo "== failed on 2 ranks (code $rc); rank 1 wrote in $other:"
    cat "$other"
    exit $rc
}
