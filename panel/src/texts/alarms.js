// SPDX-License-Identifier: MIT
/* What to do about each alarm, by its name on the console. */

export const alarms = {
    "input voltage": "Measure the supply at the servo. Set MIN_VOLTAGE and MAX_VOLTAGE if it is right.",
    "angle limit": "A goal was beyond the angle limits. Correct the goal or the limits.",
    overheating: "Let the servo cool down, with torque off. Look for a blocked or heavy joint.",
    range: "A packet had a value out of range. Look at the view Packets for it.",
    checksum: "Packets come damaged. Look for noise and a loose wire; read the counters in the view Packets.",
    overload: "Switch its torque off, then take the load off: a freed servo runs on to its goal.",
    "torque went off by itself": "Mend power, load or plug, or let it cool; then “Release”.",
    instruction: "A packet had an instruction that the servo does not know. Look at the view Packets for it.",
};
