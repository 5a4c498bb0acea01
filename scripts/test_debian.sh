#!/usr/bin/env bash
# Run setup and the test suite on other Debian releases, in throw-away roots.
set -euo pipefail

usage() {
    cat <<EOF
scripts/test_debian.sh [OPTION]... [SUITE]... [-- COMMAND...]

Suites are trixie and sid (default: both), or bookworm. Each gets a minimal root made by
mmdebstrap, in which scripts/setup.sh and then scripts/test.sh run, entered by bubblewrap.
Needs root or sudo. A table at the end says what passed.

  -- COMMAND...  run this instead of the tests; .venv/bin is first on PATH
  --shell        the same with an interactive shell
  --live         use this checkout and this machine's /tmp, not a copy of the checkout
  --fresh        make the roots anew (otherwise they are kept, with what was installed)
  --roots DIR    where the roots are kept
                 (default: \${XDG_CACHE_HOME:-~/.cache}/turbine_fenicsx/roots)
EOF
}

cd "$(dirname "$0")/.."
checkout=$PWD
roots=${XDG_CACHE_HOME:-$HOME/.cache}/turbine_fenicsx/roots
suites=()
command=(scripts/test.sh)
live=
fresh=
while [ $# -gt 0 ]; do
    case $1 in
    -h | --help) usage && exit ;;
    --shell) command=(bash) ;;
    --live) live=yes ;;
    --fresh) fresh=yes ;;
    --roots) roots=$2 && shift ;;
    --) shift && command=("$@") && break ;;
    -*) usage >&2 && exit 2 ;;
    *) suites+=("$1") ;;
    esac
    shift
done
[ ${#suites[@]} -gt 0 ] || suites=(trixie sid)

sudo=
[ "$(id -u)" -eq 0 ] || sudo=sudo
mkdir -p "$roots"
roots=$(cd "$roots" && pwd)

# The host's mirror of Debian, unless it is a kind of address that means nothing in a root.
mirror() {
    local found
    # shellcheck disable=SC2016 # $(REPO_URI) is for apt
    found=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' \
        'Origin: Debian' 'Label: Debian' 'Component: main' 2>/dev/null | grep -m 1 '^https\?://' || true)
    echo "${found:-http://deb.debian.org/debian}"
}

# The host's proxy and the like.
apt_options() {
    apt-config dump | grep -iE '^Acquire::(https?|Retries|Check-Valid-Until|Check-Date)\b' || true
}

make_root() {
    local root=$roots/$1
    [ -z "$fresh" ] || $sudo rm -rf "$root"
    [ ! -d "$root" ] || return 0
    echo "== $1: making the root $root"
    apt_options >"$roots/apt.conf"
    $sudo rm -rf "$root.new"
    $sudo mmdebstrap --quiet --mode=root --variant=apt --include=ca-certificates \
        --aptopt="$roots/apt.conf" "$1" "$root.new" "$(mirror)" || {
        $sudo rm -rf "$root.new"
        echo "mmdebstrap could not make $1 from $(mirror)" >&2
        return 1
    }
    $sudo mkdir -p "$root.new/checkout" "$root.new/venv"
    $sudo mv "$root.new" "$root"
}

# The files of git, with changes that are not committed; .venv of an earlier copy stays.
copy_checkout() {
    local copy=$roots/$1/checkout
    $sudo find "$copy" -mindepth 1 -delete
    git ls-files -z --cached --others --exclude-standard |
        while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done |
        tar --create --null --files-from=- | $sudo tar --extract --no-same-owner --directory="$copy"
    $sudo mkdir -p "$copy/.venv"
}

# Give the root the network, certificates and package indexes of the host.
share_host() {
    local root=$roots/$1 file
    for file in /etc/resolv.conf /etc/hosts /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
        [ ! -e "$file" ] || $sudo cp "$(readlink -f "$file")" "$root$file"
    done
    for file in .pip/pip.conf .config/pip/pip.conf; do
        [ ! -e "$HOME/$file" ] || $sudo install -D -m 644 "$HOME/$file" "$root/root/$file"
    done
}

# Set $shared to bwrap options for the variables and local directories that pip uses here.
share_pip() {
    local name value path
    shared=()
    for name in $(compgen -e | grep -E '^(PIP_.*|(https?|HTTPS?|no|NO|all|ALL)_(proxy|PROXY)|SSL_CERT_.*|.*_CA_BUNDLE|TERM|CI|LANG)$'); do
        shared+=(--setenv "$name" "${!name}")
    done
    while read -r value; do
        case $value in
        file:///*) path=$(dirname "${value#file://}") ;; # links beside an index point to its files
        *) path=$value ;;
        esac
        case $path in
        / | /etc/ssl/* | /etc/pip.conf) ;; # share_host has copied these
        *) [ ! -e "$path" ] || shared+=(--ro-bind "$path" "$path") ;;
        esac
    done < <(python3 -m pip config list 2>/dev/null | grep -oE "(file:/)?/[^' ,]+" | sort -u)
}

enter() {
    local root=$roots/$1 source=$roots/$1/checkout tmp=(--perms 1777 --tmpfs /tmp)
    shift
    [ -z "$live" ] || source=$checkout tmp=(--bind /tmp /tmp)
    $sudo bwrap --bind "$root" / --proc /proc --dev /dev --ro-bind /sys /sys "${tmp[@]}" \
        --bind "$source" "$checkout" --bind "$root/venv" "$checkout/.venv" --chdir "$checkout" \
        --cap-add ALL --die-with-parent --clearenv --setenv HOME /root \
        --setenv PATH "$checkout/.venv/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin" \
        "${shared[@]}" "$@"
}

prepare() {
    make_root "$1"
    share_host "$1"
    [ -n "$live" ] || copy_checkout "$1"
    echo "== $1: setup"
    enter "$1" bash scripts/setup.sh
}

missing=()
command -v mmdebstrap >/dev/null || missing+=(mmdebstrap)
command -v bwrap >/dev/null || missing+=(bubblewrap)
if [ ${#missing[@]} -gt 0 ]; then
    echo "== Debian packages: ${missing[*]}"
    $sudo apt-get update -qq || true
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends "${missing[@]}" >/dev/null
fi
share_pip
mkdir -p .venv # the place where the root's own is put

table=()
failed=0
for suite in "${suites[@]}"; do
    result=failed
    versions="? ?"
    set +e # and again in the subshell: inside an "if", errors in functions would be passed over
    (set -e && prepare "$suite")
    prepared=$?
    set -e
    if [ $prepared -eq 0 ]; then
        versions=$(enter "$suite" python -c \
            'import dolfinx, platform; print(dolfinx.__version__, platform.python_version())')
        echo "== $suite: ${command[*]} (DOLFINx, Python $versions)"
        if enter "$suite" "${command[@]}"; then result=passed; fi
    fi
    [ "$result" = passed ] || failed=1
    # shellcheck disable=SC2086 # two words
    table+=("$(printf '%-10s %-14s %-8s %s' "$suite" $versions "$result")")
done
printf '\n%-10s %-14s %-8s %s\n' suite DOLFINx Python result
printf '%s\n' "${table[@]}"
exit $failed
