// SPDX-License-Identifier: MIT
/* The registers of a servo: their rows out of the tables, values in units, and reading and writing them. */

import { ERRORS_OF_PACKET, errorNames, ping, read, word, wordAt, write } from "../wire/packet.js";
import { texts } from "../texts/texts.js";
import { rawOf, typedNumber, valueOf, withUnit } from "./units.js";

export const TABLE_SIZE = 50; // bytes
const BITS = new Set(["ALARM_LED", "ALARM_SHUTDOWN"]); // conditions, as the error bits of a packet
const SPEED = "MOVING_SPEED";
const RETURN_LEVEL = "STATUS_RETURN_LEVEL";
const ERROR_NO_REPLY = 2;
const ERROR_DAMAGED = 3;
const ERROR_NONE_DUE = 10; // at the STATUS_RETURN_LEVEL of the servo
/* Errors of the console after which the register may have its value. */
const MAY_BE_WRITTEN = new Set([ERROR_NO_REPLY, ERROR_DAMAGED, ERROR_NONE_DUE]);
const SPEED_MAX = 1023; // raw; above, the speed has a direction: endless turn

/* What went wrong, for session.attempt(): `code` names a text of texts.notice. */
export class Failure extends Error {
    constructor(code, details = {}) {
        super(code);
        this.name = "Failure";
        this.code = code;
        Object.assign(this, details);
    }
}

/* The rows of the table, each with its unit. */
export function registerRows(tables) {
    return tables.registers.map((row) => ({ ...row, scale: tables.units[row.unit] ?? tables.units.NUMBER, isBits: BITS.has(row.name) }));
}

export function rawAt(bytes, row) {
    return row.bytes === 2 ? wordAt(bytes, row.address) : bytes[row.address];
}

/* The unit of a value: a speed of endless turn has a sign. */
function scaleOf(row, raw) {
    return row.name === SPEED && raw > SPEED_MAX ? { ...row.scale, signed: true } : row.scale;
}

/* {number: "6.5", unit: "V", bits: names of the set bits or null} */
export function shownValue(row, raw) {
    const scale = scaleOf(row, raw);

    return { number: valueOf(scale, raw).toFixed(scale.digits), unit: scale.name, bits: row.isBits ? errorNames(raw) : null };
}

export function valueText(row, raw) {
    const { number, unit, bits } = shownValue(row, raw);

    if (bits) return bits.join(", ") || texts.setup.noBits;
    if (row.highest === 1 && !row.scale.name) return texts.setup.onOff[raw] ?? number;
    return withUnit(number, unit);
}

/* Lowest and highest value in the unit of the register. */
export function rangeOf(row) {
    const ends = [row.lowest, row.name === SPEED ? SPEED_MAX : row.highest].map((raw) => Number(valueOf(row.scale, raw).toFixed(row.scale.digits)));

    return ends.sort((one, other) => one - other);
}

/* What a user typed, in the unit of the register or raw. Returns {raw}, or {problem}: a code of texts.setup. */
export function typedValue(row, text, isRaw) {
    const number = typedNumber(text);

    if (Number.isNaN(number)) return { problem: "notNumber" };
    if (isRaw && !Number.isInteger(number)) return { problem: "notWhole" };
    const raw = isRaw ? number : rawInUnit(row, number);

    return raw >= row.lowest && raw <= row.highest ? { raw } : { problem: "outOfRange" };
}

/* A value outside of the range in units must not become one inside by rounding, as 300.1 degrees. */
function rawInUnit(row, number) {
    const [lowest, highest] = rangeOf(row);
    const isSigned = row.name === SPEED && number < 0;

    if (isSigned) return -number > highest ? Infinity : rawOf({ ...row.scale, signed: true }, number);
    return number < lowest || number > highest ? Infinity : rawOf(row.scale, number);
}

/* ---- on the wire ---- */

/* The parameters of a reply. Throws Failure if the servo, or the device, has not carried the packet out. */
export function parametersOf(id, { error, parameters }) {
    if (error & ERRORS_OF_PACKET) throw new Failure("refused", { id, why: errorNames(error & ERRORS_OF_PACKET).join(", ") });
    return parameters;
}

/* Sends a packet to a servo. Returns the parameters of its reply; throws Failure or WireError. */
async function ask(wire, id, bytes, options) {
    try {
        return parametersOf(id, await wire.request(bytes, options));
    } catch (error) {
        throw error.code === "timeout" ? new Failure("servo-silent", { id }) : error;
    }
}

/* Reads registers of a servo. `options`: as of wire.request(). Throws Failure or WireError. */
export const readRegisters = (wire, id, address = 0, count = TABLE_SIZE, options = {}) => ask(wire, id, read(id, address, count), options);

/* Writes bytes to registers of a servo, from `address` on. `options`: as of wire.request(). Throws Failure or WireError. */
export const writeRegisters = (wire, id, address, bytes, options = {}) => ask(wire, id, write(id, address, bytes), options);

/* True if the servo answers PING only with this value, so that nothing can be read back. */
export const silences = (row, raw) => row.name === RETURN_LEVEL && raw === 0;

/* Writes a register, by the console if there is one: it says why it refuses. Returns the value that the
 * register has then, or null: it cannot be read back. Throws Failure, CommandError or WireError. */
export async function writeRegister(controller, id, row, raw) {
    const { wire } = controller;
    let failure = null;

    try {
        if (wire.hasConsole) await controller.order(`set ${id} ${row.name} ${raw}raw`);
        else await writeByPacket(wire, id, row, raw);
    } catch (error) {
        if (!MAY_BE_WRITTEN.has(error.number)) throw error;
        failure = error;
    }
    const now = await readBack(wire, id, row, raw).catch((error) => {
        throw error.code === "servo-silent" ? (failure ?? error) : error;
    });

    if (now !== null && now !== raw) throw failure ?? new Failure("register-not-taken", { id, register: row.name, wanted: raw, now });
    return now;
}

/* A servo that its new level silences still answers PING. Returns null for it. */
async function readBack(wire, id, row, raw) {
    try {
        return rawAt(await readAround(wire, id, row), row);
    } catch (error) {
        if (!silences(row, raw) || error.code !== "servo-silent") throw error;
        await ask(wire, id, ping(id));
        return null;
    }
}

/* The bytes of a register, at their addresses. */
async function readAround(wire, id, row) {
    const bytes = new Uint8Array(TABLE_SIZE);

    bytes.set(await readRegisters(wire, id, row.address, row.bytes), row.address);
    return bytes;
}

/* A reply that is lost is no failure: the register is read back. */
async function writeByPacket(wire, id, row, raw) {
    try {
        await writeRegisters(wire, id, row.address, row.bytes === 2 ? word(raw) : [raw]);
    } catch (error) {
        if (error.code !== "servo-silent") throw error;
    }
}
