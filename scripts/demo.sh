#!/bin/sh
# The main job: the manual's worked examples, then a wave through 18 servos, by the real firmware in
# the simulator. Leaves transcript, waveforms and motion in build/demo/. Fails if a reply was an
# error, a rule of the wire was broken or the firmware crashed.
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

cat <<EOF

$out/transcript.txt  every packet on the wire, with CPU cycles
$out/motion.svg      goal and present position of the 18 servos: open it in a browser
$out/motion.csv      the same as numbers
$out/bus.vcd         wire, enables, handlers: open it in GTKWave
EOF
