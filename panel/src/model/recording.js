// SPDX-License-Identifier: MIT
/* Records where servos are, sample by sample, while a person leads them by hand: each round of feedback is a
 * sample. A servo that does not answer keeps its last position, and `missing` counts it. */

export const LENGTH_MAX_MS = 120000; // then the recording ends by itself

const STILL_RAW = 3; // 1 degree

/* The samples without the standstill at begin and end; all if nothing moves. */
export function moving(samples) {
    const movesFrom = ({ raw }) => (sample) => sample.raw.some((position, joint) => Math.abs(position - raw[joint]) > STILL_RAW);
    const first = samples.findIndex(movesFrom(samples[0])) - 1;
    const kept = first < 0 ? samples : samples.slice(first, samples.findLastIndex(movesFrom(samples.at(-1))) + 2);

    return kept.map(({ t, raw }) => ({ t: t - kept[0].t, raw }));
}

export class Recording {
    constructor(ids) {
        this.ids = ids;
        this.samples = []; // {t: ms from the start, raw: position of each of `ids`}
        this.missing = 0; // samples of a servo that did not answer
        this.isKept = false; // as a sequence or a file
    }

    get length() {
        return this.samples.at(-1)?.t ?? 0;
    }

    /* Samples a second. */
    get rate() {
        return this.length ? ((this.samples.length - 1) * 1000) / this.length : 0;
    }
}

/* `onEnd(recording)` is called when the recording ends by itself, after LENGTH_MAX_MS. */
export class Recorder {
    #robot;
    #clock;
    #begin = 0;
    #last = -Infinity; // time of the newest feedback that a sample has
    #onFeedback = () => this.#sample();

    constructor(robot, clock, { onEnd = () => {} } = {}) {
        this.#robot = robot;
        this.#clock = clock;
        this.onEnd = onEnd;
        this.recording = null;
    }

    get isRecording() {
        return this.recording !== null;
    }

    start(ids) {
        this.recording = new Recording([...ids]);
        this.#begin = NaN;
        this.#last = -Infinity;
        this.#robot.addEventListener("feedback", this.#onFeedback);
    }

    /* Returns the recording. */
    end() {
        const { recording } = this;

        this.#robot.removeEventListener("feedback", this.#onFeedback);
        this.recording = null;
        return recording;
    }

    #sample() {
        const { recording } = this;
        const servos = recording.ids.map((id) => this.#robot.servos.get(id));
        const newest = Math.max(...servos.map((servo) => servo?.updatedAt ?? -Infinity));

        if (newest <= this.#last) return; // no servo has answered since
        const before = recording.samples.at(-1)?.raw;
        const raw = servos.map((servo, index) => (this.#isNew(servo) ? servo.raw.position : before?.[index]));

        recording.missing += servos.filter((servo) => !this.#isNew(servo)).length;
        this.#last = newest;
        if (raw.includes(undefined)) return; // a servo has never answered
        if (Number.isNaN(this.#begin)) this.#begin = newest;
        recording.samples.push({ t: newest - this.#begin, raw });
        if (recording.length >= LENGTH_MAX_MS) this.onEnd(this.end());
    }

    #isNew(servo) {
        return servo?.updatedAt > this.#last;
    }
}

/* How well `replayed`, samples with the joints of `path`, follows `path`: differences at the times of
 * `replayed`, in raw: {largest, mean, joint, samples}. `joint` is the index of the worst one. */
export function compare(path, replayed) {
    let largest = 0;
    let sum = 0;
    let count = 0;
    let joint = 0;

    for (const { t, raw } of replayed) {
        if (t < 0 || t > path.duration) continue;
        path.at(t).forEach((position, index) => {
            const error = Math.abs(raw[index] - position);

            if (error > largest) [largest, joint] = [error, index];
            sum += error;
            count++;
        });
    }
    return { largest, mean: count ? sum / count : 0, joint, samples: replayed.length };
}
