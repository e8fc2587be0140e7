// SPDX-License-Identifier: MIT
/* Backup files: what they have, what a restore changes, and files that are refused. */

import assert from "node:assert/strict";
import test from "node:test";
import { SIZE_MAX, backedUp, differences, entriesFor, entryOf, readBackup, textOfBackup } from "../../src/model/backup.js";
import { registerRows } from "../../src/model/registers.js";
import { noticeText } from "../../src/texts/texts.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const rows = registerRows(tables());
const registersWith = (id) => new FakePort().addServo(id);
const entry = (id = 1) => entryOf(rows, id, registersWith(id));
const textOf = (...servos) => textOfBackup(servos, { page: "0.1.0", saved: "2026-01-31T12:00:00.000Z" });

/* The text of the failure of `call`, as the user sees it. */
function refusalOf(call) {
    try {
        call();
    } catch (error) {
        return noticeText({ ...error }).text;
    }
    return "taken";
}

/* The failure of readBackup(text), as the user sees it. */
function refusal(text) {
    try {
        readBackup(text, rows);
    } catch (error) {
        assert.equal(error.name, "Failure", error.stack);
        const { text: what, remedy } = noticeText({ ...error });

        assert.match(what, /Nothing was written/);
        assert.ok(remedy);
        return `${error.code}: ${error.detail ?? ""}`;
    }
    return "taken";
}

/* The text of a file that `change` has changed. */
function changed(change) {
    const file = JSON.parse(textOf(entry()));

    change(file, file.servos[0]);
    return JSON.stringify(file);
}

test("entryOf: writable registers in EEPROM, without ID and rate", () => {
    const { id, model, registers } = entry(7);

    assert.deepEqual([id, model], [7, 1]);
    assert.equal(registers.CCW_ANGLE_LIMIT, 1023);
    assert.equal(registers.RETURN_DELAY, 1);
    for (const name of ["ID", "BAUD_RATE", "TORQUE_ENABLE", "GOAL_POSITION", "LOCK", "MODEL_NUMBER"]) assert.ok(!(name in registers), name);
});

test("backedUp: the status return level is written last", () => {
    assert.equal(backedUp(rows).at(-1).name, "STATUS_RETURN_LEVEL");
});

test("readBackup: reads what textOfBackup wrote", () => {
    assert.deepEqual(readBackup(textOf(entry(1), entry(2)), rows), [entry(1), entry(2)]);
});

test("readBackup: a damaged file is refused", () => {
    const text = textOf(entry());

    assert.match(refusal(text.slice(0, -20)), /backup-damaged: its text is cut off or changed/);
    assert.match(refusal(changed((file) => (file.servos = []))), /backup-damaged: it names no servo/);
    assert.match(refusal(changed((file) => (file.servos = "1"))), /backup-damaged: it names no servo/);
    assert.match(refusal(changed((file) => file.servos.push(file.servos[0]))), /servo 1 stands in it twice/);
    assert.match(refusal(changed((file) => file.servos.push(null))), /a servo has no ID/);
    assert.match(refusal(changed((file, servo) => (servo.id = 254))), /a servo has no ID/);
    assert.match(refusal(changed((file, servo) => delete servo.model)), /servo 1 has no model number/);
    assert.match(refusal(changed((file, servo) => (servo.registers = []))), /servo 1 has no registers/);
    assert.match(refusal(changed((file, servo) => delete servo.registers.MIN_VOLTAGE)), /servo 1 lacks the register MIN_VOLTAGE/);
    assert.match(refusal(changed((file, servo) => (servo.registers.MIN_VOLTAGE = 256))), /MIN_VOLTAGE is not a number from 0 to 255/);
    assert.match(refusal(changed((file, servo) => (servo.registers.MIN_VOLTAGE = "60"))), /MIN_VOLTAGE is not a number/);
    assert.match(refusal(changed((file, servo) => (servo.registers.MIN_VOLTAGE = 60.5))), /MIN_VOLTAGE is not a number/);
    assert.match(refusal(changed((file, servo) => (servo.registers.GOAL_POSITION = 5))), /has a register GOAL_POSITION, which no backup has/);
    assert.match(refusal(changed((file, servo) => (servo.registers.ID = 5))), /has a register ID, which no backup has/);
});

test("readBackup: crossed limits are refused with both values", () => {
    const crossed = (values) => refusalOf(() => readBackup(changed((file, servo) => Object.assign(servo.registers, values)), rows));

    assert.equal(crossed({ CW_ANGLE_LIMIT: 682, CCW_ANGLE_LIMIT: 341 }), "Servo 1: CW_ANGLE_LIMIT (200.0°) would be above CCW_ANGLE_LIMIT (100.0°). Nothing was written.");
    assert.equal(crossed({ MIN_VOLTAGE: 120, MAX_VOLTAGE: 119 }), "Servo 1: MIN_VOLTAGE (12.0 V) would be above MAX_VOLTAGE (11.9 V). Nothing was written.");
    assert.equal(crossed({ CW_ANGLE_LIMIT: 341, CCW_ANGLE_LIMIT: 341 }), "taken");
    assert.equal(crossed({ CW_ANGLE_LIMIT: 0, CCW_ANGLE_LIMIT: 0 }), "taken");
});

test("readBackup: each cut of a file is refused", () => {
    const text = textOf(entry()).trimEnd();

    for (let length = 0; length < text.length; length++) assert.match(refusal(text.slice(0, length)), /backup-(damaged|foreign)/);
});

test("readBackup: another file, another version", () => {
    assert.match(refusal(""), /backup-foreign/);
    assert.match(refusal("null"), /backup-foreign/);
    assert.match(refusal("[1, 2]"), /backup-foreign/);
    assert.match(refusal('{"format": "poses"}'), /backup-foreign/);
    assert.match(refusal("restore 1 MIN_VOLTAGE 6V"), /backup-foreign/);
    assert.match(refusal(textOf(entry()) + " ".repeat(SIZE_MAX)), /backup-foreign/);
    assert.match(refusal(changed((file) => (file.version = 2))), /backup-version/);
    assert.match(refusal(changed((file) => delete file.version)), /backup-version/);
    assert.match(refusal(changed((file) => (file.version = { toString: 1, valueOf: 1 }))), /backup-version/);
    assert.match(refusal(textOf(entry()).replace('"version": 1', `"version": ${"[".repeat(5000)}${"]".repeat(5000)}`)), /backup-version/);
});

test("entriesFor: a servo out of the file, or all", () => {
    const entries = [entry(1), entry(2)];

    assert.deepEqual(entriesFor(entries, 2), [entry(2)]);
    assert.deepEqual(entriesFor(entries, null), entries);
    assert.throws(() => entriesFor(entries, 3), { code: "backup-other-id", id: 3, ids: [1, 2] });
});

test("differences: only registers that differ", () => {
    const bytes = registersWith(1);
    const saved = entry();

    assert.deepEqual(differences(saved, bytes, rows), []);
    bytes[0x0c] = 65;
    bytes.set([0, 2], 8);
    bytes[0x1e] = 99; // GOAL_POSITION
    assert.deepEqual(
        differences(saved, bytes, rows).map(({ row, now, file }) => [row.name, now, file]),
        [
            ["CCW_ANGLE_LIMIT", 512, 1023],
            ["MIN_VOLTAGE", 65, 0],
        ],
    );
});

test("differences: a servo of another model is refused", () => {
    const bytes = registersWith(1);

    bytes[1] = 9;
    assert.throws(() => differences(entry(), bytes, rows), { code: "backup-other-model", id: 1, model: 1, found: 9 });
});

test("differences: limits that move a servo with torque are refused", () => {
    const refused = noticeText({ code: "limits-move", id: 1 }).text;
    const restored = (low, high, { torque = 1, now = [0, 1023] } = {}) => {
        const bytes = registersWith(1); // goal: 512
        const saved = entry();

        bytes[0x18] = torque;
        bytes.set(now.flatMap((limit) => [limit & 0xff, limit >> 8]), 6);
        Object.assign(saved.registers, { CW_ANGLE_LIMIT: low, CCW_ANGLE_LIMIT: high });
        return refusalOf(() => differences(saved, bytes, rows));
    };

    assert.equal(restored(600, 1023), refused);
    assert.equal(restored(0, 300), refused);
    assert.equal(restored(512, 512), "taken");
    assert.equal(restored(0, 0), refused, "into endless turn");
    assert.equal(restored(0, 1023, { now: [0, 0] }), refused, "out of endless turn");
    assert.equal(restored(0, 0, { now: [0, 0] }), "taken");
    assert.equal(restored(0, 0, { torque: 0 }), "taken");
    assert.equal(restored(600, 1023, { torque: 0 }), "taken");
    assert.equal(restored(600, 1023, { now: [600, 1023] }), "taken", "the restore changes no limit");
});
