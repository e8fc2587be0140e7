// SPDX-License-Identifier: MIT
/* Packets and lines that a user has written. They go over the same wire as all others, in turn, within ORDER_MS or not at all. */

import { AT_ID, AT_INSTRUCTION, AT_PARAMETERS, INSTRUCTION } from "../wire/packet.js";
import { DEVICE } from "../wire/registers.js";
import { ORDER_MS } from "./controller.js";
import { isForgetting, silenceOf } from "./console_line.js";

const MANY_MS = 3000; // for the replies of many servos

/* True for a packet to the device that changes or saves the mode of the console, or that changes the ID of the device or the rate
 * of the host link: as changesOwnMode() for a line. Without a console there is no mode. */
export function packetChangesOwnMode({ wire }, bytes) {
    if (!wire?.hasConsole || !wire.hasDevice || bytes[AT_ID] !== wire.deviceId) return false;
    const first = bytes[AT_PARAMETERS];
    const written = bytes.length - AT_PARAMETERS - 2; // without address and checksum
    const isWritten = (register) => register >= first && register < first + written;

    if (bytes[AT_INSTRUCTION] === INSTRUCTION.WRITE) return [DEVICE.ID, DEVICE.HOST_BAUD, DEVICE.ECHO, DEVICE.SAVE].some(isWritten);
    return bytes[AT_INSTRUCTION] === INSTRUCTION.RESET;
}

/* Sends a packet. Resolves with its status packets (an array, empty: none is due); throws WireError. */
export async function sendPacket(session, bytes) {
    const isMany = bytes[AT_INSTRUCTION] >= INSTRUCTION.SYNC_WRITE;
    const notAfter = session.clock.now() + ORDER_MS;
    const reply = await session.wire.request(bytes, { source: "hand", notAfter, ...(isMany ? { timeout: MANY_MS } : {}) });

    return reply === null ? [] : [reply].flat();
}

/* Sends a line. Resolves with {error}; throws WireError. onLine(text) takes the lines. `onLine`, `signal`: wire.js.
 * After `servos forget` the page asks for the list again, without a scan: a scan would fill the list that `new` needs empty. */
export async function sendLine(session, line, { onLine, signal } = {}) {
    const { robot } = session;

    session.dispatchEvent(new Event("hand"));
    const reply = await session.wire.command(line, { source: "hand", notAfter: session.clock.now() + ORDER_MS, timeout: silenceOf(line), onLine, signal });

    if (reply.error) return reply;
    session.takeDone(line);
    if (isForgetting(line)) session.attempt(() => robot.findServos({ more: [] })); // the reply is shown meanwhile
    return reply;
}
