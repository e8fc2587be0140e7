// SPDX-License-Identifier: MIT
/* Help to type a line for the console. */

import assert from "node:assert/strict";
import test from "node:test";
import { LineHistory, complete, changesOwnMode, silenceOf } from "../../src/model/console_line.js";
import { tables } from "../support/tables.js";

const all = tables();

test("complete: a command, and what several share", () => {
    assert.deepEqual(complete("count", all), { line: "counters ", choices: ["counters"] });
    assert.deepEqual(complete("RES", all), { line: "res", choices: ["resume", "restore", "reset"] });
    assert.equal(complete("res", all).line, "res");
    assert.deepEqual(complete("nothing", all), { line: "nothing", choices: [] });
});

test("complete: words of a command, registers and settings", () => {
    assert.equal(complete("torque 1 of", all).line, "torque 1 off ");
    assert.equal(complete("get 1 present_t", all).line, "get 1 PRESENT_TEMPERATURE ");
    assert.equal(complete("settings cy", all).line, "settings cycle_us ");
    assert.equal(complete("help coun", all).line, "help counters ");
    assert.deepEqual(complete("get 1 cw_", all).choices.length, 3);
});

test("history: Up and Down show the lines, then the draft", () => {
    const history = new LineHistory();

    history.add("one");
    history.add("two");
    history.add("two");
    assert.equal(history.up("draft"), "two");
    assert.equal(history.up("two"), "one");
    assert.equal(history.up("one"), "one");
    assert.equal(history.down("one"), "two");
    assert.equal(history.down("two"), "draft");
    assert.equal(history.down("draft"), "draft");
});

test("history: at most 100 lines", () => {
    const history = new LineHistory();

    for (let i = 0; i < 200; i++) history.add(`line ${i}`);
    let line = "";

    for (let i = 0; i < 300; i++) line = history.up(line);
    assert.equal(line, "line 100");
});

test("changesOwnMode: lines that take mode or device of the page away", () => {
    for (const line of ["mode person", " echo on", "settings echo 2", "MODE", "defaults", "settings device_id 200", "settings host_baud 16", "save", "SAVE "]) assert.ok(changesOwnMode(line), line);
    for (const line of ["settings", "settings echo", "settings device_id", "settings host_baud", "help defaults", "help save", "settings cycle_us 4000", "move 1 90"]) assert.ok(!changesOwnMode(line), line);
});

test("silenceOf: commands that say nothing for long", () => {
    assert.ok(silenceOf("scan rescue") > 540000);
    assert.ok(silenceOf("scan") > 20000); // diagnoses up to four servos
    assert.ok(silenceOf("ping 1") < 20000);
});
