// SPDX-License-Identifier: MIT
/* Poses and sequences as lines of the console, the format of files too:
 *
 *     group 1 2 3
 *     pose set left 448raw 576raw 512raw
 *     sequence wave new left 0.8s dwell 0.5s
 *     sequence wave add middle 0.4s pass
 *
 * `pose show` and `sequence show` print such lines, and the board takes them. */

import { ID_MAX } from "../wire/packet.js";
import { MotionError, Motions, NAMES_MAX, STEPS_MAX } from "./motions.js";
import { DEGREES_MAX, RAW_MAX } from "./units.js";

/* ---- to lines ---- */

/* "1.2s" */
export const textOfTime = (ms) => `${Number((ms / 1000).toFixed(2))}s`;

export function linesOfPose(name, pose) {
    return [`group ${[...pose.keys()].join(" ")}`, `pose set ${name} ${[...pose.values()].map((raw) => `${raw}raw`).join(" ")}`];
}

export function linesOfSequence(name, steps) {
    return steps.map(({ pose, time, dwell, passes }, index) => {
        const more = passes ? " pass" : dwell ? ` dwell ${textOfTime(dwell)}` : "";

        return `sequence ${name} ${index ? "add" : "new"} ${pose} ${textOfTime(time)}${more}`;
    });
}

/* All lines, poses first. A group that serves several poses stands once. */
export function linesOfMotions({ poses, sequences }) {
    const lines = [];
    let group = "";

    for (const [name, pose] of poses) {
        const [needed, set] = linesOfPose(name, pose);

        if (needed !== group) lines.push(needed);
        group = needed;
        lines.push(set);
    }
    for (const [name, steps] of sequences) lines.push(...linesOfSequence(name, steps));
    return lines;
}

/* ---- from lines ---- */

const NO_LINE = "it is no line of a pose or a sequence";
const UNITS = { "": 1, deg: 1, mdeg: 0.001 };
const TIMES = { s: 1000, ms: 1 };

/* Each reading function returns undefined for what it cannot read. */
function readAngle(word) {
    const [, number, unit] = /^(\d+(?:\.\d+)?)(raw|deg|mdeg|)$/.exec(word.toLowerCase()) ?? [];
    const raw = unit === "raw" ? Number(number) : Math.round((number * UNITS[unit] * RAW_MAX) / DEGREES_MAX);

    return Number.isInteger(raw) && raw >= 0 && raw <= RAW_MAX ? raw : undefined;
}

function readTime(word = "") {
    const [, number, unit] = /^(\d+(?:\.\d+)?)(s|ms)$/.exec(word.toLowerCase()) ?? [];

    return unit && Math.round(number * TIMES[unit] * 1000) / 1000;
}

/* "1 2 5-7" */
function readIds(words) {
    if (words.length > 254) return undefined; // each word may stand for 254 IDs
    const ids = words.flatMap((word) => {
        const [, first, last = first] = /^(\d+)(?:-(\d+))?$/.exec(word) ?? [];
        const count = Number(last) - Number(first) + 1;

        return count > 0 && count <= ID_MAX + 1 ? Array.from({ length: count }, (_, index) => Number(first) + index) : [NaN];
    });

    return ids.length && ids.every((id) => id <= ID_MAX) && new Set(ids).size === ids.length ? ids : undefined;
}

class Reader {
    constructor(keywords) {
        this.motions = new Motions({ keywords });
        this.group = [];
        this.gone = new Set(); // names of sequences that name a deleted pose
    }

    /* Takes a line. Throws MotionError, or a text that says what is wrong. */
    take(line) {
        const words = line.split(/\s+/);
        const [first, second] = words.map((word) => word.toLowerCase());

        if (first === "group") this.#takeGroup(words.slice(1));
        else if (first === "pose" && second === "set") this.#takePose(words[2] ?? "", words.slice(3));
        else if (first === "sequence") this.#takeStep(words.slice(1));
        else throw NO_LINE;
        if (this.motions.poses.size + this.motions.sequences.size > NAMES_MAX) throw `the file has more than ${NAMES_MAX} poses and sequences`;
    }

    #takeGroup(words) {
        const last = words.at(-1)?.toLowerCase();
        const ids = readIds(last === "sync" || last === "action" ? words.slice(0, -1) : words);

        if (!ids) throw "its IDs cannot be read";
        this.group = ids;
    }

    #takePose(name, words) {
        const raw = words.map(readAngle);

        if (raw.includes(undefined)) throw "an angle cannot be read";
        if (!this.group.length) throw "no line “group” stands before it";
        if (raw.length !== this.group.length) throw `it has ${raw.length} angles for a group of ${this.group.length} servos`;
        this.motions.setPose(name, this.group.map((id, index) => [id, raw[index]]));
    }

    #takeStep([name = "", verb = "", pose = "", timeWord, ...more]) {
        const time = readTime(timeWord);
        const isNew = verb.toLowerCase() === "new";
        const [word, dwellWord] = more.map((text) => text.toLowerCase());
        const dwell = word === "dwell" ? readTime(dwellWord) : 0;
        const isKnown = !more.length || (word === "pass" && more.length === 1) || (word === "dwell" && more.length === 2);

        if (verb.toLowerCase() === "step" || pose === "-") this.gone.add(name); // the pose is deleted
        if (this.gone.has(name)) return;
        if (!isNew && verb.toLowerCase() !== "add") throw NO_LINE;
        if (time === undefined || dwell === undefined || !isKnown) throw "its times cannot be read";
        const before = isNew ? [] : (this.motions.sequences.get(name) ?? []);

        if (before.length === STEPS_MAX) throw `the sequence has more than ${STEPS_MAX} steps`;
        this.motions.setSequence(name, [...before, { pose, time, dwell, passes: word === "pass" }]);
    }
}

/* Reads lines. Returns {motions, gone}; `gone`: names of sequences with a deleted pose, which are left out.
 * Throws MotionError, as "motion-file" {line, why}. A line that begins with # is a
 * comment. A copy from the terminal may have prompts and "ok". */
export function readMotions(text, { keywords = new Set() } = {}) {
    const reader = new Reader(keywords);

    text.split(/\r?\n/).forEach((line, index) => {
        const command = line.replace(/^> ?/, "").trim();

        if (/^(#.*|ok|)$/.test(command)) return;
        try {
            reader.take(command);
        } catch (error) {
            if (error instanceof MotionError) throw Object.assign(error, { line: index + 1 });
            if (typeof error !== "string") throw error;
            throw new MotionError("motion-file", { line: index + 1, why: error });
        }
    });
    for (const name of reader.gone) reader.motions.sequences.delete(name);
    reader.motions.check();
    reader.motions.isChanged = false;
    return { motions: reader.motions, gone: [...reader.gone] };
}

export function textOfMotions(motions) {
    return linesOfMotions(motions).map((line) => `${line}\n`).join("");
}
