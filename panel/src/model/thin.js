// SPDX-License-Identifier: MIT
/* Thins out a recording to points that the board passes as the poses of a sequence. The error of a sample is that of its
 * worst joint, at the time of the sample, on the way of the board (model/path.js). A point stands at a multiple of 10 ms,
 * the times that the board stores. */

import { TIME_STEP } from "./motions.js";
import { positionOf, positionsAt, waysOf } from "./path.js";

const ROUNDS = 20;
const MOVES = [16, -16, 4, -4, 1, -1]; // of a point, in steps of 10 ms

const largestOf = (worst) => Math.max(...worst.map(({ error }) => error));

class Points {
    /* `samples`: [{t, raw: []}], the first at 0 ms. */
    constructor(samples) {
        this.samples = samples;
        const steps = Math.max(1, Math.round(samples.at(-1).t / TIME_STEP));

        this.points = [this.#pointAt(0), this.#pointAt(steps * TIME_STEP)];
        this.worst = []; // of the way that begins at each point: {error, t}
        this.#judge(0);
    }

    get thinned() {
        return { points: this.points, error: largestOf(this.worst) };
    }

    #pointAt(t) {
        return { t, raw: positionsAt(this.samples, t).map(Math.round) };
    }

    /* The ways that point `index` changes: its neighbours are passed at other speeds. */
    #near(index) {
        return [Math.max(0, index - 2), Math.min(index + 2, this.points.length - 1)];
    }

    #judge(index) {
        const { points } = this;
        const steps = points.slice(1).map(({ t }, way) => ({ time: t - points[way].t, passes: true }));
        const ways = waysOf(steps, points.map(({ raw }) => raw), points[0].raw);

        for (let [way, end] = this.#near(index); way < end; way++) this.worst[way] = this.#worstOf(ways[way], points[way].t, points[way + 1].t);
    }

    #worstOf(joints, begin, end) {
        let worst = { error: 0, t: begin };

        for (const { t, raw } of this.samples) {
            if (t < begin) continue;
            if (t > end) break;
            joints.forEach((joint, index) => {
                const error = Math.abs(raw[index] - positionOf(joint, t - begin));

                if (error > worst.error) worst = { error, t };
            });
        }
        return worst;
    }

    /* Adds a point where the error is largest. False: it is at most `error`, or there is no place. */
    add(error) {
        const { points, worst } = this;
        const open = worst.filter((each, way) => each.error > error && points[way + 1].t - points[way].t > TIME_STEP);

        if (!open.length) return false;
        const most = largestOf(open);
        const way = worst.indexOf(open.find((each) => each.error === most));
        const t = Math.round(worst[way].t / TIME_STEP) * TIME_STEP;

        points.splice(way + 1, 0, this.#pointAt(Math.min(Math.max(t, points[way].t + TIME_STEP), points[way + 1].t - TIME_STEP)));
        worst.splice(way, 0, null);
        this.#judge(way + 1);
        return true;
    }

    /* Moves point `index` in time. False: the error near it would not be smaller. */
    move(index, steps) {
        const { points } = this;
        const before = points[index];
        const worst = [...this.worst];
        const t = before.t + steps * TIME_STEP;

        if (t <= points[index - 1].t || t >= points[index + 1].t) return false;
        points[index] = this.#pointAt(t);
        this.#judge(index);
        if (largestOf(this.worst.slice(...this.#near(index))) < largestOf(worst.slice(...this.#near(index)))) return true;
        points[index] = before;
        this.worst = worst;
        return false;
    }
}

/* Thins `samples` out to points within `error` (raw). Returns {points, error}: the error that is reached; it is larger than
 * asked for only if the movement bends within 10 ms. */
export function thin(samples, error) {
    const points = new Points(samples);

    while (points.add(error));
    return points.thinned;
}

/* Thins `samples` out to `count` points, and moves these while that makes the error smaller. A long recording takes
 * seconds: `breathe` is called for each point, and lets the page handle Stop meanwhile. */
export async function thinTo(samples, count, breathe = () => {}) {
    const points = new Points(samples);
    let isBetter = true;

    while (points.points.length < count && points.add(0));
    for (let round = 0; isBetter && round < ROUNDS; round++) {
        isBetter = false;
        for (let index = 1; index < points.points.length - 1; index++) {
            await breathe();
            for (const steps of MOVES) isBetter = points.move(index, steps) || isBetter;
        }
    }
    return points.thinned;
}
