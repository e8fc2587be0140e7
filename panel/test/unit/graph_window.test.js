// SPDX-License-Identifier: MIT
/* The window of the graphs: live, pause, zoom, move. */

import assert from "node:assert/strict";
import test from "node:test";
import { GraphWindow } from "../../src/model/graph_window.js";
import { History } from "../../src/model/history.js";

/* 100 s of samples. */
function rig() {
    const history = new History(0);
    const shown = new GraphWindow(10);
    const sample = (time) => history.take([], time * 1000);

    for (let time = 0; time <= 100; time++) sample(time);
    shown.follow(history);
    return { history, shown, sample };
}

test("live: shows the last seconds", () => {
    const { shown, sample } = rig();

    assert.deepEqual(shown.range, [90, 100]);
    sample(103);
    assert.deepEqual(shown.range, [93, 103]);
});

test("pause: keeps range and samples", () => {
    const { shown, sample, history } = rig();

    shown.pause();
    sample(103);
    assert.deepEqual(shown.range, [90, 100]);
    assert.equal(shown.history.lastTime, 100);
    shown.goOn();
    assert.equal(shown.history, history);
    assert.deepEqual(shown.range, [93, 103]);
});

test("zoom: pauses, halves, doubles, at most all samples", () => {
    const { shown } = rig();

    shown.zoomIn();
    assert.equal(shown.isPaused, true);
    assert.deepEqual(shown.range, [92.5, 97.5]);
    shown.zoomOut();
    assert.deepEqual(shown.range, [90, 100]);
    for (let count = 0; count < 9; count++) shown.zoomOut();
    assert.deepEqual(shown.range, [45, 145]);
});

test("zoom: a range that is too narrow is widened", () => {
    const { shown } = rig();

    shown.show(50, 50);
    assert.deepEqual(shown.range.map((time) => time.toFixed(2)), ["49.95", "50.05"]);
});

test("move: half of the width, within the samples", () => {
    const { shown } = rig();

    shown.move(-1);
    assert.deepEqual(shown.range, [85, 95]);
    shown.move(1);
    shown.move(1);
    assert.deepEqual(shown.range, [90, 100]);
    shown.show(2, 12);
    shown.move(-1);
    assert.deepEqual(shown.range, [0, 10]);
});

test("another connection ends the pause", () => {
    const { shown } = rig();

    shown.pause();
    shown.follow(new History(0));
    assert.equal(shown.isPaused, false);
});
