#!/usr/bin/env bash
# What shows in some minutes whether all holds with another DOLFINx: a demo with its pictures, and the
# test files that call all of _compat.py, PETSc, SLEPc, gmsh, PyVista and Matplotlib; what is parallel
# of them on two ranks too. --list prints the test files.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s globstar failglob # a name that no file has is an error
tests=(
    tests/unit/analysis/test_{modes,statics_of_beams,turning}.py
    tests/unit/{forces/test_surface_loads,foundation/test_compiled_forms}.py
    tests/unit/linear_solvers/test_{factor,frames,frozen,linear}.py
    tests/unit/materials/test_{cell_fields,laminate}.py
    tests/unit/meshing/test_{gmsh_process,meshing,users_meshes}.py
    tests/unit/postprocessing/test_{pictures,plots,report}.py
    tests/unit/records/test_{vtkhdf,xdmf}.py
    tests/unit/reduction/test_beam_basis.py
    tests/unit/sections/test_section.py
    tests/unit/simulation/{test_checkpoint,observers/test_{fields,gauges,openfast,points}}.py
    tests/unit/system/test_{body_fields,cell_numbers,coupling,linear_form,skin,system}.py
    tests/unit/time_stepping/test_{newton,newton_failures}.py
    tests/unit/turbine/{case/test_case,blades/test_hollow_blades,components/test_turbine_{gauges,tower}}.py
    tests/unit/windio/test_windio_blade.py
    tests/cli/test_{command_line,restart}.py
    tests/verification/test_{beams,root_loads}.py
)
if [ "${1:-}" = --list ]; then printf '%s\n' "${tests[@]}" && exit; fi
PATH=$PWD/.venv/bin:$PATH

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
echo "== demo and pictures"
turbine-fenicsx run demos/paper/hybrid_stiff.toml -o "$out/demo" --quiet --set time.end=0.5 output.fields_every=0.1
turbine-fenicsx plot "$out/demo"
turbine-fenicsx render "$out/demo" --times 0,0.5 --movie "$out/demo.mp4"
turbine-fenicsx report "$out/demo"

scripts/test.sh "${tests[@]}"
