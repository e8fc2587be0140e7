// SPDX-License-Identifier: MIT
/* What happened, then what to do: {text, remedy, level}. The level is error, if it is not given. */

import { board } from "./board.js";
import { motionNotices } from "./motion.js";
import { afterLoss, does, list, servo } from "./words.js";

const STOP_AGAIN = "Press Stop again. If the robot still moves, switch off the power of the servos.";

/* Codes of WireError and of notices of the wire. */
export const wire = {
    timeout: ({ detail }) => ({
        text: `No reply came${detail ? " to " + detail : ""}.`,
        remedy: "Check power, wiring, ID and rate of the servo. Then try again.",
    }),
    late: () => ({
        text: "Not sent: another command had the wire for too long.",
        remedy: "Wait for its end, or end it. Then try again.",
    }),
    stopped: () => ({ text: "Ended by Stop.", remedy: "Press Release, then try again.", level: "info" }),
    closed: () => ({ text: "The port is closed.", remedy: "Connect again." }),
    cancelled: () => ({ text: "Cancelled before it was sent.", remedy: "Start it again if you want it." }),
    ended: ({ detail }) => ({
        text: `${detail ? `“${detail}”` : "The command"} was ended, and the controller did not confirm it.`,
        remedy: "See what it has done, then start it again if you want it.",
        level: "warning",
    }),
    silent: () => ({
        text: "The controller does not answer.",
        remedy: "Check its power, the cable and the rate. Press reset on the board. Close other programs and tabs that have the port.",
    }),
    back: () => ({ text: "The controller answers again.", remedy: "", level: "info" }),
    lost: ({ detail, ...loss }) => ({
        text: `The port was lost: ${detail}. ${afterLoss(loss)}`,
        remedy: "Check the cable, then connect again.",
    }),
    "lost-stopping": ({ detail }) => ({
        text: `The port was lost during a stop: ${detail}. It is not known whether torque is off.`,
        remedy: "Switch off the power of the servos.",
    }),
};

/* Codes of PortError. */
export const port = {
    unsupported: () => ({
        text: "This browser cannot open serial ports.",
        remedy: "Use Chrome or Edge, at https or localhost.",
    }),
    "not-chosen": () => ({ text: "No port was chosen.", remedy: "Press the button again and choose a port.", level: "info" }),
    denied: ({ detail }) => ({
        text: `The browser did not give a port: ${detail}.`,
        remedy: "Allow serial ports for this page in the settings of the browser.",
    }),
    "in-use": ({ detail }) => ({
        text: `The port could not be opened: ${detail}.`,
        remedy: "Close other programs and tabs that have the port. On Linux your user must be in the group dialout.",
    }),
    "not-open": () => ({ text: "The port is not open.", remedy: "Connect again." }),
    "bad-address": ({ detail }) => ({
        text: `This is not an address of a WebSocket: ${detail}.`,
        remedy: "Write it as ws://127.0.0.1:8055/websockify.",
    }),
    "nothing-there": ({ detail }) => ({
        text: `Nothing answers at ${detail}.`,
        remedy: "Start the simulator with make panel. Only one page at a time can be connected.",
    }),
    "no-answer": ({ detail }) => ({ text: `No answer from ${detail} within 5 s.`, remedy: "Check the address and the network." }),
    "bad-capture": ({ detail }) => ({ text: `This is not a capture: ${detail}.`, remedy: "Choose a file that this page has saved." }),
};

/* Notices of the session and of the robot. */
export const notice = {
    "servo-silent": (detail) => ({
        text: `${servo(detail)} ${does(detail)} not answer.`,
        remedy: "Check power and plug, then try again. “Diagnosis” finds out why.",
    }),
    "register-not-taken": (detail) => ({
        text: `${servo(detail)} did not take ${detail.register}: it has ${detail.now}, not ${detail.wanted}.`,
        remedy: "See whether the servo is locked. Switch its power off and on, then try again.",
    }),
    "level-silent": ({ id }) => ({
        text: `Servo ${id} was told STATUS_RETURN_LEVEL 0: now it answers PING only.`,
        remedy: `To read it again, send “write ${id} STATUS_RETURN_LEVEL 2” by the console, or its packet by hand.`,
        level: "warning",
    }),
    "backup-damaged": ({ detail }) => ({
        text: `The backup is damaged: ${detail}. Nothing was written.`,
        remedy: "Choose another copy of the file, or save a new backup.",
    }),
    "backup-foreign": () => ({
        text: "This file is no backup of servos. Nothing was written.",
        remedy: "Choose a file that this page has saved.",
    }),
    "backup-version": ({ found, known }) => ({
        text: `The backup has version ${found}, this page knows version ${known}. Nothing was written.`,
        remedy: "Open the page of that version.",
    }),
    "backup-other-id": ({ id, ids }) => ({
        text: `The backup is of ${list(ids)}, not of servo ${id}. Nothing was written.`,
        remedy: "Choose the servo of the file, or give this servo its ID first.",
    }),
    "backup-other-model": ({ id, model, found }) => ({
        text: `Servo ${id} is of model ${found}, the backup of model ${model}. Nothing was written.`,
        remedy: "Choose a backup of a servo of the same model.",
    }),
    "backup-crossed": ({ id, low, high }) => ({
        text: `Servo ${id}: ${low} would be above ${high}. Nothing was written.`,
        remedy: "Correct the value or the file.",
    }),
    "limits-move": ({ id }) => ({
        text: `Servo ${id} has torque and would move: the new angle limits exclude its goal, or begin or end endless turn. Nothing was written to it.`,
        remedy: "Switch its torque off first.",
    }),
    "backup-changed": (detail) => ({
        text: `${servo(detail)} has changed since the file was compared. Nothing was written.`,
        remedy: "Choose the file again.",
    }),
    "file-unread": ({ detail }) => ({ text: `The file cannot be read: ${detail}.`, remedy: "Choose the file again." }),
    "file-large": ({ limit }) => ({
        text: `The file is too large: it may have ${limit} KB.`,
        remedy: "Choose a file that this page has saved.",
    }),
    "setting-refused": ({ setting }) => ({
        text: `The controller did not take the setting ${setting}.`,
        remedy: "Use a value within the range. End a motion that is under way, then try again.",
    }),
    "defaults-refused": () => ({ text: "The controller did not take the defaults.", remedy: "End a motion that is under way, then try again." }),
    "device-id-taken": ({ setting }) => ({
        text: `A servo has the ID ${setting}: with this device_id it could not be reached.`,
        remedy: "Choose another ID.",
    }),
    "id-of-device": ({ id }) => ({
        text: `${id} is the ID of the controller itself: the page could not reach a servo there. Nothing was changed.`,
        remedy: "Choose another ID.",
    }),
    "servo-behind-device": ({ id }) => ({
        text: `Servo ${id} has the ID of the controller itself: the page can neither show it nor confirm its stop.`,
        remedy: `Give it another ID: send “id ${id} 1” by the console, with 1 or another free ID. Then find servos.`,
    }),
    "not-saved": () => ({
        text: "The settings were not saved: the EEPROM has failed, or a motion is under way.",
        remedy: "End the motion and save again. If it fails again, replace the board.",
    }),
    "host-rate": () => ({
        text: "The rate to this page has changed.",
        remedy: "If the controller no longer answers, disconnect and connect at the new rate.",
        level: "warning",
    }),
    unwatched: ({ ms }) => ({
        text: `The page is silent during this command, so link_loss_ms is 0, then ${ms} again.`,
        remedy: "If the port is lost meanwhile, reset the board.",
        level: "warning",
    }),
    "unwatched-still": ({ ms }) => ({
        text: `link_loss_ms is 0 in place of ${ms}: the controller does not watch the link.`,
        remedy: "Wait for the end of the command, or set it in the view Board; then save.",
    }),
    "clear-inhibited": () => ({
        text: "The alarms were not cleared: driving is inhibited, and “clear” would end that, too.",
        remedy: "Remove the cause, press Release, then clear the alarms.",
    }),
    "release-refused": () => ({
        text: "The controller did not release the robot: torque off is under way.",
        remedy: "Wait a moment, then press Release again.",
    }),
    "goal-unconfirmed": (detail) => ({
        text: `${servo(detail)} did not confirm a goal. The goal was not sent again.`,
        remedy: "If driving is inhibited, press Release. If the servo has limits (command “limits”), stay within them.",
    }),
    "turn-not-ended": (detail) => ({
        text: `${servo(detail)} did not confirm the end of endless turn.`,
        remedy: "Press Stop if it must not turn.",
    }),
    turning: (detail) => ({
        text: `${servo(detail)} ${detail.ids?.length > 1 ? "turn" : "turns"} without end.`,
        remedy: "Press Stop if it must not turn.",
        level: "warning",
    }),
    "goal-refused": (detail) => ({
        text: `${servo(detail)} refused a goal: ${detail.why} error.`,
        remedy: "Keep the goal within the angle limits of the servo.",
    }),
    "goal-not-kept": (detail) => ({
        text: `${servo(detail)} did not keep the goal that was written before torque on. Torque stays off.`,
        remedy: "Hold the joint still, look for noise on the line, then try again.",
    }),
    "joint-moves": (detail) => ({
        text: `${servo(detail)} moved while torque was switched on. Torque stays off.`,
        remedy: "Hold the joint still, then try again.",
    }),
    "torque-on-late": ({ id, ids = [id] }) => ({
        text: `Torque of ${list(ids)} stays off: another command had the wire for too long.`,
        remedy: "Wait for its end, or end it. Then try again.",
    }),
    "torque-off-late": ({ id, ids = [id] }) => ({
        text: `Torque of ${list(ids)} stays on: another command had the wire for too long.`,
        remedy: "Press Stop. Or wait for the end of the command, or end it. Then try again.",
    }),
    inhibited: ({ id, ids = [id] }) => ({
        text: `Torque of ${list(ids)} stays off: driving is inhibited.`,
        remedy: "Remove the cause, press Release, then switch torque on.",
    }),
    refused: (detail) => ({
        text: `${servo(detail)} refused the packet: ${detail.why} error.`,
        remedy: "See whether the servo is locked, and whether its limits fit.",
    }),
    "stop-unverified": ({ on, silent }) => ({
        text: `Driving is inhibited.${on.length ? ` Torque is still on: ${list(on)}.` : ""}${silent.length ? ` No answer, so torque is not known: ${list(silent)}.` : ""}`,
        remedy: `${STOP_AGAIN}${silent.length ? " Check power and plug, or see “Diagnosis”. If unplugged on purpose, press “Find servos”." : ""}`,
    }),
    "stop-no-inhibit": () => ({ text: "The controller does not confirm the stop.", remedy: STOP_AGAIN }),
    "stop-not-sent": () => ({
        text: "Not connected to a robot: the stop was not sent.",
        remedy: "Switch off the power of the servos.",
    }),
    "stop-replay": () => ({ text: "A capture plays: there is no robot to stop.", remedy: "", level: "info" }),
    "stop-failed": () => ({
        text: "The stop is not confirmed: the port was lost.",
        remedy: "Switch off the power of the servos.",
    }),
    "other-version": ({ version, shown }) => ({
        text: `The firmware has version ${version}, this page is made for ${shown}.`,
        remedy: "Flash the firmware of this page, or open the page of that version.",
        level: "warning",
    }),
    "port-taken": () => ({
        text: "Another page or program is connected to the simulator.",
        remedy: "Close it, then connect again.",
    }),
    reset: () => ({
        text: "The controller was reset. Movements under way go on.",
        remedy: "Press Stop if the robot must not move. The view Board tells the cause.",
        level: "warning",
    }),
    bridge: () => ({
        text: "This firmware has the profile bridge: it has no console.",
        remedy: board.offers.bridge,
        level: "warning",
    }),
    "no-device": () => ({
        text: "The virtual device of the controller is off. There is no feedback, and a stop cannot be confirmed.",
        remedy: "Set device_id to 253 in the view Board, or at a terminal, then connect again.",
        level: "warning",
    }),
    console: () => ({
        text: "This firmware has the profile console.",
        remedy: board.offers.console,
        level: "info",
    }),
    ...motionNotices,
    command: ({ line, message, number, remedy }) => ({ text: `“${line}”: error ${number}, ${message}.`, remedy }),
    unexpected: ({ message }) => ({
        text: `The page failed: ${message}.`,
        remedy: "Reload it. If it happens again, save the traffic of the view Packets and report it.",
    }),
};
