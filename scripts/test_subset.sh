#!/usr/bin/env bash
# What shows in a quarter of the time whether all holds with another DOLFINx: a demo with its
# pictures, a test file for each part of the package, the published benchmarks; on one and two ranks.
# --list prints the test files.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s globstar failglob # a name that no file has is an error
tests=(
    tests/unit/**/test_{checkpoint,coupling,energy_momentum,flexible_body,forces,frozen,joints,linear}.py
    tests/unit/**/test_{large_strains,materials,meshing,meshing_tower,modes,openfast,pictures}.py
    tests/unit/**/test_{plots,reactions,report,statics,statics_of_beams,turning,turning_modes}.py
    tests/unit/**/test_{hollow_blades,laminate,turbine_gauges,wall_cells,windio_blade}.py
    tests/unit/**/test_{study_plan,surface_loads,turbine_channels,turbine_tower,xdmf}.py
    tests/cli/test_{command_line,demos,modes_command,restart}.py
    tests/verification/test_{published_flexible,published_hybrid,published_rigid,root_loads}.py
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
