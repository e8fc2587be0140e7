// SPDX-License-Identifier: MIT
/* Poses and sequences of the page, with the rules that the board has for them (docs/motion.md). A position
 * is raw, a time in ms. What breaks a rule throws MotionError; its code names an entry of texts.notice. */

import { RAW_MAX } from "./units.js";

export const NAME_MAX = 8; // characters
export const JOINTS_MAX = 18; // of all poses together
export const NAMES_MAX = 500; // poses and sequences of a file: the page renders a row of each
export const STEPS_MAX = 16;
export const TIME_MIN = 10; // ms, of a step
export const TIME_MAX = 600000;
export const DWELL_MAX = 65530;
export const TIME_STEP = 10; // ms: the board stores multiples of it

const RECORDED = /^rec\d+x\d+$/; // name of a pose that a recording has made

export class MotionError extends Error {
    constructor(code, detail = {}) {
        super(code);
        this.name = "MotionError";
        Object.assign(this, detail, { code });
    }
}

/* The words of all commands, and those that begin the last line of a reply: no pose and no sequence may have such a name. */
export function keywordsOf(tables) {
    const words = tables.commands.flatMap(({ usage }) => usage.replace(/[[\]]/g, "").split(" "));

    return new Set(["ok", "error", ...words.filter((word) => /^[a-z]/.test(word)).flatMap((word) => word.replace(/\.+$/, "").split("|"))]);
}

/* Throws MotionError if the board does not take `name`. */
export function checkName(name, keywords) {
    if (!/^[A-Za-z][A-Za-z0-9]{0,7}$/.test(name) || keywords.has(name.toLowerCase())) throw new MotionError("motion-name", { detail: name });
}

/* Throws unless `time` is a multiple of 10 ms from `min` to `max`. */
function checkTime(time, min, max, detail) {
    if (!(time >= min && time <= max && Number.isInteger(time / TIME_STEP))) throw new MotionError("motion-time", { detail });
}

/* A step: {pose, time, dwell, passes}; the way to the pose takes `time`. */
export function stepOf({ pose, time = 1000, dwell = 0, passes = false }) {
    return { pose, time, dwell: passes ? 0 : dwell, passes };
}

export class Motions {
    constructor({ keywords = new Set() } = {}) {
        this.keywords = keywords;
        this.poses = new Map(); // of name: Map of ID to raw position
        this.sequences = new Map(); // of name: array of steps
        this.isChanged = false; // since it was loaded, stored or saved
    }

    get isEmpty() {
        return !this.poses.size && !this.sequences.size;
    }

    /* IDs of all poses. */
    get joints() {
        return [...new Set([...this.poses.values()].flatMap((pose) => [...pose.keys()]))].sort((one, other) => one - other);
    }

    /* ---- poses ---- */

    setPose(name, positions) {
        checkName(name, this.keywords);
        const pose = new Map([...positions].sort(([one], [other]) => one - other));

        for (const [id, raw] of pose)
            if (!Number.isInteger(raw) || raw < 0 || raw > RAW_MAX)
                throw new MotionError("motion-angle", { detail: `${name}, servo ${id}` });
        this.poses.set(name, pose);
        this.isChanged = true;
    }

    setAngle(name, id, raw) {
        this.setPose(name, new Map([...this.poses.get(name), [id, raw]]));
    }

    /* Takes a servo out of a pose, but not the last one. */
    removeJoint(name, id) {
        this.setPose(name, [...this.poses.get(name)].filter(([other]) => other !== id));
    }

    renamePose(from, to) {
        if (from === to) return;
        if (this.poses.has(to)) throw new MotionError("motion-twice", { detail: to });
        checkName(to, this.keywords);
        this.poses = new Map([...this.poses].map(([name, pose]) => [name === from ? to : name, pose]));
        for (const steps of this.sequences.values())
            for (const step of steps) if (step.pose === from) step.pose = to;
        this.isChanged = true;
    }

    /* A pose that a sequence needs stays: a sequence without one of its poses does not play. */
    deletePose(name) {
        const users = this.#usersOf(name);

        if (users.length) throw new MotionError("motion-pose-used", { detail: name, users });
        this.poses.delete(name);
        this.isChanged = true;
    }

    #usersOf(pose) {
        return [...this.sequences.keys()].filter((name) => this.sequences.get(name).some((step) => step.pose === pose));
    }

    /* A name that is free: `stem` and a number. */
    freeName(stem, taken = this.poses) {
        for (let number = 1; ; number++) {
            const name = `${stem.slice(0, NAME_MAX - String(number).length)}${number}`;

            if (!taken.has(name)) return name;
        }
    }

    /* ---- sequences ---- */

    setSequence(name, steps) {
        checkName(name, this.keywords);
        this.#checkSteps(name, steps);
        this.sequences.set(name, steps.map(stepOf));
        this.isChanged = true;
    }

    #checkSteps(name, steps) {
        if (steps.length > STEPS_MAX) throw new MotionError("motion-steps", { detail: name, count: steps.length });
        steps.forEach(({ pose, time, dwell = 0 }, index) => {
            const where = `${name}, step ${index + 1}`;

            if (!this.poses.has(pose)) throw new MotionError("motion-no-pose", { detail: where, pose });
            checkTime(time, TIME_MIN, TIME_MAX, where);
            checkTime(dwell, 0, DWELL_MAX, where);
        });
    }

    changeStep(name, index, change) {
        this.setSequence(name, this.sequences.get(name).map((step, at) => (at === index ? { ...step, ...change } : step)));
    }

    addStep(name, step) {
        this.setSequence(name, [...(this.sequences.get(name) ?? []), stepOf(step)]);
    }

    removeStep(name, index) {
        this.setSequence(name, this.sequences.get(name).filter((_, at) => at !== index));
    }

    /* Moves a step by one place; `by` is 1 or -1. False: there is no place. */
    moveStep(name, index, by) {
        const steps = [...this.sequences.get(name)];
        const to = index + by;

        if (to < 0 || to >= steps.length) return false;
        [steps[index], steps[to]] = [steps[to], steps[index]];
        this.setSequence(name, steps);
        return true;
    }

    renameSequence(from, to) {
        if (from === to) return;
        if (this.sequences.has(to)) throw new MotionError("motion-twice", { detail: to });
        checkName(to, this.keywords);
        this.sequences = new Map([...this.sequences].map(([name, steps]) => [name === from ? to : name, steps]));
        this.isChanged = true;
    }

    /* The poses of a recording go with the last sequence that has them. */
    deleteSequence(name) {
        const steps = this.sequences.get(name);

        this.sequences.delete(name);
        for (const { pose } of steps) if (RECORDED.test(pose) && !this.#usersOf(pose).length) this.poses.delete(pose);
        this.isChanged = true;
    }

    /* ---- all of it ---- */

    /* Throws MotionError if the board cannot take it: too many servos, a sequence without a step. */
    check() {
        const { joints } = this;

        if (joints.length > JOINTS_MAX) throw new MotionError("motion-joints", { count: joints.length });
        for (const [name, steps] of this.sequences)
            if (!steps.length) throw new MotionError("motion-no-steps", { detail: name });
    }

    /* Only `sequence`, and the poses that it needs. */
    partOf(sequence) {
        const part = new Motions({ keywords: this.keywords });
        const steps = this.sequences.get(sequence);

        for (const { pose } of steps) part.poses.set(pose, this.poses.get(pose));
        part.sequences.set(sequence, steps.map(stepOf));
        return part;
    }
}
