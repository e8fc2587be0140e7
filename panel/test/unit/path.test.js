// SPDX-License-Identifier: MIT
/* The way of a sequence over time, a recording, and how it is thinned out. */

import assert from "node:assert/strict";
import test from "node:test";
import { compare, moving, Recorder } from "../../src/model/recording.js";
import { pathOfPoints, pathOfSequence, positionsAt, stepsTooFast } from "../../src/model/path.js";
import { thin, thinTo } from "../../src/model/thin.js";

const POSES = new Map([
    ["a", new Map([[1, 100], [2, 500]])],
    ["b", new Map([[1, 300], [2, 500]])],
    ["c", new Map([[1, 500]])],
]);
const step = (pose, time, more = {}) => ({ pose, time, dwell: 0, passes: false, ...more });

/* The largest error of the sequence that the board makes of `points`: at the samples, in raw. */
function boardError(all, points) {
    const poses = new Map(points.map(({ raw }, index) => [`p${index}`, new Map(raw.map((value, joint) => [joint + 1, value]))]));
    const steps = points.slice(1).map(({ t }, index) => step(`p${index + 1}`, t - points[index].t, { passes: index + 2 < points.length }));
    const path = pathOfSequence(steps, poses, poses.get("p0"));

    return Math.max(...all.flatMap(({ t, raw }) => path.at(t).map((position, joint) => Math.abs(position - raw[joint]))));
}

/* A hand that leads three servos, 50 samples a second, each a little late or early. */
function samples({ length = 4000, joints = 3 } = {}) {
    return Array.from({ length: length / 20 + 1 }, (_, index) => {
        const t = index * 20 + (index ? (index % 3) - 1 : 0);

        return { t, raw: Array.from({ length: joints }, (_, joint) => Math.round(512 + 200 * Math.sin((t / 1000) * (joint + 1)))) };
    });
}

test("sequence: stops, rests, leaves absent joints in place", () => {
    const path = pathOfSequence([step("a", 1000), step("b", 1000, { dwell: 500 }), step("c", 1000)], POSES, new Map([[1, 0], [2, 0]]));

    assert.deepEqual(path.ids, [1, 2]);
    assert.equal(path.duration, 3500);
    assert.deepEqual(path.begins, [0, 1000, 2500]);
    assert.deepEqual(path.at(0), [0, 0]);
    assert.deepEqual(path.at(1000).map(Math.round), [100, 500]);
    assert.deepEqual(path.at(1500).map(Math.round), [200, 500]);
    assert.deepEqual(path.at(2400).map(Math.round), [300, 500]);
    assert.deepEqual(path.at(9999).map(Math.round), [500, 500]);
});

test("sequence: minimum jerk, as the board", () => {
    const path = pathOfSequence([step("b", 1000)], POSES, new Map([[1, 100], [2, 500]]));

    assert.equal(path.at(250)[0].toFixed(3), (100 + 200 * (10 * 0.25 ** 3 - 15 * 0.25 ** 4 + 6 * 0.25 ** 5)).toFixed(3));
});

test("sequence: passes a pose at the board's speed, no jump", () => {
    const path = pathOfSequence([step("b", 1000, { passes: true }), step("c", 500)], POSES, new Map([[1, 100], [2, 500]]));
    const speed = (at) => (path.at(at + 0.01)[0] - path.at(at - 0.01)[0]) / 0.02;
    const harmonic = (2 * 0.2 * 0.4) / 0.6;

    assert.equal(path.at(1000)[0].toFixed(6), "300.000000");
    assert.ok(Math.abs(speed(999.9) - harmonic) < 0.005, `${speed(999.9)}`);
    assert.ok(Math.abs(speed(1000.1) - harmonic) < 0.005, `${speed(1000.1)}`);
});

test("sequence: a joint that turns back stops at the pose", () => {
    const path = pathOfSequence([step("b", 1000, { passes: true }), step("a", 1000)], POSES, new Map([[1, 100], [2, 500]]));

    assert.ok(Math.max(...Array.from({ length: 2000 }, (_, t) => path.at(t)[0])) <= 300.001);
});

test("sequence: names the servo that is too fast and its time", () => {
    const [one, ...more] = stepsTooFast([step("b", 1000), step("c", 200)], POSES, new Map([[1, 100], [2, 500]]));

    assert.deepEqual([one.index, one.id, more.length], [1, 1, 0]);
    assert.ok(one.needed > 200 && one.needed < 320, `${one.needed}`);
});

test("sequence: a servo that passes poses needs less than from rest to rest, as at the board", () => {
    const poses = new Map([0, 40, 48, 88, 98].map((raw) => [`p${raw}`, new Map([[1, raw]])]));
    const way = (time) => [step("p0", 2000), step("p40", 200, { passes: true }), step("p48", time, { passes: true }), step("p88", 200), step("p98", 10)];

    assert.deepEqual(stepsTooFast(way(10), poses).map(({ index }) => index), [4]); // 8 units in 10 ms; from rest they take 12 ms
    const [passing] = stepsTooFast(way(5), poses);

    assert.equal(passing.index, 2); // 8 units in 5 ms are faster than 62 rpm
    assert.ok(passing.needed > 5 && passing.needed <= 10, `${passing.needed}`);
});

test("points: straight between them", () => {
    const path = pathOfPoints([1], [{ t: 10, raw: [0] }, { t: 20, raw: [100] }, { t: 40, raw: [100] }]);

    assert.equal(path.duration, 30);
    assert.deepEqual([path.at(-5), path.at(5), path.at(20), path.at(99)], [[0], [50], [100], [100]]);
    assert.deepEqual(positionsAt([{ t: 0, raw: [7] }], 5), [7]);
});

test("thin: the board keeps each joint within the error at every sample", () => {
    const all = samples();

    for (const error of [2, 5, 20, 60]) {
        const { points, error: reached } = thin(all, error);

        assert.ok(reached <= error, `${reached} > ${error}`);
        assert.equal(reached.toFixed(6), boardError(all, points).toFixed(6));
        assert.ok(points.length < all.length / 2, `${points.length} points for ${error}`);
    }
});

test("thin: larger error, fewer points; times in steps of 10 ms", () => {
    const counts = [2, 10, 40].map((error) => thin(samples(), error).points.length);

    assert.ok(counts[0] > counts[1] && counts[1] > counts[2], `${counts}`);
    assert.ok(thin(samples(), 5).points.every(({ t }) => t % 10 === 0));
});

test("thin: a movement of minimum jerk needs its two ends", () => {
    const path = pathOfSequence([step("b", 1000)], POSES, new Map([[1, 100], [2, 500]]));
    const all = Array.from({ length: 51 }, (_, index) => ({ t: index * 20, raw: path.at(index * 20) }));

    assert.equal(thin(all, 1).points.length, 2);
});

test("thin: a step of one servo only is kept", () => {
    const all = samples({ joints: 2 }).map(({ t, raw }) => ({ t, raw: [512, t > 2000 && t < 2100 ? 700 : 512] }));

    assert.ok(thin(all, 10).error <= 10);
});

test("thinTo: as few points as asked for, with the error that this needs", async () => {
    let breaths = 0;
    const { points, error } = await thinTo(samples(), 8, () => breaths++);

    assert.ok(breaths > 5);

    assert.equal(points.length, 8);
    assert.equal(error.toFixed(6), boardError(samples(), points).toFixed(6));
    assert.ok(error > 5 && error < 60, `${error}`); // points for straight lines: 72
});

/* Feedback of two servos at a clock that the test moves. */
class FakeRobot extends EventTarget {
    servos = new Map([1, 2].map((id) => [id, { raw: { position: 500 }, updatedAt: -Infinity }]));

    feedback(now, positions) {
        Object.entries(positions).forEach(([id, position]) => {
            this.servos.get(Number(id)).raw.position = position;
            this.servos.get(Number(id)).updatedAt = now;
        });
        this.dispatchEvent(new Event("feedback"));
    }
}

test("recording: a sample for each round of feedback", () => {
    const robot = new FakeRobot();
    const recorder = new Recorder(robot, {});

    recorder.start([1, 2]);
    for (let round = 0; round <= 50; round++) robot.feedback(1000 + round * 20, { 1: 500 + round, 2: 500 });
    robot.feedback(2000, {}); // nothing new
    const recording = recorder.end();

    robot.feedback(3000, { 1: 1, 2: 1 });
    assert.equal(recording.samples.length, 51);
    assert.equal(recording.length, 1000);
    assert.equal(recording.rate, 50);
    assert.deepEqual(recording.samples[10], { t: 200, raw: [510, 500] });
    assert.equal(recording.missing, 0);
});

test("recording: a silent servo keeps its position, is counted", () => {
    const robot = new FakeRobot();
    const recorder = new Recorder(robot, {});

    recorder.start([1, 2]);
    robot.feedback(0, { 1: 1, 2: 2 });
    robot.feedback(20, { 1: 3 });
    const { samples: [, second], missing } = recorder.end();

    assert.deepEqual(second, { t: 20, raw: [3, 2] });
    assert.equal(missing, 1);
});

test("recording: ends by itself after two minutes", () => {
    const robot = new FakeRobot();
    const ended = [];
    const recorder = new Recorder(robot, {}, { onEnd: (recording) => ended.push(recording) });

    recorder.start([1, 2]);
    for (let t = 0; t <= 130000; t += 1000) robot.feedback(t, { 1: 1, 2: 2 });
    assert.equal(ended.length, 1);
    assert.equal(ended[0].length, 120000);
    assert.equal(recorder.isRecording, false);
});

test("compare: the largest error, its servo and the mean", () => {
    const path = pathOfPoints([1, 2], [{ t: 0, raw: [0, 0] }, { t: 100, raw: [100, 0] }]);
    const result = compare(path, [{ t: 50, raw: [40, 0] }, { t: 100, raw: [100, 30] }, { t: 500, raw: [999, 999] }]);

    assert.deepEqual([result.largest, result.joint, result.mean], [30, 1, 10]);
});

test("moving: a standstill at begin and end is cut off, noise of 1 degree is none, and nothing if all stand", () => {
    const samples = [500, 503, 500, 520, 530, 521, 531, 530, 530].map((raw, index) => ({ t: index * 20, raw: [100, raw] }));

    assert.deepEqual(moving(samples).map(({ t, raw }) => [t, raw[1]]), [[0, 500], [20, 520], [40, 530], [60, 521], [80, 531]]);
    assert.equal(moving(samples.slice(0, 3)).length, 3);
});
