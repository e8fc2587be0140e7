// SPDX-License-Identifier: MIT
/* Registers in units, and values that a user types. */

import assert from "node:assert/strict";
import test from "node:test";
import { rangeOf, rawAt, registerRows, shownValue, typedValue } from "../../src/model/registers.js";
import { DEVICE, REGISTER } from "../../src/wire/registers.js";
import { texts } from "../../src/texts/texts.js";
import { tables } from "../support/tables.js";

const rows = registerRows(tables());
const rowOf = (name) => rows.find((row) => row.name === name);
const shown = (name, raw) => {
    const { number, unit } = shownValue(rowOf(name), raw);

    return `${number} ${unit}`.trim();
};

test("addresses in the code are those of the tables", () => {
    const { registers, device } = tables();

    for (const [names, table] of [[REGISTER, registers], [DEVICE, device]])
        for (const [name, address] of Object.entries(names)) assert.equal(table.find((row) => row.name === name)?.address, address, name);
});

test("shownValue: values in their units", () => {
    assert.equal(shown("MIN_VOLTAGE", 65), "6.5 V");
    assert.equal(shown("GOAL_POSITION", 1023), "300.0 deg");
    assert.equal(shown("MAX_TEMPERATURE", 80), "80 C");
    assert.equal(shown("RETURN_DELAY", 4), "8 us");
    assert.equal(shown("BAUD_RATE", 1), "1000000 bps");
    assert.equal(shown("PUNCH", 90), "90");
});

test("shownValue: clockwise speed and load are negative", () => {
    assert.equal(shown("PRESENT_SPEED", 0x400 | 330), "-20.0 rpm");
    assert.equal(shown("PRESENT_LOAD", 0x7ff), "-100.0 %");
    assert.equal(shown("MOVING_SPEED", 0x400 | 330), "-20.0 rpm");
    assert.equal(shown("MOVING_SPEED", 330), "20.0 rpm");
});

test("shownValue: alarm bits have names", () => {
    assert.deepEqual(shownValue(rowOf("ALARM_LED"), 37).bits, ["input voltage", "overheating", "overload"]);
    assert.deepEqual(shownValue(rowOf("ALARM_SHUTDOWN"), 0).bits, []);
    assert.equal(shownValue(rowOf("PUNCH"), 5).bits, null);
});

test("rangeOf: in the unit, the lower end first", () => {
    assert.deepEqual(rangeOf(rowOf("MIN_VOLTAGE")), [0, 25.5]);
    assert.deepEqual(rangeOf(rowOf("CCW_ANGLE_LIMIT")), [0, 300]);
    assert.deepEqual(rangeOf(rowOf("BAUD_RATE")), [7843, 2000000]);
    assert.deepEqual(rangeOf(rowOf("MOVING_SPEED")), [0, 62]);
});

test("typedValue: in the unit or raw", () => {
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), "6.5", false), { raw: 65 });
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), " 6,5 ", false), { raw: 65 });
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), "65", true), { raw: 65 });
    assert.deepEqual(typedValue(rowOf("CCW_ANGLE_LIMIT"), "150", false), { raw: 512 });
    assert.deepEqual(typedValue(rowOf("MOVING_SPEED"), "-20", false), { raw: 0x400 | 330 });
});

test("typedValue: out of range, no number", () => {
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), "25.6", false), { problem: "outOfRange" });
    assert.deepEqual(typedValue(rowOf("CCW_ANGLE_LIMIT"), "300.1", false), { problem: "outOfRange" });
    assert.deepEqual(typedValue(rowOf("CCW_ANGLE_LIMIT"), "1024", true), { problem: "outOfRange" });
    assert.deepEqual(typedValue(rowOf("STATUS_RETURN_LEVEL"), "-1", true), { problem: "outOfRange" });
    assert.deepEqual(typedValue(rowOf("MOVING_SPEED"), "-63", false), { problem: "outOfRange" });
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), "6.5", true), { problem: "notWhole" });
    assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), "", true), { problem: "notNumber" });
    for (const text of ["much", "0x10", "1e1", "6,5,1", ".", "-"])
        assert.deepEqual(typedValue(rowOf("MIN_VOLTAGE"), text, false), { problem: "notNumber" });
});

test("typedValue: takes what shownValue shows, for every value", () => {
    for (const row of rows.filter(({ writable }) => writable))
        for (let raw = row.lowest; raw <= row.highest; raw++) {
            const { number } = shownValue(row, raw);
            const typed = typedValue(row, number, false);

            assert.ok("raw" in typed, `${row.name} ${raw}: ${number} ${typed.problem}`);
            assert.equal(shownValue(row, typed.raw).number, number, `${row.name} ${raw}`);
        }
});

test("rawAt: words have their low byte first", () => {
    const bytes = new Uint8Array(50);

    bytes.set([0xff, 3], 8);
    assert.equal(rawAt(bytes, rowOf("CCW_ANGLE_LIMIT")), 1023);
});

test("texts: each register has a help, and no help is left over", () => {
    assert.deepEqual(Object.keys(texts.registers).sort(), rows.map(({ name }) => name).sort());
    for (const name of Object.keys(texts.setup.confirmations)) assert.ok(rowOf(name)?.writable, name);
});
