#!/usr/bin/env bash
# Install what is missing and make .venv, or the folder $VENV, with turbine-fenicsx in it. Safe to
# call again; nothing else is written into the checkout.
#
# Where the python3 on PATH has a DOLFINx of its own (conda, container), that one is used.
# Debian 12, 13 or sid: DOLFINx, PETSc, MPI and gmsh come from apt, the rest from PyPI.
# Elsewhere, without root, or with DOLFINX=pypi: DOLFINx too, for Python 3.12 or newer.
set -euo pipefail
cd -P "$(dirname "$0")/.."

venv=$(realpath -m "${VENV:-.venv}")
log=$venv/setup.log
stamp=$venv/setup.stamp
constraints=$venv/constraints.txt
packages=(
    python3-dolfinx python3-dolfinx-real python3-petsc4py python3-petsc4py-real
    python3-slepc4py python3-slepc4py-real python3-mpi4py python3-numpy python3-scipy
    python3-gmsh gmsh python3-h5py python3-h5py-serial
    python3-venv python3-dev gcc g++ make # DOLFINx compiles its forms when they are first used
    openmpi-bin
    libopenblas0-pthread                   # several times faster than the default BLAS
    libegl1 libgl1 libgl1-mesa-dri libxrender1 # PyVista without a display
    ca-certificates
)

say() { echo "setup: $*"; }

fail() {
    echo "setup: error: $*" >&2
    exit 1
}

# Run a command with its output in the log only; the log of an earlier setup goes.
logged() {
    [ -n "${log_begun:-}" ] || : >"$log"
    log_begun=yes
    echo "+ $*" >>"$log"
    "$@" >>"$log" 2>&1
}

# Say what could not be had, with the end of the log unless it is just the network.
fail_logged() {
    if grep -qE 'Temporary failure|NewConnectionError|[Cc]ould not connect|timed out' "$log"; then
        fail "no network to get $1 (log: $log)."
    fi
    tail -n 15 "$log" >&2
    fail "could not get $1 (log: $log)."
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Where a python finds DOLFINx; quick, since nothing is imported.
dolfinx_of() {
    "$1" -c 'import importlib.util as u; s = u.find_spec("dolfinx"); print(s.origin if s else "")' \
        2>/dev/null || true
}

# Made at this path (programs in bin name it), for this version of python?
venv_intact() {
    grep -qsF "$venv" "$venv/pyvenv.cfg" && "$venv/bin/python" -c \
        'import os, sys, sysconfig; sys.exit(not os.path.isdir(sysconfig.get_path("purelib")))' 2>/dev/null
}

# Does the environment have the DOLFINx that it shall have?
same_dolfinx() {
    if [ "$source" = pypi ]; then
        case $(dolfinx_of "$venv/bin/python") in "$venv"/*) ;; *) return 1 ;; esac
    else
        [ "$(dolfinx_of "$venv/bin/python")" = "$(dolfinx_of "$python")" ]
    fi
}

# Debian's packages that are not installed.
missing_packages() {
    comm -23 <(printf '%s\n' "${packages[@]}" | sort) \
        <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' | sed -n 's/^installed //p' | sort)
}

# Set $python and $source, which is where its DOLFINx comes from: own, debian or pypi.
choose_python() {
    local needed=
    python=$(PATH=${PATH//"$venv/bin:"/} command -v python3 || true)
    source=debian
    case $([ -z "$python" ] || dolfinx_of "$python") in
    "") ;;
    /usr/lib/*) command -v apt-get >/dev/null || source=own ;;
    *) source=own ;;
    esac
    if [ "${DOLFINX:-}" = pypi ]; then
        source=pypi
    elif [ $source = debian ] && ! command -v apt-get >/dev/null; then
        source=pypi needed="this is not Debian, and no python3 on PATH can import dolfinx"
    elif [ $source = debian ] && [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
        needed=$(missing_packages)
        [ -z "$needed" ] || source=pypi \
            needed="you are not root and there is no sudo for these Debian packages: ${needed//$'\n'/ }"
    fi
    case $source in
    debian) python=/usr/bin/python3 ;;
    pypi)
        python=$(scripts/newest_python.sh)
        [ -n "$python" ] || fail "${needed:-DOLFINX=pypi}; DOLFINx from PyPI needs Python 3.12 or newer, which is not here either."
        [ -z "$needed" ] || say "$needed: DOLFINx from PyPI"
        ;;
    esac
}

install_debian_packages() {
    local missing
    missing=$(missing_packages)
    [ -n "$missing" ] || return 0
    say "Debian packages: ${missing//$'\n'/ }"
    logged as_root env DEBIAN_FRONTEND=noninteractive apt-get update || true
    logged apt-cache show python3-dolfinx ||
        fail_logged "python3-dolfinx from apt, which Debian 12 and newer have"
    # shellcheck disable=SC2086 # one word per package
    logged as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        -o DPkg::Lock::Timeout=300 $missing ||
        fail_logged "the Debian packages"
}

# The reference BLAS may have been chosen by hand; back to the automatic choice, OpenBLAS.
choose_blas() {
    local link
    for link in /usr/lib/*/libblas.so.3 /usr/lib/*/liblapack.so.3; do
        case $(readlink -f "$link") in
        */blas/libblas.so* | */lapack/liblapack.so*)
            say "BLAS: OpenBLAS in place of the slow reference one"
            logged as_root update-alternatives --auto \
                "$(basename "$link")-$(basename "$(dirname "$link")")" || true
            ;;
        esac
    done
}

make_venv() {
    if ! venv_intact || ! same_dolfinx; then
        say "virtual environment $venv from $python"
        find "$venv" -mindepth 1 -maxdepth 1 ! -name setup.log ! -name setup.lock -exec rm -rf {} +
        if [ "$source" = pypi ]; then
            logged "$python" -m venv "$venv" || fail_logged "a virtual environment from $python"
            return 0
        fi
        logged "$python" -m venv --system-site-packages "$venv" ||
            fail_logged "a virtual environment from $python"
        # A venv made from a venv sees only the first python: add the other's packages.
        if ! same_dolfinx; then
            "$python" -c 'import site; print(*site.getsitepackages(), sep="\n")' \
                >"$("$venv/bin/python" -c 'import site; print(site.getsitepackages()[0])')/parent.pth"
        fi
    fi
    [ "$source" != pypi ] || return 0
    "$venv/bin/python" - >>"$log" 2>&1 <<'EOF' || fail "$(tail -n 1 "$log") (with $python, log: $log)"
import dolfinx
from petsc4py import PETSc

if issubclass(PETSc.ScalarType, complex):
    raise SystemExit("PETSc is built for complex numbers, a real build is needed")
EOF
}

# pip must never replace what DOLFINx was compiled for. (Two versions of Matplotlib do not mix.)
print_constraints() {
    "$python" - <<'EOF'
from importlib.metadata import PackageNotFoundError, version

for name in """numpy scipy cffi mpi4py petsc4py slepc4py
               fenics-dolfinx fenics-basix fenics-ffcx fenics-ufl matplotlib""".split():
    try:
        print(f"{name}=={version(name)}")
    except PackageNotFoundError:
        pass
EOF
}

install_python_packages() {
    local extras=plot,dev
    [ "$source" != pypi ] || extras=solver,$extras
    # Debian's gmsh and h5py are unknown to pip, which would download a second one.
    "$venv/bin/python" -c 'import gmsh' 2>/dev/null || extras=mesh,$extras
    "$venv/bin/python" -c 'from h5py import File' 2>/dev/null || extras=vtkhdf,$extras
    say "Python packages [$extras]"
    logged "$venv/bin/python" -m pip install --disable-pip-version-check -c "$constraints" -e ".[$extras]" ||
        fail_logged "the Python packages"
    logged scripts/install_turbines.sh "$venv/bin/python" "$constraints" || fail_logged "windIO"
}

mkdir -p "$venv"
if command -v flock >/dev/null; then
    exec 9>"$venv/setup.lock"
    flock 9
fi
choose_python
if [ $source = debian ]; then
    install_debian_packages
    choose_blas
fi
pins=$(print_constraints)
key="$PWD $source $(cat pyproject.toml scripts/setup.sh - <<<"$pins" | cksum)"
if [ "$(cat "$stamp" 2>/dev/null)" != "$key" ] || [ ! -x "$venv/bin/turbine-fenicsx" ] ||
    ! venv_intact || ! same_dolfinx; then
    [ $source != own ] || say "using the DOLFINx of $python"
    rm -f "$stamp"
    make_venv
    echo "$pins" >"$constraints"
    install_python_packages
    echo "$key" >"$stamp"
fi
[ $source != pypi ] || command -v cc >/dev/null || command -v gcc >/dev/null ||
    say "a C compiler is missing, with which DOLFINx compiles its forms: install gcc"
say "ready: $venv, with $(dolfinx_of "$venv/bin/python" | sed 's,/__init__.py,,')"
