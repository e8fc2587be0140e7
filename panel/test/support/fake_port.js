// SPDX-License-Identifier: MIT
/* A port to a controller that tests describe: which packets and lines it answers, and how. */

import { AT_INSTRUCTION, AT_ID, AT_LENGTH, ERROR, INSTRUCTION, isPacket, packet } from "../../src/wire/packet.js";

const DEVICE = 253;
const HELP = { id: "id OLD NEW: give a servo another ID", ping: "ping ID|254: check that a servo answers",
    stop: "stop: torque off for all servos", release: "release [ID]: allow driving again",
    scan: "scan [all|rescue]: find servos on the bus" };

/* A status packet. */
export function status(id, error = 0, parameters = []) {
    return packet(id, error, parameters);
}

export function damaged(bytes) {
    const copy = Uint8Array.from(bytes);

    copy[copy.length - 1] ^= 0xff;
    return copy;
}

export class FakePort {
    constructor() {
        this.written = []; // each write: Uint8Array
        this.isOpen = false;
        this.isMute = false; // the controller does not answer
        this.hasConsole = true;
        this.device = new Uint8Array(128);
        this.device.set([0x55, 0xcd, 0x10, DEVICE]);
        this.servos = new Map(); // ID: Uint8Array of its 50 registers
        this.offline = new Set(); // IDs of servos that do not answer
        this.refusals = new Map(); // ID: error bits that it answers to each WRITE
        this.onPacket = null; // (bytes) => true if the test has handled it
        this.onText = null; // (line) => true if the test has handled it
        this.stops = 0;
        this.loseStops = 0; // number of Ctrl-X that are lost
        this.text = "";
    }

    /* A servo as it comes from the factory, in the middle, torque off. */
    addServo(id, torque = 0) {
        const registers = new Uint8Array(50);

        registers.set([0, 1, 1, id, 1, 1, 0, 0, 0xff, 3]);
        registers[0x18] = torque;
        registers.set([0, 2, 0, 0], 0x1e);
        registers.set([0, 2, 0, 0, 0, 0, 120, 32], 0x24);
        this.servos.set(id, registers);
        return registers;
    }

    async open() {
        this.isOpen = true;
    }

    async close() {
        this.isOpen = false;
    }

    /* The cable is unplugged. */
    unplug(reason = "unplugged") {
        this.isOpen = false;
        this.onClose(reason);
    }

    write(bytes) {
        if (!this.isOpen) throw new Error("port is not open");
        this.written.push(bytes);
        if (isPacket(bytes)) this.#takePacket(bytes);
        else bytes.forEach((byte) => this.#takeText(byte));
    }

    answer(bytes) {
        queueMicrotask(() => this.isOpen && this.onBytes(bytes));
    }

    say(...lines) {
        this.answer(new TextEncoder().encode(lines.map((line) => line + "\r\n").join("")));
    }

    get packets() {
        return this.written.filter(isPacket);
    }

    /* The lines that were written, without Ctrl-C before a marker. */
    get lines() {
        return this.written.filter((bytes) => bytes[bytes.length - 1] === 0x0d && bytes.length > 1)
            .map((bytes) => new TextDecoder().decode(bytes).replace("\x03", "").trim());
    }

    #takePacket(bytes) {
        if (this.onPacket?.(bytes) || this.isMute) return;
        const memory = bytes[AT_ID] === DEVICE ? this.device : this.servos.get(bytes[AT_ID]);

        if (bytes[AT_INSTRUCTION] === INSTRUCTION.SYNC_READ) this.#syncRead(bytes);
        else if (memory && !this.offline.has(bytes[AT_ID])) this.#obey(bytes, memory);
    }

    #obey(bytes, memory) {
        const [id, instruction, address, count] = [bytes[AT_ID], bytes[AT_INSTRUCTION], bytes[5], bytes[6]];
        const refusal = instruction === INSTRUCTION.WRITE ? (this.refusals.get(id) ?? 0) : 0;

        if (instruction === INSTRUCTION.WRITE && !refusal) memory.set(bytes.slice(6, -1), address);
        if (instruction === INSTRUCTION.READ) this.answer(status(id, 0, [...memory.slice(address, address + count)]));
        else this.answer(status(id, refusal));
    }

    #syncRead(bytes) {
        const [address, count, ...ids] = bytes.slice(5, bytes[AT_LENGTH] + 3);
        const failed = new Array(count).fill(0xff);
        const isSilent = (id) => this.offline.has(id) || !this.servos.has(id);
        const values = ids.flatMap((id) => (isSilent(id) ? failed : [...this.servos.get(id).slice(address, address + count)]));

        this.answer(status(DEVICE, ids.some(isSilent) ? ERROR.SOME_FAILED : 0, values));
    }

    #takeText(byte) {
        if (byte === 0x18) {
            this.#stop();
        } else if (byte === 0x03) {
            this.text = "";
        } else if (byte === 0x0d) {
            const line = this.text;

            this.text = "";
            this.#takeLine(line);
        } else {
            this.text += String.fromCharCode(byte);
        }
    }

    #stop() {
        this.stops++;
        if (this.isMute || this.loseStops-- > 0) return;
        this.device[0x17] = 1;
        for (const registers of this.servos.values()) registers[0x18] = 0;
        if (this.hasConsole) this.say("ok");
    }

    #takeLine(line) {
        if (this.onText?.(line) || this.isMute || !this.hasConsole || !line) return;
        const help = /^help (\w+)$/.exec(line);

        if (help) this.say(HELP[help[1]], "ok");
        else if (line === "servos") this.say(...[...this.servos.keys()].map((id) => `servo ${id}: online`), "ok");
        else this.say("ok");
    }
}

