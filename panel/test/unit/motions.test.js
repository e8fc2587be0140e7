// SPDX-License-Identifier: MIT
/* Poses and sequences of the page, and their text: names, times, rules of the board. */

import assert from "node:assert/strict";
import test from "node:test";
import { Motions, keywordsOf } from "../../src/model/motions.js";
import { noticeText } from "../../src/texts/texts.js";
import { linesOfMotions, readMotions, textOfMotions } from "../../src/model/motion_text.js";
import { tables } from "../support/tables.js";

const TEXT = `# taught by hand
group 1 2 3
pose set left 448raw 576raw 512raw
pose set middle 512raw 512raw 512raw
group 7
pose set arm 90deg
sequence wave new left 0.8s
sequence wave add middle 0.4s pass
sequence wave add left 800ms dwell 0.5s
`;

const code = (call) => {
    try {
        call();
    } catch (error) {
        return error.code;
    }
    return "none";
};

function motions() {
    return readMotions(TEXT, { keywords: keywordsOf(tables()) }).motions;
}

test("text: lines of the console become poses and sequences", () => {
    const { poses, sequences, isChanged } = motions();

    assert.deepEqual([...poses.get("left")], [[1, 448], [2, 576], [3, 512]]);
    assert.deepEqual([...poses.get("arm")], [[7, 307]]);
    assert.deepEqual(sequences.get("wave"), [
        { pose: "left", time: 800, dwell: 0, passes: false },
        { pose: "middle", time: 400, dwell: 0, passes: true },
        { pose: "left", time: 800, dwell: 500, passes: false },
    ]);
    assert.equal(isChanged, false);
});

test("text: what is written is read again", () => {
    const again = readMotions(textOfMotions(motions())).motions;

    assert.deepEqual(again.poses, motions().poses);
    assert.deepEqual(again.sequences, motions().sequences);
});

test("text: a line of 18 servos fits into the buffers of the board", () => {
    const all = new Motions();

    all.setPose("abcdefgh", Array.from({ length: 18 }, (_, id) => [id + 200, 1023]));
    assert.ok(linesOfMotions(all).every((line) => line.length <= 180));
});

test("text: a copy from the terminal has prompts and ok", () => {
    assert.equal(textOfMotions(readMotions(TEXT.replace(/^(.*)$/gm, "> $1\nok\n> ")).motions), textOfMotions(motions()));
});

test("text: a damaged file names its line", () => {
    for (const [line, why] of [
        ["pose set a 1 2 3 4", /4 angles for a group of 1/],
        ["pose set a x", /an angle/],
        ["pose set a 301", /an angle/],
        ["group 1 1", /IDs/],
        ["group 1 254", /IDs/],
        ["sequence wave add left 0.8", /times/],
        ["sequence wave add left 0.8s dwell", /times/],
        ["sequence wave add left 0.8s twice", /times/],
        ["sequence wave put left 0.8s", /no line of a pose/],
        ["torque 1 on", /no line of a pose/],
        ["ÿþ\u0000", /no line of a pose/],
    ])
        assert.throws(() => readMotions(`${TEXT}${line}\n`), (error) => error.code === "motion-file" && error.line === 10 && why.test(error.why), line);
    assert.throws(() => readMotions("pose set a 1"), { code: "motion-file", line: 1 });
});

test("text: a rule that a line breaks is told with the line", () => {
    for (const [line, expected] of [
        ["pose set stop 1 2 3", "motion-name"],
        ["pose set 1st 1 2 3", "motion-name"],
        ["pose set abcdefghi 1 2 3", "motion-name"],
        ["group 7\npose set ok 90deg", "motion-name"],
        ["sequence wave add nopose 1s", "motion-no-pose"],
        ["sequence wave add left 0.805s", "motion-time"],
        ["sequence wave add left 0s", "motion-time"],
        ["sequence wave add left 601s", "motion-time"],
        ["sequence wave add left 1s dwell 66s", "motion-time"],
    ])
        assert.equal(code(() => readMotions(TEXT.replace("group 7\npose set arm 90deg\n", "") + line, { keywords: keywordsOf(tables()) })), expected, line);
});

test("text: more than 16 steps are refused", () => {
    const many = TEXT + "sequence wave add left 1s\n".repeat(14);

    assert.throws(() => readMotions(many), { code: "motion-file", line: 23 });
});

test("text: a sequence with a deleted pose is left out", () => {
    const { motions: read, gone } = readMotions(`${TEXT}sequence bad new - 1s\nsequence bad add left 1s\n`);

    assert.deepEqual(gone, ["bad"]);
    assert.deepEqual(readMotions(`${TEXT}sequence bad step 1: its pose is deleted\nsequence bad add left 1s\n`).gone, ["bad"]);
    assert.deepEqual([...read.sequences.keys()], ["wave"]);
});

test("keywords: words of commands, not their arguments", () => {
    const keywords = keywordsOf(tables());

    for (const word of ["pose", "in", "at", "loop", "times", "sync", "action", "wait", "off"]) assert.ok(keywords.has(word), word);
    for (const word of ["ID", "NAME", "wave"]) assert.ok(!keywords.has(word), word);
});

test("poses: one that a sequence needs stays", () => {
    const it = motions();

    assert.equal(code(() => it.deletePose("left")), "motion-pose-used");
    it.deleteSequence("wave");
    it.deletePose("left");
    assert.ok(!it.poses.has("left") && it.isChanged);
});

test("poses: a new name goes on to the steps", () => {
    const it = motions();

    it.renamePose("left", "l");
    assert.equal(it.sequences.get("wave")[0].pose, "l");
    assert.equal(code(() => it.renamePose("l", "middle")), "motion-twice");
    assert.equal(code(() => it.renamePose("l", "loop")), "motion-name");
    assert.equal(it.freeName("longnamed"), "longname1".slice(0, 7) + "1");
});

test("poses: angles have a range", () => {
    const it = motions();

    assert.equal(code(() => it.setAngle("arm", 7, 1024)), "motion-angle");
    assert.equal(code(() => it.setAngle("arm", 7, NaN)), "motion-angle");
    it.setAngle("arm", 3, 100);
    assert.deepEqual([...it.poses.get("arm").keys()], [3, 7]);
});

test("steps: change, move, remove; a bad change does nothing", () => {
    const it = motions();
    const names = () => it.sequences.get("wave").map(({ pose }) => pose);

    it.moveStep("wave", 0, 1);
    assert.deepEqual(names(), ["middle", "left", "left"]);
    assert.equal(it.moveStep("wave", 0, -1), false);
    it.changeStep("wave", 2, { passes: true });
    assert.equal(it.sequences.get("wave")[2].dwell, 0);
    assert.equal(code(() => it.changeStep("wave", 0, { time: 5 })), "motion-time");
    assert.equal(it.sequences.get("wave")[0].time, 400);
    it.removeStep("wave", 0);
    assert.deepEqual(names(), ["left", "left"]);
});

test("check: 19 servos and a sequence without steps are refused", () => {
    const it = motions();

    it.setPose("many", Array.from({ length: 16 }, (_, index) => [index + 100, 1]));
    assert.equal(code(() => it.check()), "motion-joints");
    it.deletePose("many");
    it.setSequence("empty", []);
    assert.equal(code(() => it.check()), "motion-no-steps");
});

test("part: a sequence with the poses that it needs", () => {
    const part = motions().partOf("wave");

    assert.deepEqual([...part.poses.keys()].sort(), ["left", "middle"]);
    assert.deepEqual([...part.sequences.keys()], ["wave"]);
});

test("file: too many poses and sequences are refused", () => {
    const poses = (count) => "group 1\n" + Array.from({ length: count }, (_, index) => `pose set p${index} 1raw\n`).join("");

    assert.equal(readMotions(poses(500)).motions.poses.size, 500);
    assert.throws(() => readMotions(poses(20000)), { code: "motion-file", line: 502 });
});

test("file: a notice cuts a name that is very long", () => {
    const name = "x".repeat(100000);

    for (const text of [`group 1\npose set ${name} 1raw`, `group 1\npose set a 1raw\nsequence b new ${name} 1s`])
        assert.throws(() => readMotions(text), (error) => noticeText({ ...error }).text.length < 400);
    assert.ok(noticeText({ code: "motion-gone", names: [name] }).text.length < 400);
});

test("readMotions: a line of many ranges is refused at once", () => {
    const begun = process.cpuUsage();

    assert.throws(() => readMotions(`group${" 0-253".repeat(33000)}`), { code: "motion-file", line: 1 });
    assert.ok(process.cpuUsage(begun).user < 500000, `${process.cpuUsage(begun).user} us`);
});
