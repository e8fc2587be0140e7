// SPDX-License-Identifier: MIT
/* Builds a packet from what a user has typed. Throws ComposeError: what is typed makes no packet. */

import {
    AT_ID,
    AT_LENGTH,
    AT_PARAMETERS,
    BROADCAST_ID,
    HEADER,
    ID_MAX,
    INSTRUCTION,
    LENGTH_MAX,
    LENGTH_MIN,
    bulkRead,
    checksum,
    fromHex,
    packet,
    read,
    syncRead,
    syncWrite,
    word,
} from "../wire/packet.js";
import { rawOf, unitText } from "./units.js";
import { hexByte } from "./decode.js";

/* `code` names an entry of texts.packets.malformed. */
export class ComposeError extends Error {
    constructor(code, detail = {}) {
        super(code);
        this.name = "ComposeError";
        this.code = code;
        this.detail = detail;
    }
}

const fail = (code, detail) => {
    throw new ComposeError(code, detail);
};

/* A packet from hexadecimal bytes. FF FF at the start and the checksum at the end may be left out. */
export function packetOfHex(text) {
    let bytes;

    try {
        bytes = [...fromHex(text)];
    } catch {
        fail("hex", { text });
    }
    if (bytes[0] !== HEADER || bytes[1] !== HEADER) bytes.unshift(HEADER, HEADER);
    if (bytes.length < AT_PARAMETERS) fail("short");
    const length = bytes[AT_LENGTH];

    if (bytes[AT_ID] > BROADCAST_ID) fail("id", { id: bytes[AT_ID], max: BROADCAST_ID });
    if (length < LENGTH_MIN || length > LENGTH_MAX) fail("length", { length });
    const size = length + 4;

    if (bytes.length === size - 1) bytes.push(checksum(bytes));
    if (bytes.length !== size) fail("size", { length, right: bytes.length - 4, rightWithout: bytes.length - 3 });
    const right = checksum(bytes, AT_ID, size - 1);

    if (bytes[size - 1] !== right) fail("checksum", { is: hexByte(bytes[size - 1]), right: hexByte(right) });
    return Uint8Array.from(bytes);
}

/* Returns the IDs of a list such as "1-3,5". */
export function idsOfText(text, max = ID_MAX) {
    const ids = [];

    for (const part of text.split(/[\s,]+/).filter((word) => word)) {
        const match = /^(\d+)(?:-(\d+))?$/.exec(part) ?? fail("ids", { text: part });
        const [first, last] = [Number(match[1]), Number(match[2] ?? match[1])];

        if (last > max) fail("id", { id: last, max });
        if (last < first) fail("ids", { text: part });
        for (let id = first; id <= last; id++) ids.push(id);
    }
    if (!ids.length) fail("no-ids");
    if (new Set(ids).size !== ids.length) fail("ids-twice");
    return ids;
}

/* The bytes of `text` for a register: "150", "150deg", "512raw", "0x200". Without unit: the unit of the
 * register. `unit`: its row of the units, or null: a number. */
function bytesOfValue(text, row, unit) {
    const match = /^(0x[0-9a-f]+|-?\d+(?:\.\d+)?)\s*([a-z%°/]*)$/i.exec(text) ?? fail("value", { text, name: row.name });
    const [, number, suffix] = match;
    const isRaw = /^0x/i.test(number) || suffix.toLowerCase() === "raw" || !unit?.name;
    const known = ["", "raw", unit?.name.toLowerCase(), unitText(unit?.name)?.toLowerCase()];

    if (!known.includes(suffix.toLowerCase())) fail("unit", { text, name: row.name, unit: unitText(unit?.name ?? "") });
    const raw = isRaw ? Number(number) : rawOf(unit, Number(number));

    if (!Number.isInteger(raw) || raw < 0 || raw > 256 ** row.bytes - 1 || (Number(number) < 0 && (isRaw || !unit.signed)))
        fail("fit", { text, name: row.name });
    return row.bytes === 1 ? [raw] : word(raw);
}

/* The bytes of "150, 20" for the registers from `address` on. */
export function bytesOfValues(text, address, registers, units) {
    const bytes = [];

    for (const part of text.split(",").map((value) => value.trim())) {
        const row = registers.get(address + bytes.length) ?? fail("no-register", { address: hexByte(address + bytes.length) });

        if (!part) fail("value", { text: part, name: row.name });
        bytes.push(...bytesOfValue(part, row, units[row.unit] ?? null));
    }
    return bytes;
}

/* What a form has: {instruction, ids: text, address, count, values: text, hex: text}. `decoder` knows the
 * registers; `units` of the tables. */
export function compose(form, decoder, units) {
    const { instruction, address, count, values } = form;

    if (instruction === "hex") return packetOfHex(form.hex);
    const code = INSTRUCTION[instruction];
    const isMany = code >= INSTRUCTION.SYNC_WRITE;
    const ids = idsOfText(form.ids, isMany ? ID_MAX : BROADCAST_ID);

    if (!isMany && ids.length > 1) fail("one-id");
    const write = (text, id) => bytesOfValues(text, address, decoder.registersOf(id), units);

    if (isMany) return composeForMany(code, form, ids, write);
    if (code === INSTRUCTION.READ) return read(ids[0], address, count);
    if (code === INSTRUCTION.WRITE || code === INSTRUCTION.REG_WRITE)
        return packet(ids[0], code, [address, ...write(values, ids[0])]);
    return packet(ids[0], code);
}

/* SYNC WRITE: values for each servo stand between semicolons; a single group is for all. */
function composeForMany(code, { address, count, values }, ids, write) {
    try {
        if (code === INSTRUCTION.SYNC_READ) return syncRead(address, count, ids);
        if (code === INSTRUCTION.BULK_READ) return bulkRead(ids.map((id) => [count, id, address]));
        const groups = values.split(";");

        if (groups.length !== 1 && groups.length !== ids.length) fail("groups", { groups: groups.length, ids: ids.length });
        const blocks = ids.map((id, index) => [id, write(groups[index] ?? groups[0], id)]);

        return syncWrite(address, blocks[0][1].length, blocks);
    } catch (error) {
        if (error instanceof RangeError) fail("too-long", { why: error.message });
        throw error;
    }
}
