// SPDX-License-Identifier: MIT
/* The history of the servos: ring, gaps, lines to draw, comma-separated values. */

import assert from "node:assert/strict";
import test from "node:test";
import { History } from "../../src/model/history.js";

const POSITION = [{ id: 1, quantity: "position" }];

/* A servo with a value of feedback that came at `now`. */
const servo = (id, position, now, more = {}) => ({
    id,
    presence: "online",
    updatedAt: now,
    raw: { position, goal: 512, speed: 0x400 | 33, load: 0, voltage: 118, temperature: 40 },
    ...more,
});

/* Samples each 10 ms; `positionAt(index)` gives raw positions. */
function filled(count, positionAt, options) {
    const history = new History(1000, options);

    for (let index = 0; index < count; index++) history.take([servo(1, positionAt(index), 1000 + index * 10)], 1000 + index * 10);
    return history;
}

test("values: in their units, with time since the start", () => {
    const history = filled(3, () => 341);

    assert.equal(history.end, 3);
    assert.equal(history.lastTime, 0.02);
    assert.equal(history.valueOf(1, "position", 2), 100);
    assert.equal(history.valueOf(1, "speed", 2), -2);
    assert.equal(history.valueOf(1, "voltage", 2), 11.8);
    assert.equal(history.valueOf(1, "temperature", 2), 40);
    assert.equal(history.valueOf(2, "position", 2), null);
});

test("ring: the oldest samples are dropped", () => {
    const history = filled(25, (index) => index, { capacity: 10 });

    assert.equal(history.first, 15);
    assert.equal(history.firstTime, 0.15);
    assert.equal(history.lines(POSITION, 0, 10, 100)[0].length, 10);
    assert.equal(history.lines(POSITION, 0, 10, 100)[1][0], (15 * 300) / 1023);
});

test("ring: a servo that does not answer, or left, has no values", () => {
    const history = new History(0, { capacity: 4 });

    for (let round = 1; round <= 6; round++) {
        const one = servo(1, 100, round < 4 ? round : 3, { presence: round < 6 ? "online" : "offline" });

        history.take([one, ...(round === 2 ? [servo(2, 200, 2)] : [])], round);
    }
    assert.deepEqual([2, 3, 4, 5].map((sample) => history.valueOf(1, "position", sample) !== null), [true, false, false, false]);
    assert.deepEqual([2, 3, 4, 5].map((sample) => history.valueOf(2, "position", sample)), [null, null, null, null]);
});

test("lines: of many samples the least and the greatest stay", () => {
    const history = filled(10000, (index) => (index === 5003 ? 1023 : index === 7007 ? 0 : 512));
    const [times, values] = history.lines(POSITION, 0, 100, 400);

    assert.ok(times.length <= 402, `${times.length} points`);
    assert.equal(times.length, values.length);
    assert.equal(Math.max(...values), 300);
    assert.equal(Math.min(...values), 0);
    assert.ok(times.every((time, index) => index === 0 || time >= times[index - 1]));
});

test("lines: a time without samples is a gap", () => {
    const history = filled(3, () => 100);

    history.take([servo(1, 100, 3000)], 3000);
    const [times, values] = history.lines(POSITION, 0, 10, 100);

    assert.deepEqual(values.map((value) => value !== null), [true, true, true, false, true]);
    assert.equal(times[4], 2);
});

test("lines: only the samples of the window, and one beside it", () => {
    const [times] = filled(100, () => 100).lines(POSITION, 0.2, 0.3, 1000);

    assert.equal(times[0], 0.19);
    assert.equal(times.at(-1), 0.3);
});

test("copy: stays as it is", () => {
    const history = filled(5, () => 100, { capacity: 5 });
    const copy = history.copy();

    history.take([servo(1, 900, 2000)], 2000);
    assert.equal(copy.end, 5);
    assert.equal(copy.valueOf(1, "position", 0), (100 * 300) / 1023);
});

test("csv: a line of names, then each sample; nothing for no value", () => {
    const history = filled(3, () => 341);
    const text = history.csv([...POSITION, { id: 1, quantity: "load" }, { id: 9, quantity: "goal" }], 0.01, 0.02);

    assert.equal(text, "time_s,servo_1_position_deg,servo_1_load_percent,servo_9_goal_deg\r\n0.010,100.0,0.0,\r\n0.020,100.0,0.0,\r\n");
});
