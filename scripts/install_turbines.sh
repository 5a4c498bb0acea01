#!/usr/bin/env bash
# install_turbines.sh PYTHON [CONSTRAINTS]: install the packages whose turbines the tests read, without
# what these packages need themselves: a numpy that does not suit Debian's DOLFINx, among others.
# windIO has two turbines; rosco has blades and polars, and no wheel for the newest Python.
# With CONSTRAINTS also what windIO's converter of older files imports.
set -euo pipefail
pip=("$1" -m pip install --disable-pip-version-check --no-deps)
windio=$(sed -n 's/^windio = \["\([^"]*\)"\].*/\1/p' "$(dirname "$0")/../pyproject.toml")
"${pip[@]}" "$windio"
"${pip[@]}" --only-binary rosco 'rosco>=2.10.6,<2.11' ||
    echo "no wheel of rosco for $1: tests that read its blades are skipped"
[ -z "${2:-}" ] || "$1" -m pip install --disable-pip-version-check --only-binary :all: -c "$2" \
    netCDF4 ruamel.yaml xarray ||
    echo "no wheels of netCDF4 or xarray for $1: windIO's converter does not run"
