// SPDX-License-Identifier: MIT
/* Separates the bytes of the controller into status packets and lines of text.
 *
 * The controller may put a status packet in the middle of a line of text; it never tears a packet
 * (docs/bridge.md). FF FF begins a packet. If no good packet begins there, the demux drops this FF and
 * examines the bytes behind it again, so damage never costs a packet or a line that follows it.
 * The demux has no clock: its owner calls silence() when no byte has come for a while. */

import {
    AT_ERROR,
    AT_ID,
    AT_LENGTH,
    HEADER,
    LENGTH_MAX,
    LENGTH_MIN,
    checksum,
    statusOf,
} from "./packet.js";

export const LINE_MAX = 4096; // characters; a longer line is cut there

const CR = 0x0d;
const LF = 0x0a;
const TAB = 0x09;
const CUT = -1; // no packet begins at this place
const MORE = 0; // a packet may begin here, its end has not come

const isText = (byte) => (byte >= 0x20 && byte < 0x7f) || byte === TAB;

/* Returns the size of the packet at the start of `bytes`, MORE or CUT. */
function sizeOfPacket(bytes) {
    if (bytes.length > 1 && bytes[1] !== HEADER) return CUT;
    if (bytes.length > AT_ID && bytes[AT_ID] === HEADER) return CUT; // more than two FF
    if (bytes.length <= AT_LENGTH) return MORE;
    const length = bytes[AT_LENGTH];

    if (length < LENGTH_MIN || length > LENGTH_MAX) return CUT;
    const size = length + AT_ERROR;

    if (bytes.length < size) return MORE;
    return checksum(bytes, AT_ID, size - 1) === bytes[size - 1] ? size : CUT;
}

export class Demux {
    /* `handlers`: onPacket(status, bytes), onLine(text), onNoise(bytes): bytes that are neither. */
    constructor({ onPacket, onLine, onNoise = () => {} }) {
        this.onPacket = onPacket;
        this.onLine = onLine;
        this.onNoise = onNoise;
        this.held = []; // bytes from an FF on
        this.text = "";
        this.noise = [];
    }

    /* True if a packet has begun whose end has not come. */
    get isWithinPacket() {
        return this.held.length > 0;
    }

    take(bytes) {
        for (const byte of bytes) this.takeByte(byte);
        this.reportNoise();
    }

    /* No byte has come for a while: an unfinished packet is none. Its bytes are examined again. */
    silence() {
        while (this.held.length) this.reject();
        this.reportNoise();
    }

    /* Forgets what has begun. */
    clear() {
        this.held = [];
        this.text = "";
        this.noise = [];
    }

    takeByte(byte) {
        if (!this.held.length && byte !== HEADER) {
            this.takeText(byte);
            return;
        }
        this.held.push(byte);
        this.examine();
    }

    examine() {
        const size = sizeOfPacket(this.held);

        if (size === CUT) {
            this.reject();
        } else if (size !== MORE) {
            const bytes = Uint8Array.from(this.held.slice(0, size));

            this.held = [];
            this.reportNoise();
            this.onPacket(statusOf(bytes), bytes);
        }
    }

    /* The held bytes begin no packet: drops the first, an FF, and examines the others again. */
    reject() {
        const [first, ...others] = this.held;

        this.held = [];
        this.noise.push(first);
        for (const byte of others) this.takeByte(byte);
    }

    takeText(byte) {
        if (byte === LF || byte === CR) {
            this.endLine();
        } else if (isText(byte) && this.text.length < LINE_MAX) {
            this.text += String.fromCharCode(byte);
        } else {
            this.noise.push(byte);
        }
    }

    /* The console ends a line with CR LF: the CR ends it, and the LF behind it has no text. A CR alone
     * moves the cursor back before text that overwrites a prompt. */
    endLine() {
        const text = this.text;

        this.text = "";
        if (text) this.onLine(text);
    }

    reportNoise() {
        if (!this.noise.length) return;
        const bytes = Uint8Array.from(this.noise);

        this.noise = [];
        this.onNoise(bytes);
    }
}
