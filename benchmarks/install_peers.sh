#!/usr/bin/env bash
# Install the other codes that benchmarks/run.py can compare with, as far as they are to be had:
# CalculiX by apt, the rest by pip into benchmarks/.venv-peers, which nothing else uses.
# Usage: benchmarks/install_peers.sh [calculix ngsolve kratos exudyn]...   (default: all)
set -uo pipefail
cd "$(dirname "$0")"
venv=.venv-peers
[ $# -gt 0 ] || set -- calculix ngsolve kratos exudyn

pip_install() {
    [ -x $venv/bin/python ] || python3 -m venv $venv || return
    $venv/bin/python -m pip install --quiet --disable-pip-version-check --only-binary :all: "$@"
}

install() {
    case $1 in
    calculix)
        command -v ccx >/dev/null && return
        local sudo=
        [ "$(id -u)" -eq 0 ] || sudo=sudo
        $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends calculix-ccx >/dev/null
        ;;
    ngsolve) pip_install numpy ngsolve ;;
    kratos) pip_install numpy KratosMultiphysics KratosStructuralMechanicsApplication KratosLinearSolversApplication ;;
    exudyn) pip_install numpy exudyn ;;
    *) echo "unknown peer: $1" >&2 && return 2 ;;
    esac
}

missing=()
for peer in "$@"; do
    echo "== $peer"
    install "$peer" || missing+=("$peer")
done
[ ${#missing[@]} -eq 0 ] || echo "not installed: ${missing[*]}; the benchmark leaves them out"
