#!/usr/bin/env bash
# Run setup and the test suite on other Debian releases, in throw-away roots.
set -euo pipefail

usage() {
    cat <<EOF
scripts/test_debian.sh [OPTION]... [SUITE]... [-- COMMAND...]

Suites are trixie and sid (default: both), or bookworm. Each gets a minimal root made by
mmdebstrap, in which scripts/setup.sh and then scripts/test.sh -m "" run (all tests on one and on two
ranks), entered by bubblewrap. Needs root or sudo. A table at the end says what passed. Roots are
kept for a week, with what was installed and with compiled forms.
Exit code 1: something failed; 3: nothing failed, but a root could not be made or entered here.

  -- COMMAND...  run this instead of the tests; .venv/bin is first on PATH
  --shell        the same with an interactive shell
  --live         use this checkout and this machine's /tmp, not a copy of the checkout
  --fresh        make the roots anew, however old they are
  --roots DIR    where the roots are kept
                 (default: \${XDG_CACHE_HOME:-~/.cache}/turbine_fenicsx/roots)
EOF
}

cd "$(dirname "$0")/.."
checkout=$PWD
place=/turbine_fenicsx # where the checkout is in a root, so that any checkout finds the same .venv
roots=${XDG_CACHE_HOME:-$HOME/.cache}/turbine_fenicsx/roots
suites=()
command=(scripts/test.sh -m "")
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

# A new root where there is none of this week; an older one stays if that fails.
make_root() {
    local root=$roots/$1
    [ -n "$fresh" ] || [ -z "$(find "$root/made" -mtime -7 2>/dev/null)" ] || return 0
    echo "== $1: making the root $root"
    apt_options >"$roots/apt.conf"
    $sudo rm -rf "$root.new"
    $sudo mmdebstrap --quiet --mode=root --variant=apt --include=ca-certificates \
        --aptopt="$roots/apt.conf" "$1" "$root.new" "$(mirror)" || {
        $sudo rm -rf "$root.new"
        echo "== $1: mmdebstrap could not make a root from $(mirror)"
        [ -e "$root/made" ] || return 1
        echo "== $1: using the root of $(date -r "$root/made" +%F)"
        return 0
    }
    $sudo mkdir -p "$root.new/checkout" "$root.new/venv" "$root.new$place"
    $sudo touch "$root.new/made"
    $sudo rm -rf "$root"
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
        --bind "$source" "$place" --bind "$root/venv" "$place/.venv" --chdir "$place" \
        --cap-add ALL --die-with-parent --clearenv --setenv HOME /root \
        --setenv PATH "$place/.venv/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin" \
        "${shared[@]}" "$@"
}

prepare() {
    share_host "$1"
    [ -n "$live" ] || copy_checkout "$1"
    echo "== $1: setup"
    enter "$1" bash scripts/setup.sh 2>&1 | tee "$roots/$1.log"
    $sudo find "$roots/$1/var/cache/apt/archives" -name '*.deb' -delete
}

# Say why not and end with code 3: this machine cannot do it, which is no fault of the checkout.
give_up() {
    echo "== not tested on ${suites[*]}: $*"
    exit 3
}

missing=()
command -v mmdebstrap >/dev/null || missing+=(mmdebstrap)
command -v bwrap >/dev/null || missing+=(bubblewrap)
if [ ${#missing[@]} -gt 0 ]; then
    echo "== Debian packages: ${missing[*]}"
    $sudo apt-get update -qq || true
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends \
        "${missing[@]}" >/dev/null || give_up "${missing[*]} could not be installed"
fi
$sudo bwrap --bind / / --proc /proc --dev /dev true ||
    give_up "bubblewrap may not make a system of its own here"
share_pip
mkdir -p .venv # the place where the root's own is put

table=()
failed=0
without=0
for suite in "${suites[@]}"; do
    result=failed
    versions="? ?"
    : >"$roots/$suite.log"
    exec 8>"$roots/$suite.lock"
    flock 8 # one at a time in each root
    set +e # and again in the subshell: inside an "if", errors in functions would be passed over
    (set -e && make_root "$suite")
    made=$?
    (set -e && [ $made -eq 0 ] && prepare "$suite")
    prepared=$?
    set -e
    if [ $made -ne 0 ]; then
        result="not tested, no root"
        without=1
    elif [ $prepared -eq 0 ]; then
        versions=$(enter "$suite" python -c \
            'import dolfinx, platform; print(dolfinx.__version__, platform.python_version())')
        echo "== $suite: ${command[*]} (DOLFINx, Python $versions)"
        if enter "$suite" "${command[@]}"; then result=passed; fi
    elif grep -q 'error: no network' "$roots/$suite.log"; then
        result="not tested, no network"
        without=1
    fi
    exec 8>&-
    [ "$result" != failed ] || failed=1
    # shellcheck disable=SC2086 # two words
    table+=("$(printf '%-10s %-14s %-8s %s' "$suite" $versions "$result")")
done
printf '\n%-10s %-14s %-8s %s\n' suite DOLFINx Python result
printf '%s\n' "${table[@]}"
[ $failed -eq 0 ] || exit 1
[ $without -eq 0 ] || exit 3
