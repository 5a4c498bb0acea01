#!/usr/bin/env bash
# Print the newest Python from 3.12 on that is found (on PATH, or of pyenv) and can make virtual
# environments; nothing if there is none.
set -euo pipefail

{
    compgen -c python3 | sort -u | while read -r name; do
        [[ ! $name =~ ^python3(\.[0-9]+)?$ ]] || type -P "$name" || true
    done
    compgen -G "${PYENV_ROOT:-$HOME/.pyenv}/versions/3.*/bin/python3" || true
} | while read -r program; do
    "$program" -c 'import ensurepip, sys, venv
if sys.version_info >= (3, 12): print(*sys.version_info[:2], sys.executable)' 2>/dev/null || true
done | sort -k1,1n -k2,2n | tail -n 1 | cut -d ' ' -f 3-
