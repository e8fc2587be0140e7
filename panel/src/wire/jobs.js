// SPDX-License-Identifier: MIT
/* What the wire carries: a packet with its replies, or a line of text with its reply. A job is one
 * promise; the wire gives it what arrives until the job ends. */

import {
    AT_INSTRUCTION,
    AT_ID,
    AT_PARAMETERS,
    BROADCAST_ID,
    ERRORS_OF_PACKET,
    INSTRUCTION,
    repliesDue,
} from "./packet.js";
import { WireError } from "./wire_error.js";

class Job {
    constructor(bytes, { timeout, limit = Infinity, notAfter = Infinity, signal, source = "page" }) {
        this.bytes = bytes;
        this.source = source; // the traffic tells it: "page", "search", "probe" (of the first contact), or "hand" (of a user)
        this.timeout = timeout; // ms without an answer
        this.limit = limit; // ms until the end of the reply, however much comes
        this.notAfter = notAfter; // ms of the clock; the job is not sent later
        this.signal = signal; // an AbortSignal, or undefined
        this.isOver = false;
        this.promise = new Promise((resolve, reject) => {
            this.resolve = resolve;
            this.reject = reject;
        });
        this.promise.catch(() => {}); // the sender has the same promise; a rejection is never unhandled
    }

    end(value) {
        this.isOver = true;
        this.resolve(value);
    }

    fail(code, detail) {
        this.isOver = true;
        this.reject(new WireError(code, detail));
    }
}

/* Number of parameters that the reply has, if the packet is carried out. */
function parametersDue(bytes) {
    const count = bytes[AT_PARAMETERS + 1];

    if (bytes[AT_INSTRUCTION] === INSTRUCTION.READ) return count;
    if (bytes[AT_INSTRUCTION] === INSTRUCTION.SYNC_READ) return count * (bytes.length - AT_PARAMETERS - 3);
    return 0;
}

/* ID of the servo that sends reply `index`, or null: any. */
function idDue(bytes, index, deviceId) {
    if (bytes[AT_INSTRUCTION] === INSTRUCTION.SYNC_READ) return deviceId;
    if (bytes[AT_INSTRUCTION] === INSTRUCTION.BULK_READ) return bytes[AT_PARAMETERS + 2 + 3 * index];
    return bytes[AT_ID] === BROADCAST_ID ? null : bytes[AT_ID];
}

function countDue(bytes, index) {
    if (bytes[AT_INSTRUCTION] === INSTRUCTION.BULK_READ) return bytes[AT_PARAMETERS + 1 + 3 * index];
    return parametersDue(bytes);
}

export class PacketJob extends Job {
    constructor(bytes, options) {
        super(bytes, options);
        this.kind = "packet";
        this.deviceId = options.deviceId;
        this.due = repliesDue(bytes);
        this.replies = [];
    }

    /* True if the status packet answers this job. That to a packet that was not carried out has no parameters. */
    accepts(status) {
        const index = this.replies.length;
        const id = idDue(this.bytes, index, this.deviceId);
        const count = status.parameters.length;

        if (id !== null && status.id !== id) return false;
        return count === countDue(this.bytes, index) || ((status.error & ERRORS_OF_PACKET) !== 0 && count === 0);
    }

    take(status) {
        this.replies.push(status);
        if (this.replies.length === this.due) this.end(this.due === 1 ? status : this.replies);
    }

    takeLine() {
        return false;
    }
}

/* A READ of the first bytes of the device. Replies that came before its reply are stale. Successive
 * fences read different numbers of bytes, so the reply to one is not taken for that to another. `older`:
 * earlier fences; their late reply also counts. */
export class FenceJob extends PacketJob {
    constructor(bytes, options) {
        super(bytes, options);
        this.kind = "fence";
        this.older = options.older ?? [];
    }

    accepts(status) {
        return this.#isReply(status) || this.older.some((fence) => fence.#isReply(status));
    }

    #isReply(status) {
        return super.accepts(status) && status.error === 0 && status.parameters[0] === 0x55 && status.parameters[1] === 0xcd;
    }
}

export const END = /^(?:ok|error (\d+): ?(.*))$/;
const ALARM = /^alarm (?:(?:of servo )?\d+|of others): /;

export class LineJob extends Job {
    constructor(line, options) {
        super(new TextEncoder().encode(line + "\r"), options);
        this.kind = "line";
        this.line = line;
        this.onLine = options.onLine ?? (() => {});
        this.keepsLines = options.source !== "hand"; // `monitor` goes on for hours, and its sender takes each line
        this.lines = [];
    }

    accepts() {
        return false;
    }

    /* Takes a line of the reply. False: the line belongs to no reply, as an alarm told unasked. */
    takeLine(text) {
        const end = END.exec(text);

        if (ALARM.test(text) && !/^alarms\b/i.test(this.line)) return false;
        if (end) {
            this.end({ lines: this.lines, error: end[1] ? { number: Number(end[1]), text: end[2] } : null });
            return true;
        }
        if (this.keepsLines) this.lines.push(text);
        this.onLine(text);
        return true;
    }
}

/* `help NAME`: its reply begins with the usage of the command. A late reply to the line before it does
 * not begin so. Ctrl-C ends a command that a key ends, and drops a line that was begun. */
export class MarkerJob extends LineJob {
    constructor(name, options) {
        super(`help ${name}`, options);
        this.kind = "marker";
        this.bytes = Uint8Array.of(0x03, ...this.bytes);
        this.usage = new RegExp(`^${name}(?: .*)?: `);
        this.isSeen = false;
    }

    /* All else is dropped, too. */
    takeLine(text) {
        if (this.usage.test(text)) this.isSeen = true;
        return this.isSeen ? super.takeLine(text) : true;
    }
}
