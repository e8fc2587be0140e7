// SPDX-License-Identifier: MIT
/* Packets in words: instruction, servos, registers by name, values with units, errors.
 *
 * A status packet does not say which registers it holds: the decoder takes them from the instruction
 * packet that it answers. */

import {
    AT_INSTRUCTION,
    AT_ID,
    AT_PARAMETERS,
    FAILED,
    BROADCAST_ID,
    DEVICE_ID,
    ERRORS_OF_PACKET,
    INSTRUCTION,
    statusOf,
    toHex,
    wordAt,
} from "../wire/packet.js";
import { texts } from "../texts/texts.js";
import { textOf } from "./units.js";

const t = texts.decode;

const NAMES = new Map(Object.entries(INSTRUCTION).map(([name, code]) => [code, name.replace("_", " ")]));

export const hexByte = (value) => "0x" + value.toString(16).toUpperCase().padStart(2, "0");

/* The name of the instruction of a packet, as "SYNC READ". */
export function instructionName(bytes) {
    return NAMES.get(bytes[AT_INSTRUCTION]) ?? t.unknownInstruction(hexByte(bytes[AT_INSTRUCTION]));
}

/* The blocks [id, address, count] that an instruction packet reads or writes; `bytes`: what it writes. */
function blocksOf(packet) {
    const id = packet[AT_ID];
    const parameters = packet.slice(AT_PARAMETERS, -1);
    const [first, second] = parameters;

    switch (packet[AT_INSTRUCTION]) {
        case INSTRUCTION.READ:
            return second === undefined ? [] : [{ id, address: first, count: second }];
        case INSTRUCTION.WRITE:
        case INSTRUCTION.REG_WRITE:
            return [{ id, address: first, count: parameters.length - 1, bytes: parameters.slice(1) }];
        case INSTRUCTION.SYNC_READ:
            return Array.from(parameters.slice(2), (servo) => ({ id: servo, address: first, count: second }));
        case INSTRUCTION.SYNC_WRITE:
            return splitBytes(parameters.slice(2), second + 1).map(([servo, ...bytes]) => ({
                id: servo,
                address: first,
                count: second,
                bytes,
            }));
        case INSTRUCTION.BULK_READ:
            return splitBytes(parameters.slice(1), 3).map(([count, servo, address]) => ({ id: servo, address, count }));
        default:
            return [];
    }
}

function splitBytes(bytes, size) {
    const groups = [];

    for (let at = 0; at + size <= bytes.length; at += size) groups.push([...bytes.slice(at, at + size)]);
    return groups;
}

/* IDs of all servos that an instruction packet names. */
export function idsOf(packet) {
    const blocks = blocksOf(packet);

    return blocks.length ? blocks.map(({ id }) => id) : [packet[AT_ID]];
}

export class Decoder {
    #servo;
    #device;
    #units;

    /* `deviceId()`: the ID of the virtual device. */
    constructor(tables, deviceId = () => DEVICE_ID) {
        const byAddress = (rows) => new Map(rows.map((row) => [row.address, row]));

        this.#servo = byAddress(tables.registers);
        this.#device = byAddress(tables.device);
        this.#units = tables.units;
        this.deviceId = deviceId;
    }

    /* Registers of the servo or device `id`, by address. */
    registersOf(id) {
        return id === this.deviceId() ? this.#device : this.#servo;
    }

    /* "1", "device", "all" */
    nameOf(id) {
        if (id === BROADCAST_ID) return t.all;
        return id === this.deviceId() ? t.device : String(id);
    }

    /* An instruction packet: {name, text}. */
    instruction(packet) {
        const blocks = blocksOf(packet);
        const name = instructionName(packet);

        if (!blocks.length) return { name, text: this.#parameters(packet) };
        return { name, text: this.#isSameRead(blocks) ? this.#readOfMany(packet, blocks) : this.#textOf(blocks) };
    }

    #parameters(packet) {
        return packet.length > AT_PARAMETERS + 1 ? toHex(packet.slice(AT_PARAMETERS, -1)) : "";
    }

    /* True if a packet for many servos reads the same registers of each. */
    #isSameRead(blocks) {
        const [first] = blocks;

        return (
            blocks.length > 1 &&
            blocks.every(({ bytes, address, count }) => !bytes && address === first.address && count === first.count)
        );
    }

    #readOfMany(packet, blocks) {
        return t.ofServos(
            this.#range(blocks[0]),
            blocks.map(({ id }) => this.nameOf(id)),
        );
    }

    #textOf(blocks) {
        return blocks
            .map((block) => {
                const text = block.bytes ? this.values(block.id, block.address, block.bytes) : this.#range(block);

                return blocks.length > 1 ? t.ofServo(this.nameOf(block.id), text) : text;
            })
            .join("; ");
    }

    /* "GOAL_POSITION", "PRESENT_POSITION to PRESENT_TEMPERATURE (8 bytes)" */
    #range({ id, address, count }) {
        const rows = this.registersOf(id);
        const last = [...rows.values()].find((row) => row.address + row.bytes === address + count);
        const first = rows.get(address);

        if (!first || !last) return t.bytesFrom(count, hexByte(address));
        return first === last ? first.name : t.range(first.name, last.name, count);
    }

    /* "GOAL_POSITION 150.1°, MOVING_SPEED 20.0 rpm". A byte that begins no register: "0x13 = 0x00". */
    values(id, address, bytes) {
        const rows = this.registersOf(id);
        const parts = [];

        for (let at = 0; at < bytes.length;) {
            const row = rows.get(address + at);

            if (row && at + row.bytes <= bytes.length) {
                parts.push(`${row.name} ${this.value(id, row, bytes.slice(at, at + row.bytes))}`);
                at += row.bytes;
            } else {
                parts.push(`${hexByte(address + at)} = ${hexByte(bytes[at])}`);
                at++;
            }
        }
        return parts.join(", ");
    }

    /* The value of a register with its unit. */
    value(id, row, bytes) {
        if (row.bytes > 2) return toHex(bytes);
        const raw = row.bytes === 2 ? wordAt(bytes, 0) : bytes[0];

        if (id !== this.deviceId()) return textOf(this.#units[row.unit], raw);
        return /^\d/.test(row.unit) ? `${raw} × ${row.unit}` : `${raw} ${row.unit}`.trim();
    }

    /* A status packet: {name, text}. `request`: the instruction packet that it answers, or null; `index`:
     * how many status packets have answered it before. */
    status(packet, request = null, index = 0) {
        const { error, parameters } = statusOf(packet);
        const name = error ? t.errors(error, Boolean(error & ERRORS_OF_PACKET)) : t.ok;

        if (!request) return { name, text: t.notExpected(toHex(parameters)) };
        return { name, text: parameters.length ? this.#reply(request, parameters, index) : "" };
    }

    #reply(request, parameters, index) {
        const blocks = blocksOf(request);

        if (request[AT_INSTRUCTION] === INSTRUCTION.SYNC_READ) return this.#replyOfMany(blocks, parameters);
        const block = request[AT_INSTRUCTION] === INSTRUCTION.BULK_READ ? blocks[index] : blocks[0];

        return block && !block.bytes ? this.values(block.id, block.address, parameters) : toHex(parameters);
    }

    #replyOfMany(blocks, parameters) {
        return blocks
            .map(({ id, address, count }, index) => {
                const bytes = parameters.slice(index * count, (index + 1) * count);
                const isMissing = bytes.every((byte) => byte === FAILED);

                return t.ofServo(this.nameOf(id), isMissing ? t.noReply : this.values(id, address, bytes));
            })
            .join("; ");
    }
}
