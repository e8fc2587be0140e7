// SPDX-License-Identifier: MIT
/* Register values and what they mean. The rows are `units` of the generated tables; `raw` is the value
 * of the register. */

import { texts } from "../texts/texts.js";

export const RAW_MAX = 1023; // full scale of position (300 degrees), speed, load and torque
export const DEGREES_MAX = 300;
export const RPM_MAX = 62;
const CW_BIT = 0x400; // bit of a signed register: clockwise
export const BAUD_CLOCK = 2000000; // bit/s at raw 0

/* The number that a user typed, with a point or a comma; NaN: it is none. A field of the type `number` would drop the comma
 * of another language at the key press: 1,5 became 15. */
export const typedNumber = (text) => (/^[+-]?(?:\d+[.,]?\d*|[.,]\d+)$/.test(text.trim()) ? Number(text.trim().replace(",", ".")) : NaN);

export const degreesOf = (raw) => (raw * DEGREES_MAX) / RAW_MAX;
export const rawOfDegrees = (degrees) =>
    Math.min(RAW_MAX, Math.max(0, Math.round((degrees * RAW_MAX) / DEGREES_MAX)));

/* At least 1: the register value 0 means "as fast as it can". */
export const rawOfRpm = (rpm) => Math.min(RAW_MAX, Math.max(1, Math.round((rpm * RAW_MAX) / RPM_MAX)));

/* A speed of endless turn: more than 0 is counterclockwise, 0 stands. */
export const rawOfTurn = (rpm) => (rpm === 0 ? 0 : rawOfRpm(Math.abs(rpm)) | (rpm < 0 ? CW_BIT : 0));
export const rpmOf = (raw) => (signed(raw) * RPM_MAX) / RAW_MAX;
export const percentOf = (raw) => (signed(raw) * 100) / RAW_MAX;
export const voltsOf = (raw) => raw / 10;

function signed(raw) {
    return raw & CW_BIT ? -(raw & (CW_BIT - 1)) : raw;
}

/* The number that `raw` means in the unit `row`. */
export function valueOf(row, raw) {
    if (row.name === "bps") return Math.round(BAUD_CLOCK / (raw + 1));
    return ((row.signed ? signed(raw) : raw) * row.per) / row.of;
}

/* The raw value nearest to `value` in the unit `row`. */
export function rawOf(row, value) {
    if (row.name === "bps") return Math.round(BAUD_CLOCK / value) - 1;
    const magnitude = Math.round((Math.abs(value) * row.of) / row.per);

    return value < 0 && row.signed ? magnitude | CW_BIT : magnitude;
}

/* A unit as the page writes it. `name`: as the console writes it. */
export const unitText = (name) => texts.units[name] ?? name;

export function withUnit(number, name) {
    const unit = unitText(name);

    return unit === "°" ? number + unit : `${number} ${unit}`.trim();
}

/* "150.1°" */
export const textOf = (row, raw) => withUnit(valueOf(row, raw).toFixed(row.digits), row.name);
