// SPDX-License-Identifier: MIT
/* Backup of servos as a JSON file, and what a restore of it would change.
 *
 * {"format": "cds55xx-backup", "version": 1, "page": "0.1.0", "saved": "2026-01-31T12:00:00.000Z",
 *  "servos": [{"id": 1, "model": 1, "firmware": 1, "registers": {"RETURN_DELAY": 1, ...}}]}
 *
 * A file holds all writable EEPROM registers except ID and BAUD_RATE: a restore never changes where a servo
 * answers. Values are raw. STATUS_RETURN_LEVEL is written last: at 0 a servo does not answer
 * the READ that checks a write. */

import { ID_MAX } from "../wire/packet.js";
import { Failure, rawAt, valueText } from "./registers.js";

export const FORMAT = "cds55xx-backup";
export const VERSION = 1;
export const SIZE_MAX = 1000000; // characters of a file; 254 servos take a tenth
const LAST = "STATUS_RETURN_LEVEL";
const KEPT_OUT = new Set(["ID", "BAUD_RATE"]);
const CW = "CW_ANGLE_LIMIT";
const CCW = "CCW_ANGLE_LIMIT";
const GOAL = "GOAL_POSITION";

const damaged = (detail) => new Failure("backup-damaged", { detail });

/* The rows that a backup has, in the order in which a restore writes them. */
export function backedUp(rows) {
    const kept = rows.filter((row) => row.area === "EEPROM" && row.writable && !KEPT_OUT.has(row.name));

    return [...kept.filter(({ name }) => name !== LAST), ...kept.filter(({ name }) => name === LAST)];
}

const valueNamed = (rows, bytes, name) => rawAt(bytes, rows.find((row) => row.name === name));

/* The entry of a servo in a file. `bytes`: its registers from 0 on. */
export function entryOf(rows, id, bytes) {
    return {
        id,
        model: valueNamed(rows, bytes, "MODEL_NUMBER"),
        firmware: valueNamed(rows, bytes, "FIRMWARE_VERSION"),
        registers: Object.fromEntries(backedUp(rows).map((row) => [row.name, rawAt(bytes, row)])),
    };
}

export function textOfBackup(servos, { page, saved }) {
    return JSON.stringify({ format: FORMAT, version: VERSION, page, saved, servos }, null, 1) + "\n";
}

/* ---- reading a file ---- */

const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);
const isWithin = (value, lowest, highest) => Number.isInteger(value) && value >= lowest && value <= highest;

/* Returns the entries of a file. Throws Failure with a code `backup-...`. */
export function readBackup(text, rows) {
    if (text.length > SIZE_MAX) throw new Failure("backup-foreign");
    const file = parsed(text);

    if (!isObject(file) || file.format !== FORMAT) throw new Failure("backup-foreign");
    if (file.version !== VERSION) throw new Failure("backup-version", { found: Number.isFinite(file.version) ? file.version : "?", known: VERSION });
    if (!Array.isArray(file.servos) || !file.servos.length) throw damaged("it names no servo");
    file.servos.forEach((entry) => checkEntry(entry, rows));
    checkIds(file.servos.map(({ id }) => id));
    return file.servos;
}

function parsed(text) {
    try {
        return JSON.parse(text);
    } catch {
        if (text.includes(`"${FORMAT}"`)) throw damaged("its text is cut off or changed");
        throw new Failure("backup-foreign");
    }
}

function checkIds(ids) {
    const twice = ids.find((id, index) => ids.indexOf(id) !== index);

    if (twice !== undefined) throw damaged(`servo ${twice} stands in it twice`);
}

function checkEntry(entry, rows) {
    if (!isObject(entry) || !isWithin(entry.id, 0, ID_MAX)) throw damaged("a servo has no ID");
    const { id, model, registers } = entry;

    if (!isWithin(model, 0, 255)) throw damaged(`servo ${id} has no model number`);
    if (!isObject(registers)) throw damaged(`servo ${id} has no registers`);
    const wanted = backedUp(rows);
    const unknown = Object.keys(registers).find((name) => !wanted.some((row) => row.name === name));

    if (unknown !== undefined) throw damaged(`servo ${id} has a register ${unknown.slice(0, 30)}, which no backup has`);
    for (const row of wanted) {
        if (!(row.name in registers)) throw damaged(`servo ${id} lacks the register ${row.name}`);
        if (!isWithin(registers[row.name], row.lowest, row.highest))
            throw damaged(`servo ${id}: ${row.name} is not a number from ${row.lowest} to ${row.highest}`);
    }
    checkOrder(id, registers, rows);
}

/* Throws Failure if a limit of `values` would make a lower limit greater than the upper one. `bytes`: the registers of
 * the servo, with the limits that `values` lacks. */
function checkOrder(id, values, rows, bytes) {
    const pairs = [[CW, CCW], ["MIN_VOLTAGE", "MAX_VOLTAGE"]];
    const valueOf = (name) => values[name] ?? valueNamed(rows, bytes, name);
    const told = (name) => `${name} (${valueText(rows.find((row) => row.name === name), valueOf(name))})`;
    const crossed = pairs.find(([low, high]) => (low in values || high in values) && valueOf(low) > valueOf(high));

    if (crossed) throw new Failure("backup-crossed", { id, low: told(crossed[0]), high: told(crossed[1]) });
}

/* ---- what a restore would change ---- */

/* The entries for the servo `id`, or all if `id` is null. */
export function entriesFor(entries, id) {
    if (id === null) return entries;
    const own = entries.filter((entry) => entry.id === id);

    if (!own.length) throw new Failure("backup-other-id", { id, ids: entries.map((entry) => entry.id) });
    return own;
}

/* Throws Failure if limits of `values` would be crossed, or if the servo has torque, and angle limits of `values` would
 * move it: limits that exclude its goal, or limits that begin or end endless turn. `bytes`: the registers of the servo. */
export function checkLimits(id, bytes, rows, values) {
    checkOrder(id, values, rows, bytes);
    const before = { [CW]: valueNamed(rows, bytes, CW), [CCW]: valueNamed(rows, bytes, CCW) };
    const [low, high] = [values[CW] ?? before[CW], values[CCW] ?? before[CCW]];
    const goal = valueNamed(rows, bytes, GOAL);
    const isEndless = high === 0;
    const moves = isEndless !== (before[CCW] === 0) || (!isEndless && (goal < low || goal > high));

    if (!valueNamed(rows, bytes, "TORQUE_ENABLE") || (low === before[CW] && high === before[CCW])) return;
    if (moves) throw new Failure("limits-move", { id });
}

/* The registers that differ: [{row, now, file}]. `bytes`: the registers of the servo. */
export function differences(entry, bytes, rows) {
    const model = valueNamed(rows, bytes, "MODEL_NUMBER");

    if (model !== entry.model) throw new Failure("backup-other-model", { id: entry.id, model: entry.model, found: model });
    const changes = backedUp(rows)
        .map((row) => ({ row, now: rawAt(bytes, row), file: entry.registers[row.name] }))
        .filter(({ now, file }) => now !== file);

    checkLimits(entry.id, bytes, rows, entry.registers);
    return changes;
}
