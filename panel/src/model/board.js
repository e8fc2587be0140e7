// SPDX-License-Identifier: MIT
/* State and alarms of the controller: by the console, or, without one, by the registers of the device. */

import { errorNames } from "../wire/packet.js";
import { texts } from "../texts/texts.js";

const t = texts.board;
const NO_ID = 255;

/* The lines of `status` as {label, text, isDetail}; a line without colon begins with its label. isDetail: false if an owner
 * of the robot needs the line. */
export function parseStatus(lines) {
    return lines.map((line) => {
        const [, label, text] = /^(reset|bus)(?: by)? (.*)$/.exec(line) ?? /^([^:]+): (.*)$/.exec(line) ?? ["", line, ""];

        return { label: t.labels[label] ?? label, text: t.meanings[text.replace(/ at \d+bps$/, "")] ?? text, isDetail: !t.labels[label] };
    });
}

/* What `status` tells, or as much of it as the device has. */
export async function readStatus(session) {
    if (session.wire.hasConsole) return parseStatus(await session.controller.run("status"));
    const { device } = session.robot;

    if (!device) return [];
    return parseStatus([
        `reset by ${t.resets.filter((_, bit) => device.resetCause & (1 << bit)).join(", ")}`,
        `bus ${t.busStates[device.busState] ?? ""}`,
    ]);
}

/* The lines of `alarms`: [{who, condition}]. */
export function parseAlarms(lines) {
    return lines
        .map((line) => /^alarm (?:of servo )?(\d+|of others): (.*)$/.exec(line))
        .filter((match) => match)
        .map(([, id, condition]) => ({ who: id === "of others" ? t.others : t.servoName(id), condition }));
}

export async function readAlarms(session) {
    if (session.wire.hasConsole) return parseAlarms(await session.controller.run("alarms"));
    const { alarms = 0, alarmId = NO_ID } = session.robot.device ?? {};

    return errorNames(alarms).map((condition) => ({ who: alarmId === NO_ID ? t.someServo : t.servoName(alarmId), condition }));
}
