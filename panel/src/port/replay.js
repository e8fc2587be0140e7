// SPDX-License-Identifier: MIT
/* Plays a recorded session: what was written then is looked up, and answered as then. Interface:
 * web_serial.js.
 *
 * A capture is lines of text. `out HEX` is what the page wrote, `in HEX` what came, in order; a line
 * that begins with # is a comment. Each request moves the capture on. A page that asks at other times than the recorded one
 * gets the nearest answer, and at the end of the capture the last one. */

import { fromHex, toHex } from "./hex.js";
import { PortError } from "./web_serial.js";

const NEAR = 20; // steps; the page sends about 100 requests a second
const LINES_MAX = 50000; // the page saves 40400 pieces at most
const LINE_MAX = 200000; // characters: a piece of a WebSocket has 64 KB at most; with a much longer one the RegExp overflows

/* Returns [{bytes, answers}], each write with what came before the next one. The last write is left out: its answer may be cut
 * off. Throws PortError. */
export function parseCapture(text) {
    const steps = [];
    const lines = text.split(/\r?\n/);

    if (lines.length > LINES_MAX) throw new PortError("bad-capture", `it has more than ${LINES_MAX} lines`);
    lines.forEach((line, index) => {
        if (!line.trim() || line.startsWith("#")) return;
        const match = line.length <= LINE_MAX && /^(out|in) ((?:[0-9A-F]{2} *)+)$/i.exec(line.trim());

        if (!match) throw new PortError("bad-capture", `line ${index + 1}`);
        const bytes = fromHex(match[2]);

        if (match[1] === "out") steps.push({ bytes, answers: [] });
        else steps.at(-1)?.answers.push(bytes);
    });
    if (!steps.length) throw new PortError("bad-capture", "it is empty");
    return steps.length > 1 ? steps.slice(0, -1) : steps;
}

const FIRST_MIN = 400; // pieces that are kept from the start: behind the start-up the page reads limits and state of each servo
const LAST_MAX = 20000; // pieces that are kept from the end: some minutes of feedback

/* Does what `port` does, and keeps a capture: `text`. A long one has a gap behind its start, between two requests. The start
 * has all that came before endStart(): what the page asks until it knows the servos. */
export class CapturePort {
    #first = []; // {direction, bytes}
    #last = [];
    #isCut = false;
    #startLength = Infinity;

    constructor(port) {
        this.port = port;
        this.name = port.name;
        this.onBytes = () => {};
        this.onClose = () => {};
    }

    open() {
        this.port.onClose = (reason) => this.onClose(reason);
        this.port.onBytes = (bytes) => {
            this.#keep("in", bytes);
            this.onBytes(bytes);
        };
        return this.port.open();
    }

    write(bytes, isStop) {
        this.#keep("out", bytes);
        const dropped = this.port.write(bytes, isStop);

        for (const each of dropped ?? []) this.#drop(each);
        return dropped;
    }

    /* What a stop has dropped never left: it is no part of the capture. */
    #drop(bytes) {
        const isSame = (piece) => piece.bytes === bytes && !piece.isDropped;
        const piece = this.#last.findLast(isSame) ?? this.#first.findLast(isSame);

        if (piece) piece.isDropped = true;
    }

    close() {
        return this.port.close();
    }

    endStart() {
        this.#startLength = this.#first.length;
    }

    #keep(direction, bytes) {
        const isOut = (piece) => piece.direction === "out";
        const isFirst = !this.#isCut && this.#first.length < Math.max(this.#startLength, FIRST_MIN);

        (isFirst ? this.#first : this.#last).push({ direction, bytes });
        if (this.#last.length <= 2 * LAST_MAX) return;
        if (!this.#isCut) this.#first.splice(Math.max(this.#startLength, this.#first.findLastIndex(isOut)));
        this.#isCut = true;
        this.#last.splice(0, LAST_MAX);
        this.#last.splice(0, this.#last.findIndex(isOut)); // no answer without its question
    }

    get text() {
        const lines = (pieces) => pieces.map(({ direction, bytes, isDropped }) => (isDropped ? "" : `${direction} ${toHex(bytes)}\n`)).join("");

        return lines(this.#first) + (this.#isCut ? "# a part is left out here\n" : "") + lines(this.#last);
    }
}

export class ReplayPort {
    constructor(capture, { later = (call) => setTimeout(call, 0) } = {}) {
        this.steps = parseCapture(capture);
        this.name = "capture";
        this.isReplay = true; // no robot: a stop reaches nothing
        this.later = later;
        this.at = 0; // step that is expected next
        this.indices = new Map(); // of the written bytes as text: the indices of their steps, in order
        for (const [index, { bytes }] of this.steps.entries()) {
            const hex = toHex(bytes);

            if (!this.indices.has(hex)) this.indices.set(hex, []);
            this.indices.get(hex).push(index);
        }
        this.isOpen = false;
        this.onBytes = () => {};
        this.onClose = () => {};
    }

    async open() {
        this.isOpen = true;
    }

    write(bytes) {
        if (!this.isOpen) throw new PortError("not-open");
        const step = this.#find(toHex(bytes));

        if (step) this.later(() => this.#answer(step));
    }

    /* The next step from `at` on if it is near, else the one before: the capture neither jumps to its end nor begins again. */
    #find(hex) {
        const indices = this.indices.get(hex) ?? [];
        const next = indices.find((one) => one >= this.at);
        const isNear = next < this.at + NEAR;
        const index = isNear ? next : (indices.findLast((one) => one < this.at) ?? next);

        this.at = isNear ? next + 1 : this.at + 1;
        return this.steps[index];
    }

    #answer(step) {
        for (const bytes of step.answers) if (this.isOpen) this.onBytes(bytes);
    }

    async close() {
        this.isOpen = false;
    }
}
