// SPDX-License-Identifier: MIT
/* Header, tabs and notices of the page; units. */

import { afterLoss, many } from "./words.js";

export const page = {
    name: "CDS55xx",

    framed: "This page does not connect inside another page. Open it in a tab of its own.",

    connect: {
        serial: "Connect by USB",
        rate: "Rate",
        socket: "Connect to the simulator",
        more: "More",
        address: "Address of the simulator",
        replay: "Play a capture",
        disconnect: "Disconnect",
        askDisconnect: (loss) => `Torque is on, or not known. ${afterLoss(loss)} No stop of this page reaches the servos then. Disconnect?`,
        noSerial: "This browser cannot open serial ports. Use Chrome or Edge, at https or localhost.",
    },

    stop: {
        button: "Stop",
        hint: "Torque off for all servos. Keys: Esc, Space",
        none: "",
        stopping: "Stopping …",
        verified: "Torque is off, driving is inhibited",
        unchecked: "Driving is inhibited. No servo was checked.",
        unverified: "Stop not confirmed",
        failed: "Stop not confirmed",
        release: "Release",
        releaseHint: "Allows driving again, also after a lost link. Nothing moves; torque stays as it is.",
    },

    state: {
        disconnected: "Not connected",
        connecting: "Connecting …",
        waiting: "Another page or program is connected. Waiting for it to leave …",
        connected: "Connected",
        replay: "A capture plays, no robot",
        silent: "The controller does not answer",
    },

    status: {
        servos: (count, offline) => many(count, "servo") + (offline ? `, ${offline} offline` : ""),
        rate: (rate) => `${rate} updates a second`,
        inhibited: "Driving is inhibited",
        lost: (ids) => (ids.length ? `${many(ids.length, "servo is", "servos are")} inhibited` : ""),
        old: "Values are old",
    },

    tabs: {
        robot: "Robot",
        graphs: "Graphs",
        setup: "Set-up",
        motion: "Motion",
        packets: "Packets",
        board: "Board",
    },

    units: { deg: "°", C: "°C", bps: "bit/s" },

    notices: "Notices",
    dismiss: "Dismiss",
    dismissAll: "Dismiss all",
    undo: "Undo",
    escHint: "Esc cancels, and stops the robot.",
    remedy: "What to do:",
};
