#!/usr/bin/env bash
# Run all tests on one rank, then on two. Arguments go to pytest, e.g. scripts/test.sh -k joints
set -euo pipefail
cd "$(dirname "$0")/.."

# A test that hangs for this long (one rank waits for another) is stopped, with its stack.
hang=(-o faulthandler_timeout=300 -o faulthandler_exit_on_timeout=true)
limit=3600

# The mpirun that belongs to the python of the virtual environment.
PATH=$PWD/.venv/bin:$PATH
mpirun=.venv/bin/mpirun
[ -x $mpirun ] || mpirun=$(python -c 'import os, sys; print(os.path.dirname(sys._base_executable))')/mpirun
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

[ $# -gt 0 ] || set -- tests
echo "== tests on 1 rank"
timeout --kill-after=10 $limit python -m pytest "${hang[@]}" "$@"

echo "== tests on 2 ranks"
mkdir -p build
other=build/test_rank1.log
color=no # under mpirun everything looks like a terminal
[ ! -t 1 ] || color=yes
rc=0
# shellcheck disable=SC2016 # expanded on each rank
timeout --kill-after=10 $limit "$mpirun" -n 2 bash -o pipefail -c '
    [ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = 0 ] || exec >"$0" 2>&1
    "$@" 2>&1 | cat' "$other" \
    python -m pytest --color=$color -p no:cacheprovider "${hang[@]}" "$@" || rc=$?
if [ $rc -ne 0 ]; then
    echo "== failed on 2 ranks (code $rc, 124 is out of time); rank 1 wrote in $other:"
    cat "$other"
fi
exit $rc
