#!/bin/sh
# SPDX-License-Identifier: MIT
# Links a profile of the firmware; if the program does not fit the flash, says what to do, and writes the bytes that are
# too many to build/BOARD/PROFILE.over, for scripts/size.py.
# usage: link.sh BOARD PROFILE COMMAND...
board=$1 profile=$2
shift 2
rm -f "build/$board/$profile.over"
errors=$(env "$@" 2>&1)
status=$?
[ -z "$errors" ] || printf '%s\n' "$errors" >&2
over=$(printf '%s' "$errors" | sed -n "s/.*region \`text' overflowed by \([0-9]*\) bytes.*/\1/p")
if [ -n "$over" ]; then
    [ ! -d "build/$board" ] || echo "$over" > "build/$board/$profile.over"
    smaller='bridge console'
    [ "$profile" = full ] || smaller=bridge
    echo "profile '$profile' does not fit the flash of '$board', $over bytes over: see 'Make room' in CONTRIBUTING.md;" \
        "for a new board: PROFILES := $smaller in its board.mk (docs/linking.md)" >&2
fi
exit $status
