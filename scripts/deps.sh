#!/bin/sh
# SPDX-License-Identifier: MIT
# Looks for what the build, the simulator and the tests need, and installs what is missing: Debian
# packages with apt-get (through sudo when not root), Unity out of the gem of its authors. With
# everything there it takes a fraction of a second and touches nothing.
#   usage: deps.sh packages|unity|docs|eva|site|test-build|panel|panel-test
#   DEPS=no      install nothing; name what is missing and fail
#   UNITY=DIR    where Unity is, or is to be put (default build/unity)
set -eu

# what proves that it is there | its Debian package
WANTED='
/usr/bin/avr-gcc                    gcc-avr
/usr/bin/avr-ld                     binutils-avr
/usr/lib/avr/include/avr/io.h       avr-libc
/usr/include/simavr/sim_avr.h       libsimavr-dev
/usr/bin/simavr                     simavr
/usr/bin/avr-gdb                    gdb-avr
/usr/bin/avrdude                    avrdude
/usr/share/arduino/hardware/arduino/avr/platform.txt arduino-core-avr
/usr/bin/gcc                        gcc
/usr/include/stdio.h                libc6-dev
/usr/include/libelf.h               libelf-dev
/usr/bin/python3                    python3
/usr/bin/gem                        ruby
/usr/bin/gnuplot                    gnuplot-nox
/usr/bin/clang-format               clang-format
/usr/sbin/update-ca-certificates    ca-certificates
'
# Only make eva needs these: Frama-C has 450 MB, and compiles test/eva/machdep.ml with ocamlfind.
WANTED_BY_EVA='
/usr/bin/frama-c                    frama-c-base
/usr/bin/ocamlfind                  ocaml-findlib
/usr/bin/ocamlopt                   ocaml
'
# Only make site needs it.
WANTED_BY_SITE='
/usr/bin/doxygen                    doxygen
'
# Only make test-build needs these: it builds the examples with the installed library.
WANTED_BY_TEST_BUILD='
/usr/bin/cmake                      cmake
/usr/bin/pkg-config                 pkgconf
'
# Only make docs and make check need it: scripts/typed.py types the sessions of docs/console.md into it.
WANTED_BY_DOCS='
/usr/bin/tmux                       tmux
'
# The control panel, beside node and npm, if node is not there or older than 18.
WANTED_BY_PANEL='
/usr/bin/websockify                 websockify
'
# Only make test-panel needs it.
WANTED_BY_PANEL_TEST='
/usr/bin/chromium-headless-shell    chromium-headless-shell
'
NODE_VERSION=18
GEM=ceedling
GEM_VERSION=1.2.1
GEM_SHA256=928095286b7a25777a2d520b9da6b6ee8255e17689910ddf60b12ec996ec115e
UNITY=${UNITY:-build/unity}

missing_packages()
{
    echo "$WANTED" | while read -r proof package; do
        [ -z "$proof" ] || [ -e "$proof" ] || command -v "$(basename "$proof")" >/dev/null || echo "$package"
    done
}

# The packages of node and npm, unless both are there and node is new enough.
missing_node()
{
    if ! command -v npm >/dev/null || ! command -v node >/dev/null ||
        [ "$(node -p 'process.versions.node.split(".")[0]')" -lt "$NODE_VERSION" ]; then
        echo nodejs
        echo npm
    fi
}

install_packages()
{
    root=
    [ "$(id -u)" = 0 ] || root=sudo
    echo "installing Debian packages:" $1
    $root apt-get update -q
    # shellcheck disable=SC2086 # a list of words
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $1
}

fetch_unity()
{
    echo "fetching Unity 2.7 out of the gem $GEM $GEM_VERSION into $UNITY (some seconds)"
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    # gem install keeps the archive in cache/, and runs no code of this gem. gem fetch reads the list
    # of all gems first: 15 s more. gem says on stderr why it fails; its status is 0 nonetheless.
    gem install --install-dir "$work" --ignore-dependencies --no-document "$GEM" -v "$GEM_VERSION" \
        >/dev/null || true
    [ -s "$work/cache/$GEM-$GEM_VERSION.gem" ] || {
        echo "deps: the gem $GEM $GEM_VERSION could not be fetched; without the network: make" \
            "UNITY=dir, a copy of Unity 2.7" >&2
        exit 1
    }
    echo "$GEM_SHA256  $work/cache/$GEM-$GEM_VERSION.gem" | sha256sum -c --quiet - || {
        echo "deps: the gem $GEM $GEM_VERSION is not the one we know (SHA-256 differs); not used" >&2
        exit 1
    }
    tar -xf "$work/cache/$GEM-$GEM_VERSION.gem" -C "$work" data.tar.gz
    tar -xzf "$work/data.tar.gz" -C "$work" vendor/cmock/vendor/unity
    mkdir -p "$UNITY"
    cp -R "$work/vendor/cmock/vendor/unity/." "$UNITY"
    echo "Unity is in $UNITY"
}

case "${1:-}" in
packages | docs | eva | site | test-build | panel | panel-test)
    case $1 in
    docs) WANTED=$WANTED_BY_DOCS ;;
    eva) WANTED=$WANTED_BY_EVA ;;
    site) WANTED=$WANTED_BY_SITE ;;
    test-build) WANTED=$WANTED_BY_TEST_BUILD ;;
    panel) WANTED=$WANTED_BY_PANEL ;;
    panel-test) WANTED=$WANTED_BY_PANEL_TEST ;;
    esac
    packages=$({
        missing_packages
        [ "$1" != panel ] || missing_node
    } | sort -u | tr '\n' ' ')
    [ -n "$packages" ] || exit 0
    [ "${DEPS:-yes}" != no ] || {
        echo "missing Debian packages: $packages (make deps installs them)" >&2
        exit 1
    }
    install_packages "$packages"
    ;;
unity)
    [ ! -e "$UNITY/src/unity.c" ] || [ ! -e "$UNITY/auto/generate_test_runner.rb" ] || exit 0
    [ "${DEPS:-yes}" != no ] || {
        echo "missing Unity in $UNITY (make deps fetches it)" >&2
        exit 1
    }
    fetch_unity
    ;;
*)
    echo "usage: deps.sh packages|unity|docs|eva|site|test-build|panel|panel-test" >&2
    exit 2
    ;;
esac
