#!/bin/sh
# SPDX-License-Identifier: MIT
# The main job in the simulator, in four parts. Prints what each part shows, an extract of it, and its result;
# leaves the whole in build/demo/. Fails if a reply is not the expected one, if a rule of the wire is broken or
# if a program crashes.
set -eu
cd "$(dirname "$0")/.."

out=build/demo
sim=build/host/cds55xx-sim
mkdir -p "$out"

# run FILE OPTIONS: simulates, and keeps the output in FILE.
run() {
    file=$1
    shift
    "$sim" firmware "$@" > "$file" 2>&1 || {
        cat "$file"
        printf '\nThis part of make demo has FAILED: its output stands above, and in %s. First fault:\n' "$file"
        grep -m 1 '^rule broken' "$file" || tail -n 1 "$file"
        exit 1
    }
}

# passed FILE: the result of a part, from the summary of the run.
passed() {
    sed -n 's/^bus 0: *\([0-9]*\) packets in, \([0-9]*\) out.*/   passed: \1 packets to the servos, \2 replies, no rule of the wire broken/p' "$1"
}

picture() {
    gnuplot -e "csv='$out/$1.csv'; svg='$out/$1.svg'; name='$2'" scripts/motion.gp
}

cat <<'EOF'
The firmware of a servo controller runs on a simulated AVR and moves simulated servos.
Nothing is connected to this computer. There are four parts, which take about 20 seconds. A part passes if each
reply is the expected one and no rule of the wire is broken. For example, two drivers never drive the wire at once.

1 of 4: the worked examples of the servo's manual, typed at the console of the controller

EOF
cat examples/manual.script > "$out/demo.script"
scripts/wave.py >> "$out/demo.script"
run "$out/manual.txt" build/arduino-mega/controller.elf --board arduino-mega --script "$out/demo.script" --echo \
    --transcript "$out/transcript.txt" --vcd "$out/bus.vcd" --csv "$out/motion.csv"
picture motion 'A wave through 18 servos'
sed -n '/^Example 3:/,/^ok$/p' "$out/manual.txt"
cat <<'EOF'

The line behind > is typed. ->in is the packet to the servo, <-out its reply. The number before a packet is
the CPU cycle of its first bit, at 16 cycles per microsecond. The other examples ran in the same way; the manual has
no example 14 and no 17. build/demo/manual.txt has their commands, packets and replies:

EOF
sed -n '/^Example 3:/d; s/^Example /   /p' "$out/manual.txt"

cat <<'EOF'

2 of 4: a wave runs through 18 servos; one packet has the goals of all (SYNC WRITE)
EOF
passed "$out/manual.txt" | sed 's/passed:/parts 1 and 2 passed:/'

cat <<'EOF'

3 of 4: a hand teaches three poses to three servos; the controller stores them and plays them in a loop
These are the commands; build/demo/taught.txt has their packets and replies, too.

EOF
run "$out/taught.txt" build/arduino-mega/controller.elf --board arduino-mega --servos 1-3 \
    --script examples/console_teach.script --csv "$out/taught.csv"
picture taught 'Taught by hand, then played'
sed -n '/RETURN_DELAY/d; s/^> /   > /p; /^[A-Z][a-z]* .*[a-z]$/p' "$out/taught.txt"
passed "$out/taught.txt"

cat <<'EOF'

4 of 4: a robot with six legs walks: the program examples/hexapod sends goals to 18 servos every 4 ms
EOF
run "$out/walk.txt" build/arduino-mega/examples/hexapod.elf --board arduino-mega --servos 1-18 \
    --seconds 8 --csv "$out/walk.csv"
scripts/hexapod_picture.py "$out/walk.csv" "$out/hexapod.svg"
passed "$out/walk.txt"

cat <<EOF

Open the pictures (.svg) in a browser, bus.vcd in GTKWave.
$out/manual.txt      parts 1 and 2: the console and its packets
$out/transcript.txt  parts 1 and 2: every packet on the wire, with CPU cycles
$out/demo.script     parts 1 and 2: the commands
$out/bus.vcd         parts 1 and 2: wire, enables, interrupt handlers
$out/motion.svg      part 2: goal and present position of the 18 servos
$out/motion.csv      part 2 as numbers
$out/taught.svg      part 3: what three servos are taught, and play
$out/taught.txt      part 3: the console and its packets
$out/taught.csv      part 3 as numbers
$out/hexapod.svg     part 4: the robot from above; it walks
$out/walk.txt        part 4: the summary of the run
$out/walk.csv        part 4 as numbers

Type commands yourself: make run SERVOS=1-3. Other programs: examples/, docs/linking.md.

make demo: all 4 parts passed
EOF
