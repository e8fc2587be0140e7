#!/bin/sh
# SPDX-License-Identifier: MIT
# The main job in the simulator: the real firmware carries out the manual's worked examples and a wave
# through 18 servos; it plays what a person has taught; examples/hexapod walks. Leaves transcript,
# waveforms and motion in build/demo/. Fails if a reply was an error, a rule of the wire was broken or a
# program crashed.
set -eu
cd "$(dirname "$0")/.."

out=build/demo
elf=build/atmega128/controller.elf
mkdir -p "$out"
{ cat examples/manual.script; scripts/wave.py; } > "$out/demo.script"

build/host/cds55xx-sim firmware "$elf" --board atmega128 --script "$out/demo.script" --echo \
    --transcript "$out/transcript.txt" --vcd "$out/bus.vcd" --csv "$out/motion.csv"
gnuplot -e "csv='$out/motion.csv'; svg='$out/motion.svg'; name='A wave through 18 servos'" \
    scripts/motion.gp

printf '\nA hand teaches three poses to three servos; the controller stores and plays them\n'
build/host/cds55xx-sim firmware build/arduino-mega/controller.elf --board arduino-mega --servos 1-3 \
    --script examples/console_teach.script --csv "$out/taught.csv" > "$out/taught.txt" 2>&1 || {
    cat "$out/taught.txt"
    exit 1
}
grep -v ' bus0 ' "$out/taught.txt" # all but the packets
gnuplot -e "csv='$out/taught.csv'; svg='$out/taught.svg'; name='Taught by hand, then played'" \
    scripts/motion.gp

printf '\nA hexapod walks: 18 servos in a tripod gait, goals at 250 Hz (examples/hexapod)\n'
build/host/cds55xx-sim firmware build/atmega128/examples/hexapod.elf --board atmega128 --servos 1-18 \
    --seconds 8 --csv "$out/walk.csv"
scripts/hexapod_picture.py "$out/walk.csv" "$out/hexapod.svg"

printf '\nOther examples, which the tests run (%s):' 'make examples builds the programs'
for file in examples/*; do
    [ "${file%.h}" = "$file" ] || continue # a header of several examples
    grep -q "/$(basename "${file%.*}")\." "$0" || printf ' %s' "$file"
done
echo

cat <<EOF

$out/transcript.txt  every packet on the wire, with CPU cycles
$out/motion.svg      goal and present position of the 18 servos: open it in a browser
$out/motion.csv      the same as numbers
$out/bus.vcd         wire, enables, handlers: open it in GTKWave
$out/taught.svg      what three servos are taught, and play
$out/taught.csv      the same as numbers
$out/taught.txt      its console and packets
$out/hexapod.svg     the hexapod from above: it walks in a browser
$out/walk.csv        goal and present position of its 18 servos
$out/demo.script     the commands of the examples and of the wave
EOF
