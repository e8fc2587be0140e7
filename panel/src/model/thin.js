// SPDX-License-Identifier: MIT
/* Thins out a recording: the fewest points that straight lines need to stay within an error of all samples
 * (Ramer, Douglas, Peucker, over all joints). The error of a sample is that of its worst joint, at the time
 * of the sample. A point stands at a multiple of 10 ms, the times that the board stores. */

import { positionsAt } from "./path.js";
import { TIME_STEP } from "./motions.js";

const GRID = TIME_STEP; // ms

/* Points at each multiple of 10 ms from the first sample to the last one. */
function gridOf(samples) {
    const begin = samples[0].t;
    const count = Math.max(1, Math.round((samples.at(-1).t - begin) / GRID));

    return Array.from({ length: count + 1 }, (_, index) => {
        const raw = positionsAt(samples, begin + index * GRID);

        return { t: index * GRID, raw: raw.map(Math.round) };
    });
}

/* The largest error of the line from `one` to `other` at the samples between them: {error, t}. */
function worstBetween(samples, begin, one, other) {
    let worst = { error: 0, t: NaN };

    for (const sample of samples) {
        const t = sample.t - begin;

        if (t < one.t || t > other.t) continue;
        const share = (t - one.t) / (other.t - one.t);

        for (let joint = 0; joint < one.raw.length; joint++) {
            const line = one.raw[joint] + (other.raw[joint] - one.raw[joint]) * share;
            const error = Math.abs(sample.raw[joint] - line);

            if (error > worst.error) worst = { error, t };
        }
    }
    return worst;
}

/* Indices into `grid` of the points that stay, in order. */
function keep(samples, grid, error) {
    const begin = samples[0].t;
    const kept = new Set([0, grid.length - 1]);
    const open = [[0, grid.length - 1, samples]];

    while (open.length) {
        const [first, last, within] = open.pop();
        const worst = last - first > 1 ? worstBetween(within, begin, grid[first], grid[last]) : { error: 0 };

        if (worst.error <= error) continue;
        const middle = Math.min(last - 1, Math.max(first + 1, Math.round(worst.t / GRID)));
        const cut = within.findIndex(({ t }) => t - begin >= middle * GRID);

        kept.add(middle);
        open.push([first, middle, within.slice(0, cut < 0 ? within.length : cut + 1)]);
        if (cut >= 0) open.push([middle, last, within.slice(Math.max(0, cut - 1))]);
    }
    return [...kept].sort((one, other) => one - other);
}

/* The largest error of lines through `points`, over all samples, in raw. */
export function errorOf(samples, points) {
    const begin = samples[0].t;

    return samples.reduce((largest, { t, raw }) => {
        const line = positionsAt(points, t - begin);

        return raw.reduce((most, value, joint) => Math.max(most, Math.abs(value - line[joint])), largest);
    }, 0);
}

/* Thins `samples` [{t, raw: []}] out to points within `error` (raw). Returns {points, error}: the error that
 * is reached; it is larger than asked for only if the movement bends within 10 ms. */
export function thin(samples, error) {
    const grid = gridOf(samples);
    const points = keep(samples, grid, error).map((index) => grid[index]);

    return { points, error: errorOf(samples, points) };
}

/* Thins `samples` out to at most `count` points, with the smallest error that does it. A long recording takes more
 * than a second: `breathe` is called several times, and lets the page handle Stop meanwhile. */
export async function thinTo(samples, count, breathe = () => {}) {
    let low = 0;
    let high = 1023;

    while (high - low > 0.5) {
        const middle = (low + high) / 2;

        await breathe();
        if (thin(samples, middle).points.length <= count) high = middle;
        else low = middle;
    }
    return thin(samples, high);
}
