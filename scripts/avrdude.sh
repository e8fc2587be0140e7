#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs `avrdude -P PORT ARGUMENT...`, and ends where avrdude 7.1 would spin for ever: it does so if it
# cannot open the device file PORT, or if the device is unplugged while avrdude talks to it.
# Names that are no device file (usb, net:host:1234, ch340, usb:serial) go to avrdude unchecked.
#   usage: avrdude.sh PORT [ARGUMENT...]    without ARGUMENT: only the check of PORT
#   AVRDUDE_LIMIT_S=N   seconds until avrdude is ended; 600 by default, several times what 256 KB take at 115200 baud
set -eu

LIMIT_S=${AVRDUDE_LIMIT_S:-600}
port=$1
shift

refuse()
{
    echo "avrdude is not started: $1" >&2
    exit 1
}

# The file before the first colon counts, too: linuxspi takes /dev/spidev0.0:/dev/gpiochip0.
check_device()
{
    device=$port
    [ -e "$device" ] || device=${port%%:*}
    if [ ! -e "$device" ]; then
        found=$(find /dev -maxdepth 1 \( -name 'ttyACM*' -o -name 'ttyUSB*' \) | sort | tr '\n' ' ')
        refuse "PORT=$port does not exist; plug the board in, or name its port: make ... PORT=${found:-/dev/ttyACM0}"
    fi
    [ -c "$device" ] || refuse "PORT=$port is no device; name the serial port of the board"
    [ -r "$device" ] && [ -w "$device" ] || refuse \
        "PORT=$port may not be opened by $(id -un); sudo usermod -aG $(stat -L -c %G "$device") $(id -un), and log in again"
}

case $port in
/* | ./* | ../*) check_device ;;
esac
[ $# -gt 0 ] || exit 0

[ ! -t 1 ] || printf '\033[K' # clears the line of progress of make
echo "avrdude -P $port $*"
status=0
timeout --foreground "$LIMIT_S" avrdude -P "$port" "$@" || status=$?
if [ "$status" = 124 ]; then
    echo "avrdude is ended after $LIMIT_S s; plug the board or programmer in again, and repeat the command" >&2
elif [ "$status" != 0 ]; then
    echo "avrdude failed: look whether the programmer is plugged in and its driver lets $(id -un) use it;" \
        "make ... PROGRAMMER=name PORT=port names another one" >&2
fi
exit "$status"
