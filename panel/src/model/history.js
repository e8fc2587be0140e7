// SPDX-License-Identifier: MIT
/* What the servos did in the last minutes: a ring of samples, one for each feedback of all servos. A
 * value is kept as its register value, so 50 servos take 18 MB. */

import { degreesOf, percentOf, rpmOf, voltsOf } from "./units.js";

export const CAPACITY = 30000; // samples: 5 minutes at 100 a second
export const GAP_MS = 500; // a longer time without a sample is a gap in the line
const MISSING = -1;
const same = (raw) => raw;

/* `digits` and `unit` are for texts and for the names of columns. */
export const QUANTITIES = Object.freeze({
    position: { convert: degreesOf, digits: 1, unit: "deg" },
    goal: { convert: degreesOf, digits: 1, unit: "deg" },
    speed: { convert: rpmOf, digits: 1, unit: "rpm" },
    load: { convert: percentOf, digits: 1, unit: "percent" },
    voltage: { convert: voltsOf, digits: 1, unit: "V" },
    temperature: { convert: same, digits: 0, unit: "C" },
});

const NAMES = Object.keys(QUANTITIES);

export class History {
    #capacity;
    #times; // ms of the clock
    #columns = new Map(); // of ID: {position: Int16Array, ...}
    #end = 0; // number of samples since the start

    constructor(start, { capacity = CAPACITY } = {}) {
        this.start = start; // ms of the clock
        this.#capacity = capacity;
        this.#times = new Float64Array(capacity);
    }

    /* Number of the oldest sample that is kept. */
    get first() {
        return Math.max(0, this.#end - this.#capacity);
    }

    /* Number of the newest sample + 1. */
    get end() {
        return this.#end;
    }

    get ids() {
        return [...this.#columns.keys()].sort((one, other) => one - other);
    }

    /* Seconds since the start. */
    timeOf(sample) {
        return (this.#times[sample % this.#capacity] - this.start) / 1000;
    }

    get lastTime() {
        return this.#end ? this.timeOf(this.#end - 1) : 0;
    }

    get firstTime() {
        return this.#end ? this.timeOf(this.first) : 0;
    }

    /* The value of a sample in its unit; null: there is none. */
    valueOf(id, quantity, sample) {
        const raw = this.#columns.get(id)?.[quantity][sample % this.#capacity] ?? MISSING;

        return raw === MISSING ? null : QUANTITIES[quantity].convert(raw);
    }

    /* Takes a sample. A servo that has no newer values than the last sample gets none. */
    take(servos, now) {
        const slot = this.#end % this.#capacity;
        const before = this.#end ? this.#times[(this.#end - 1) % this.#capacity] : -Infinity;

        for (const columns of this.#columns.values()) for (const name of NAMES) columns[name][slot] = MISSING;
        for (const servo of servos) {
            if (servo.presence !== "online" || servo.updatedAt <= before) continue;
            const columns = this.#columnsOf(servo.id);

            for (const name of NAMES) columns[name][slot] = servo.raw[name] ?? MISSING;
        }
        this.#times[slot] = now;
        this.#end++;
    }

    #columnsOf(id) {
        if (!this.#columns.has(id)) {
            const make = (name) => [name, new Int16Array(this.#capacity).fill(MISSING)];

            this.#columns.set(id, Object.fromEntries(NAMES.map(make)));
        }
        return this.#columns.get(id);
    }

    /* A history that stays as this one is now. */
    copy() {
        const copy = new History(this.start, { capacity: this.#capacity });

        copy.#times = this.#times.slice();
        copy.#end = this.#end;
        for (const [id, columns] of this.#columns)
            copy.#columns.set(id, Object.fromEntries(NAMES.map((name) => [name, columns[name].slice()])));
        return copy;
    }

    /* Number of the first sample at or behind `time`, in seconds. */
    sampleAt(time) {
        let [low, high] = [this.first, this.#end];

        while (low < high) {
            const middle = (low + high) >> 1;

            if (this.timeOf(middle) < time) low = middle + 1;
            else high = middle;
        }
        return low;
    }

    /* Lines to draw: [times, values of the first of `series`, ...]. `series`: [{id, quantity}]. If there
     * are more samples than `points`, each pair of points is the minimum and the maximum of several samples. */
    lines(series, from, to, points) {
        const first = Math.max(this.first, this.sampleAt(from) - 1);
        const end = Math.min(this.#end, this.sampleAt(to) + 1);
        const size = Math.max(1, Math.ceil((2 * (end - first)) / points));
        const lines = [[], ...series.map(() => [])];
        let before = null;

        for (let at = first; at < end; ) {
            const next = Math.min(end, size === 1 ? at + 1 : (Math.floor(at / size) + 1) * size);

            if (before !== null && this.timeOf(at) - before > GAP_MS / 1000) this.#addGap(lines, before);
            this.#addPoints(lines, series, at, next);
            before = this.timeOf(next - 1);
            at = next;
        }
        return lines;
    }

    #addGap([times, ...values], before) {
        times.push(before + GAP_MS / 2000);
        for (const line of values) line.push(null);
    }

    #addPoints([times, ...values], series, at, next) {
        const isPair = next - at > 1;

        times.push(this.timeOf(at));
        if (isPair) times.push(this.timeOf(next - 1));
        series.forEach(({ id, quantity }, index) => {
            if (isPair) values[index].push(...this.#extremes(id, quantity, at, next));
            else values[index].push(this.valueOf(id, quantity, at));
        });
    }

    /* The least and the greatest value, in the order in which they came. */
    #extremes(id, quantity, at, next) {
        let [least, greatest, isRising] = [null, null, true];

        for (let sample = at; sample < next; sample++) {
            const value = this.valueOf(id, quantity, sample);

            if (value === null) continue;
            if (least === null || value < least) [least, isRising] = [value, false];
            if (greatest === null || value > greatest) [greatest, isRising] = [value, true];
        }
        return isRising ? [least, greatest] : [greatest, least];
    }

    /* All samples from `from` to `to` as comma-separated values, with a line of names. */
    csv(series, from, to) {
        const names = series.map(({ id, quantity }) => `servo_${id}_${quantity}_${QUANTITIES[quantity].unit}`);
        const rows = [["time_s", ...names].join(",")];

        for (let sample = this.sampleAt(from); sample < this.#end && this.timeOf(sample) <= to; sample++) {
            const values = series.map(({ id, quantity }) => this.valueOf(id, quantity, sample)?.toFixed(QUANTITIES[quantity].digits) ?? "");

            rows.push([this.timeOf(sample).toFixed(3), ...values].join(","));
        }
        return rows.join("\r\n") + "\r\n";
    }
}
