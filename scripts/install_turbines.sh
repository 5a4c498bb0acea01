#!/usr/bin/env bash
# install_turbines.sh PYTHON: install the packages whose turbines the tests read, without what these
# packages need themselves: netCDF4, xarray, and a numpy that does not suit Debian's DOLFINx.
# windIO has two turbines; rosco has blades and polars, and no wheel for the newest Python.
set -euo pipefail
pip=("$1" -m pip install --disable-pip-version-check --no-deps)
windio=$(sed -n 's/^windio = \["\([^"]*\)"\].*/\1/p' "$(dirname "$0")/../pyproject.toml")
"${pip[@]}" "$windio"
"${pip[@]}" --only-binary rosco 'rosco>=2.10.6,<2.11' ||
    echo "no wheel of rosco for $1: tests that read its blades are skipped"
