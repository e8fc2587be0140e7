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
    keys: "Drag a dial, or focus it: ← → jog while held, ↑ ↓ step 1°, Page keys 10°, Home and End to the limits. Digits choose a servo: 1 2 is servo 12. Esc or Space stops. ▲ position, ● goal, ○ goal not confirmed.",
    dialOf: (id) => `Goal of servo ${id}`,
    dialValue: (goal, position, isOff) => `goal ${goal}, position ${position}${isOff ? ", torque is off" : ""}`,
    endless: "Endless turn",
    turnOf: (id) => `Turning speed of servo ${id}, right is clockwise`,
    turnHint: "Turns while held",
    unknown: "not asked yet",
    online: "online",
    offline: "offline",
    old: "old",
    silent: "Does not answer",
    silentAdvice: "no answer. Check power, wiring and ID.",
    ignored: "Ignored: torque is off",
    ignoredAdvice: "torque is off. Switch torque on first.",
    inhibited: "Inhibited",
    stopped: "Driving is inhibited by a stop. Press Release to allow it.",
    host: "Driving is inhibited: the controller lost the link to this machine. Press Release to allow it.",
    lost: "torque went off by itself, so the controller inhibits driving. Check the power, then press Release.",
    releaseOf: (id) => `Release servo ${id}`,
    goalStates: {
        unconfirmed: "Goal not confirmed",
        dropped: "Last goal not sent",
        refused: "Goal refused",
    },
    goalAdvice: {
        unconfirmed: "goal not confirmed. Set it again.",
        dropped: "goal not sent. Set it again.",
        refused: "goal refused. Set one within the limits.",
    },
    alarm: (name) => `Alarm: ${name}`,
    alarmAdvice: (name) => `${name}. ${alarms[name] ?? ""}`,
    noValue: "–",
};
