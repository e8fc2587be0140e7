// SPDX-License-Identifier: MIT
/* Positions over time: the way that the board makes of the steps of a sequence, and a recording.
 *
 * A path is {ids, duration, at(time)}; `at` returns a raw position (a real number) for each of `ids`. The
 * formulas are those of docs/internals/motion.md: minimum jerk from pose to pose; a joint passes a pose with
 * the harmonic mean of its mean speeds before and behind it. */

import { DEGREES_MAX, RAW_MAX, RPM_MAX } from "./units.js";

/* Curves over a way; x is the part of its time, 0 to 1. A rate is the derivative of a curve. */
const minimumJerk = (x) => x * x * x * (10 - 15 * x + 6 * x * x);
const minimumJerkRate = (x) => 30 * (x - x * x) ** 2;
const brake = (x) => x - x * x * x + (x * x * x * x) / 2; // a joint comes to rest
const brakeRate = (x) => 1 - 3 * x * x + 2 * x * x * x; // from 1 to 0

const MOMENTS = Array.from({ length: 16 }, (_, index) => index / 16); // values of x at which the board checks the speed
const SPEED_MAX = ((RAW_MAX / DEGREES_MAX) * RPM_MAX * 6) / 1000; // raw values a ms at RPM_MAX; 1 rpm is 6 degrees a second
const JERK_PEAK = minimumJerkRate(1 / 2); // highest rate of minimum jerk

/* Raw positions a ms at which a joint passes the pose between two ways. */
function passingSpeed(before, behind) {
    return before * behind > 0 ? (2 * before * behind) / (before + behind) : 0;
}

/* One joint on its way from `from` to `to` in `time` ms, with these speeds (raw a ms) at its ends. */
export function positionOf({ from, to, speedBefore, speedBehind, time }, at) {
    const x = time ? at / time : 1;
    const braking = speedBefore * time;
    const passing = speedBehind * time;
    const rest = to - from - braking / 2 - passing / 2;

    return from + braking * brake(x) + passing * (0.5 - brake(1 - x)) + rest * minimumJerk(x);
}

/* The path of `steps`, from `start` (Map of ID to raw) on. `start` is the last pose of a loop, or where the
 * servos are; a joint that it does not have begins at its first pose. */
export function pathOfSequence(steps, poses, start = new Map()) {
    const ids = [...new Set(steps.flatMap(({ pose }) => [...poses.get(pose).keys()]))].sort((one, other) => one - other);
    const goals = stepGoals(ids, steps, poses, start);
    const begins = [];
    let duration = 0;

    for (const { time, dwell } of steps) {
        begins.push(duration);
        duration += time + dwell;
    }
    const ways = waysOf(steps, goals, ids);
    const at = (time) => {
        let index = steps.length - 1;

        while (index > 0 && begins[index] > time) index--;
        const within = Math.min(Math.max(time - begins[index], 0), steps[index].time);

        return ways[index].map((way) => positionOf(way, within));
    };

    return { ids, duration: steps.length ? duration : 0, begins, at: steps.length ? at : () => [] };
}

/* Positions of all joints before the first step, and at the end of each step. A joint that has no place in
 * a pose stays. */
function stepGoals(ids, steps, poses, start) {
    const firstOf = (id) => steps.map(({ pose }) => poses.get(pose).get(id)).find((raw) => raw !== undefined);
    const goals = [ids.map((id) => start.get(id) ?? firstOf(id))];

    for (const { pose } of steps) goals.push(ids.map((id, joint) => poses.get(pose).get(id) ?? goals.at(-1)[joint]));
    return goals;
}

/* Of each step, for each joint. `goals`: positions before the first step, and at the end of each. */
export function waysOf(steps, goals, ids) {
    const meanSpeed = (index, joint) => (goals[index + 1][joint] - goals[index][joint]) / steps[index].time;
    const speedAt = (index, joint) => // at the end of step `index`
        steps[index]?.passes && index + 1 < steps.length ? passingSpeed(meanSpeed(index, joint), meanSpeed(index + 1, joint)) : 0;

    return steps.map(({ time }, index) =>
        ids.map((_, joint) => ({
            from: goals[index][joint],
            to: goals[index + 1][joint],
            speedBefore: speedAt(index - 1, joint),
            speedBehind: speedAt(index, joint),
            time,
        })),
    );
}

/* The steps that are too fast for a servo: [{index, id, needed}]. `needed` is a time in ms with which the step is not too
 * fast: an upper bound. */
export function stepsTooFast(steps, poses, start = new Map()) {
    const { ids } = pathOfSequence(steps, poses, start);
    const ways = waysOf(steps, stepGoals(ids, steps, poses, start), ids);

    return steps.flatMap(({ time }, index) => {
        const times = ways[index].map(timeNeeded);
        const needed = Math.max(...times);

        return needed > time ? [{ index, id: ids[times.indexOf(needed)], needed }] : [];
    });
}

/* The time that a way needs, in ms. From rest to rest a formula gives it. If the joint moves at an end, the page tries
 * times, each 1/8 longer, until the joint is at none of MOMENTS more than 1/8 too fast. The result is an upper bound: the
 * speeds at the ends stay fixed while the time grows, but a longer step would make them lower. */
function timeNeeded({ from, to, speedBefore, speedBehind, time }) {
    if (!speedBefore && !speedBehind) return Math.ceil((Math.abs(to - from) * JERK_PEAK) / SPEED_MAX);
    const [before, behind] = [speedBefore, speedBehind].map((speed) => Math.min(Math.max(speed, -SPEED_MAX), SPEED_MAX));
    const isTooFast = (x) => {
        const rest = (to - from) / time - (before + behind) / 2;

        return Math.abs(before * brakeRate(x) + behind * brakeRate(1 - x) + rest * minimumJerkRate(x)) > SPEED_MAX * 1.125;
    };

    while (MOMENTS.some(isTooFast)) time *= 1.125;
    return time;
}

/* The path through points [{t, raw: []}], straight between them. */
export function pathOfPoints(ids, points) {
    const begin = points[0]?.t ?? 0;

    return {
        ids,
        duration: (points.at(-1)?.t ?? 0) - begin,
        at: (time) => positionsAt(points, begin + time),
    };
}

/* Positions at time `t` by straight lines between the points, which are in the order of their times. */
export function positionsAt(points, t) {
    let low = 0;
    let high = points.length - 1;

    if (t <= points[0].t) return points[0].raw;
    if (t >= points[high].t) return points[high].raw;
    while (high - low > 1) {
        const middle = (low + high) >> 1;

        if (points[middle].t <= t) low = middle;
        else high = middle;
    }
    const [one, other] = [points[low], points[high]];
    const share = (t - one.t) / (other.t - one.t);

    return one.raw.map((raw, joint) => raw + (other.raw[joint] - raw) * share);
}

/* Where the joints are at the end of the steps. */
export function lastPositions(steps, poses) {
    const all = new Map();

    for (const { pose } of steps) for (const [id, raw] of poses.get(pose)) all.set(id, raw);
    return all;
}
