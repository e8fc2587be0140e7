#!/bin/sh
# SPDX-License-Identifier: MIT
# Links a profile of the firmware; if the program does not fit the flash, says what to do.
# usage: link.sh BOARD PROFILE COMMAND...
board=$1 profile=$2
shift 2
errors=$(env "$@" 2>&1)
status=$?
[ -z "$errors" ] || printf '%s\n' "$errors" >&2
case $errors in
*"region \`text' overflowed"*)
    echo "profile '$profile' does not fit the flash of '$board': 'make size-map BOARD=$board PROFILE=$profile' shows" \
        "what takes the flash; CONTRIBUTING.md, 'Make room', says what to do" >&2 ;;
esac
exit $status
