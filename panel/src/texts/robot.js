// SPDX-License-Identifier: MIT
/* The view Robot. */

import { alarms } from "./alarms.js";
import { many } from "./words.js";

export const robot = {
    find: "Find servos",
    finding: "Searching …",
    found: (count) => (count ? `${many(count, "servo")} found.` : ""),
    none: "No servo is known. Connect servos, then press “Find servos”.",
    notConnected: "Connect to a controller, or to the simulator, to see the servos.",
    servo: "Servo",
    torque: "Torque",
    torqueOf: (id) => `Torque of servo ${id}`,
    allOn: "Torque all on",
    allOff: "Torque all off",
    speedOfMoves: "Speed of moves",
    speedHint: "Speed of each goal that this page sends",
    clearAlarms: "Clear alarms",
    keys: "Drag a dial, or focus it: ← → jog while held, ↑ ↓ step 1°, Page keys 10°. Digits choose a servo: 1 2 is servo 12. Esc or Space stops all. ▲ position, ● goal, ○ goal not confirmed yet.",
    dialOf: (id) => `Goal of servo ${id}`,
    dialValue: (goal, position, isOff) => `goal ${goal}, position ${position}${isOff ? ", torque is off" : ""}`,
    endless: "Endless turn",
    turnOf: (id) => `Turning speed of servo ${id}, right is clockwise`,
    turnHint: "Turns while held",
    speed: "Speed",
    load: "Load",
    voltage: "Voltage",
    temperature: "Temperature",
    unknown: "not asked yet",
    online: "online",
    offline: "offline",
    old: "old",
    offlineRemedy: "Does not answer. Check its power, wiring and ID.",
    ignored: "Ignored: torque is off. Switch torque on first.",
    stopped: "Inhibited by a stop. Press Release to allow driving.",
    lost: "Inhibited: its torque went off by itself. Check its power, then release it.",
    releaseOf: (id) => `Release servo ${id}`,
    goalStates: {
        unconfirmed: "The goal is not confirmed.",
        dropped: "The last goal was dropped, it was not sent.",
        refused: "The servo refused the goal.",
    },
    alarm: (name) => `Alarm: ${name}. ${alarms[name] ?? ""}`,
    noValue: "–",
};
