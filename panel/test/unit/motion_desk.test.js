// SPDX-License-Identifier: MIT
/* What the view Motion works on, at a session without a port. */

import assert from "node:assert/strict";
import test from "node:test";
import { sendLine } from "../../src/model/by_hand.js";
import { MotionDesk } from "../../src/model/motion_desk.js";
import { MotionStore } from "../../src/model/motion_store.js";
import { Player } from "../../src/model/player.js";
import { Session } from "../../src/model/session.js";
import { alarms } from "../../src/texts/alarms.js";
import { texts } from "../../src/texts/texts.js";
import { tables } from "../support/tables.js";

/* The notices of a motion of the board that ends with error `number`; `meanwhile` is called before. `lines`: what the console
 * prints of it. `robot`: the servos and the line. */
async function ended(meanwhile, { number = 54, lines = [], robot = {} } = {}) {
    const session = new Session({ tables: tables() });
    const tell = (state, error) => {
        session.robot.motion = { state, error };
        session.dispatchEvent(new Event("change"));
    };

    session.robot = { servos: new Map([[1, {}]]), answering: 1, ...robot };
    session.controller = { order: async (line) => Promise.reject(Object.assign(new Error(line), { number, lines })) };
    new MotionDesk(session);
    tell(2, 0);
    meanwhile(session);
    tell(2, 0);
    session.stopState = "none";
    tell(0, number);
    await new Promise(setImmediate);
    return session.notices;
}

/* A desk with `names` as poses of servo 1. */
function deskWith(...names) {
    const session = new Session({ tables: tables() });
    const desk = new MotionDesk(session);

    for (const name of names) desk.motions.setPose(name, new Map([[1, 512]]));
    return { session, desk };
}

const posesOf = (steps) => steps.map(({ pose }) => pose);

test("addStep: takes the next pose, after the last the first", async () => {
    const { desk } = deskWith("up", "down", "left");

    desk.showPose("left");
    for (let count = 0; count < 4; count++) await desk.addStep();
    assert.deepEqual(posesOf(desk.steps), ["up", "down", "left", "up"]);
    await desk.changeStep(3, { pose: "down" });
    await desk.addStep();
    assert.equal(desk.steps.at(-1).pose, "left");
});

/* What a user can see of poses and sequences. */
const shownBy = ({ motions, pose, sequence, step }) => [[...motions.poses], [...motions.sequences], pose, sequence, step, motions.isChanged];

const deletions = {
    "Pose left": (desk) => desk.deletePose("left"),
    "Pose left, servo 1": (desk) => desk.removeJoint(1),
    "Sequence seq1": (desk) => desk.deleteSequence(),
    "Step 2": (desk) => desk.removeStep(1),
};

for (const [what, call] of Object.entries(deletions))
    test(`undo: ${what} comes back as it was`, async () => {
        const { session, desk } = deskWith("up", "left", "down");

        await desk.addStep();
        await desk.addStep();
        await desk.changeStep(1, { pose: "down", time: 500 });
        desk.showPose("left");
        desk.motions.isChanged = false;
        const before = shownBy(desk);

        await call(desk);
        assert.notDeepEqual(shownBy(desk), before);
        assert.equal(session.notices[0].text, `${what} is deleted.`);
        session.notices[0].undo();
        assert.deepEqual(shownBy(desk), before);
        assert.deepEqual(session.notices, []);
    });

test("recapture: a servo that is not chosen keeps its angle", async () => {
    const { session, desk } = deskWith();
    const servos = new Map([1, 2, 3].map((id) => [id, { id, presence: "online", isOld: () => false, raw: { position: 100 * id } }]));

    Object.assign(session, { state: "connected", robot: { ids: [1, 2, 3], servos } });
    desk.motions.setPose("up", new Map([[1, 512], [2, 512], [3, 512]]));
    desk.showPose("up");
    desk.unchosen = new Set([1, 2]);
    await desk.recapture();
    assert.deepEqual([...desk.motions.poses.get("up")], [[1, 512], [2, 512], [3, 300]]);
});

test("undo: offered until the next edit, not after a refusal, which is told until then, too", async () => {
    const { session, desk } = deskWith("up", "down");
    const codes = () => session.notices.map(({ code }) => code);

    await desk.addStep();
    await desk.deletePose("up");
    assert.deepEqual(codes(), ["motion-pose-used"]);
    await desk.setAngle(1, 400);
    assert.deepEqual(codes(), ["motion-angle"]);
    await desk.deletePose("down");
    assert.deepEqual(codes(), ["motion-deleted"]);
    await desk.addStep();
    assert.deepEqual(codes(), []);
});

test("undo: after a saved deletion there is unsaved work", async () => {
    const { session, desk } = deskWith("up", "down");

    assert.ok(desk.exportText());
    await desk.deletePose("down");
    assert.ok(desk.exportText());
    session.notices[0].undo();
    assert.ok(desk.hasUnsaved);
});

/* A desk that records servo 1 for `ms`. */
async function recording(ms, positionAt = () => 512) {
    const { session, desk } = deskWith();
    const servo = { id: 1, presence: "online", isOld: () => false, raw: { position: 512 }, updatedAt: 0 };
    const robot = Object.assign(new EventTarget(), { ids: [1], servos: new Map([[1, servo]]) });

    Object.assign(session, { state: "connected", robot });
    await desk.recordings.begin();
    for (; servo.updatedAt <= ms; servo.updatedAt += 20) {
        servo.raw.position = positionAt(servo.updatedAt);
        robot.dispatchEvent(new Event("feedback"));
    }
    return { session, desk };
}

for (const [what, keep] of [
    ["a sequence", (desk) => desk.recordings.toSequence().then(() => desk.exportText())],
    ["a file", (desk) => desk.recordings.exportCsv()],
])
    test(`recording: it is unsaved until it is ${what}`, async () => {
        const { desk } = await recording(200);

        assert.ok(desk.hasUnsaved);
        await desk.recordings.end();
        assert.ok(desk.hasUnsaved);
        assert.ok(await keep(desk));
        assert.ok(!desk.hasUnsaved);
    });

test("recording: a button pressed twice begins and ends one recording", async () => {
    const { session, desk } = await recording(200);
    const { recorder } = desk.recordings;

    await desk.recordings.begin();
    assert.equal(desk.recordings.recorder, recorder);
    await desk.recordings.end();
    await desk.recordings.end();
    assert.deepEqual(session.notices, []);
});

for (const [answer, isBegun] of [[true, true], [false, false]])
    test(`recording: torque is on, and the user says ${answer ? "yes" : "no"}`, async () => {
        const { session, desk } = deskWith();
        const servo = { id: 1, presence: "online", isOld: () => false, raw: { position: 512 }, torque: true };
        const asked = [];

        session.state = "connected";
        session.robot = Object.assign(new EventTarget(), { ids: [1], servos: new Map([[1, servo]]), setTorqueAll: async (isOn) => (servo.torque = isOn) });
        desk.ask = async (question, yes) => (asked.push(question, yes), answer);
        await desk.recordings.begin();
        assert.deepEqual(asked, [texts.motion.askTorqueOff([1]), "Torque off and record"]);
        assert.match(asked[0], /servo 1\..*may fall/);
        assert.deepEqual([desk.recordings.isRecording, servo.torque], [isBegun, !isBegun]);
    });

test("toSequence: poses of a renamed sequence are not overwritten", async () => {
    const { desk } = await recording(200);

    await desk.recordings.end();
    await desk.recordings.toSequence();
    await desk.renameSequence("wave");
    const before = new Map(desk.motions.poses);

    await desk.recordings.toSequence();
    assert.equal(desk.sequence, "rec2");
    for (const [name, pose] of before) assert.equal(desk.motions.poses.get(name), pose);
});

for (const [what, ms, end, code, isTaken] of [
    ["cut off", 200, (session) => session.disconnect(), "motion-record-cut", true],
    ["cut off at once", 20, (session) => session.disconnect(), "motion-record-cut", false],
    ["ended at once", 20, (_, desk) => desk.recordings.end(), "motion-short", false],
])
    test(`recording: one that is ${what} has one notice`, async () => {
        const { session, desk } = await recording(ms);

        session.robot.end = () => {};
        await end(session, desk);
        assert.deepEqual(session.notices.map((notice) => notice.code), [code]);
        assert.equal(desk.recordings.latest !== null, isTaken);
        assert.equal(desk.hasUnsaved, isTaken);
    });

test("motion: the notice of its end tells the error in words, and the servo", async () => {
    const [stopped] = await ended(() => {});
    const [inhibited] = await ended(() => {}, { number: 12, lines: ["servo 3 is the cause"] });

    assert.equal(stopped.text, "The motion has ended with error 54: stopped: driving is inhibited.");
    assert.equal(inhibited.text, "Servo 3: the motion has ended with error 12: the servo may not be driven.");
    assert.match(inhibited.remedy, /“Release”$/);
});

test("motion: its end by a stop of the user is no notice", async () => {
    assert.deepEqual(await ended((session) => (session.stopState = "stopping")), []);
});

test("open: a good file withdraws the notice of a damaged one", async () => {
    const { session, desk } = deskWith("p");
    const codes = () => session.notices.map(({ code }) => code);
    const file = desk.exportText();

    await desk.open("pose");
    assert.deepEqual(codes(), ["motion-file"]);
    await desk.open(file);
    assert.deepEqual(codes(), ["motion-loaded"]);
});

test("open: a file that was not changed since is unsaved nowhere, and is replaced unasked", async () => {
    const { desk } = deskWith("up");
    const file = desk.exportText();

    desk.ask = async (question) => assert.fail(question);
    await desk.open(file);
    assert.ok(!desk.hasUnsaved);
    await desk.open(file);
    desk.store.load = async () => {};
    await desk.load();
    assert.ok(desk.motions.isEmpty);
});

test("play: the board is asked again after a load that has failed", async () => {
    const { session, desk } = deskWith("up");
    const outcomes = [Promise.reject(Object.assign(new Error(), { code: "timeout" })), Promise.resolve()];
    let loads = 0;

    Object.assign(session, { controller: {}, robot: { servos: new Map() } });
    await desk.addStep();
    Object.assign(desk.store, { store: async () => {}, play: async () => {} });
    Object.defineProperties(desk.store, { canStore: { value: true }, canPlay: { value: true } });
    desk.store.load = () => outcomes[loads++];
    await desk.show();
    await desk.show();
    assert.equal(loads, 1, "the view is rendered often");
    await desk.play();
    await desk.play();
    assert.equal(loads, 2);
});

test("play: the board is read again after a line by hand, also during the load", async () => {
    const { session, desk } = deskWith("up");
    const loads = [];
    const lineDuringLoad = 2;

    Object.assign(session, { state: "connected", robot: { motion: { state: 0 }, servos: new Map(), ids: [] } });
    Object.assign(session, { controller: { hasCommand: () => true, hasMotion: true }, wire: { command: async () => ({ lines: [], error: null }) } });
    await desk.addStep();
    desk.store.stored = desk.motions.partOf(desk.sequence);
    desk.store.play = async () => {};
    desk.store.load = async () => loads.push("load") === lineDuringLoad && sendLine(session, "pose delete up");
    for (const expected of [1, 1]) {
        await desk.play();
        assert.equal(loads.length, expected);
    }
    await sendLine(session, "pose set up 250deg");
    await desk.play();
    assert.equal(loads.length, 3);
    await desk.play();
    assert.equal(loads.length, 3);
});

test("play: a pose that is renamed meanwhile does not end a loop", async () => {
    const { session, desk } = deskWith("up", "down");
    let passes = 0;

    await desk.addStep();
    await desk.addStep();
    desk.setLoop(true);
    desk.player.play = async (path) => {
        assert.deepEqual(path.ids, [1]);
        if (passes === 0) desk.motions.renamePose("up", "top");
        return ++passes < 3;
    };
    await desk.play();
    assert.equal(passes, 3);
    assert.deepEqual(session.notices, []);
});

/* A desk with a sequence; the board has it with pose up at `raw`, or nothing. */
async function deskWithBoard({ raw = null, answer = true } = {}) {
    const { session, desk } = deskWith("up");
    const done = [];

    Object.assign(session, { state: "connected", robot: { motion: { state: 0 }, servos: new Map(), ids: [] } });
    session.controller = { hasCommand: () => true, hasMotion: true };
    session.wire = { hasDevice: true };
    await desk.addStep();
    if (raw !== null) {
        desk.store.stored = desk.motions.partOf(desk.sequence);
        desk.store.stored.poses.set("up", new Map([[1, raw]]));
    }
    desk.store.load = async () => {};
    desk.store.store = async ({ poses, sequences }) => done.push(`store ${[...poses.keys(), ...sequences.keys()]}`);
    desk.store.play = async (name) => done.push(`play ${name}`);
    desk.ask = async () => (done.push("ask"), answer);
    await desk.show();
    return { desk, done };
}

for (const [what, board, isNeeded, expected] of [
    ["nothing", {}, true, ["store up,seq1", "play seq1"]],
    ["the same", { raw: 512 }, false, ["play seq1"]],
    ["another pose, replaced", { raw: 600 }, true, ["ask", "store up", "play seq1"]],
    ["another pose, kept", { raw: 600, answer: false }, true, ["ask"]],
])
    test(`play: the board has ${what}`, async () => {
        const { desk, done } = await deskWithBoard(board);

        assert.equal(desk.needsStore, isNeeded);
        await desk.play();
        assert.deepEqual(done, expected);
    });

test("play: what this page has stored is replaced unasked, until the board has something else", async () => {
    const { desk, done } = await deskWithBoard({ raw: 600 });
    const { store } = desk;

    store.store = async ({ poses, sequences }) => { // as the board does
        const stored = [store.stored, { poses, sequences }];

        store.stored = { poses: new Map(stored.flatMap((one) => [...one.poses])), sequences: new Map(stored.flatMap((one) => [...one.sequences])) };
    };
    await desk.play();
    assert.ok(!desk.hasUnsaved);
    desk.showPose("up");
    await desk.setAngle(1, 100);
    await desk.play();
    assert.deepEqual(done, ["ask", "play seq1", "play seq1"]);
    store.stored.poses.set("up", new Map([[1, 7]]));
    await desk.play();
    assert.deepEqual(done.slice(3), ["ask", "play seq1"]);
});

test("play: what is loaded is replaced unasked, and nothing is unsaved then", async () => {
    const { desk, done } = await deskThatLoaded();

    desk.store.play = async () => {};
    desk.showPose("up");
    await desk.setAngle(1, 100);
    await desk.play();
    assert.deepEqual(done, []);
    assert.ok(!desk.hasUnsaved);
});

for (const [isLineLow, remedy] of [[true, texts.robot.lineLow], [false, texts.robot.allSilent]])
    test(`motion: its end while no servo answers blames none, ${isLineLow ? "the line is held low" : "power may be off"}`, async () => {
        const [notice, ...more] = await ended(() => {}, { number: 83, lines: ["servo 1 is stuck"], robot: { answering: 0, isLineLow } });

        assert.match(notice.text, /^The motion has ended with error 83: /);
        assert.deepEqual([notice.remedy, more], [remedy, []]);
    });

test("motion: its end names what the servo reports first, as a goal beyond its angle limits", async () => {
    const robot = { servos: new Map([[2, { alarms: ["angle limit"] }]]) };
    const [{ text, remedy }] = await ended(() => {}, { number: 83, lines: ["servo 2 is stuck"], robot });

    assert.match(text, /^Servo 2: the motion has ended with error 83: /);
    assert.equal(remedy, `${alarms["angle limit"]} ${tables().errors[83].remedy}`);
});

test("motion: its end tells that torque is off, as the user has switched it", async () => {
    const servo = { torque: false };
    const end = (number) => ended(() => {}, { number, lines: ["servo 1 is stuck"], robot: { servos: new Map([[1, servo]]) } });

    assert.equal((await end(83))[0].text, "Servo 1: the motion has ended with error 84: torque of a servo is off.");
    assert.match((await end(54))[0].text, /error 54/);
    servo.torque = true;
    assert.match((await end(83))[0].text, /error 83/);
});

/* The notice of play() while servo 1 is as `servo`. */
async function refused(servo) {
    const { desk, done } = await deskWithBoard();

    desk.session.robot.servos.set(1, servo);
    await desk.play();
    assert.deepEqual(done, []);
    return desk.session.notices[0];
}

test("play: a hot servo must cool down, then be released, before torque is switched on", async () => {
    const { remedy } = await refused({ torque: false, alarms: ["overheating"], inhibit: "lost" });

    assert.equal(remedy, `${alarms.overheating} Press Release. Choose these servos and press “Torque on”.`);
    assert.equal((await refused({ torque: false, alarms: [], inhibit: "" })).remedy, "Choose these servos and press “Torque on”.");
});

test("play: a servo that does not answer is told as such", async () => {
    assert.equal((await refused({ torque: null, presence: "offline" })).text, "Servo 1 does not answer.");
});

for (const [what, change, code] of [
    ["torque is off", ({ session }) => session.robot.servos.set(1, { torque: false }), "motion-torque"],
    ["driving is inhibited", ({ session }) => (session.robot.isInhibited = true), "motion-inhibited"],
])
    test(`play by the board: nothing is stored while ${what}`, async () => {
        const { desk, done } = await deskWithBoard();

        change(desk);
        await desk.play();
        assert.deepEqual(done, []);
        assert.deepEqual(desk.session.notices.map((notice) => notice.code), [code]);
    });

/* A desk that has loaded poses up and down and sequence seq1 with up; other sequences of the board need `needed`. */
async function deskThatLoaded({ needed = [], answer = true } = {}) {
    const { desk, done } = await deskWithBoard();
    const { store } = desk;
    const board = (desk.motions.setPose("down", new Map([[1, 100]])), desk.motions.partOf("seq1"));

    board.poses.set("down", desk.motions.poses.get("down"));
    store.stored = board;
    await desk.load();
    done.length = 0;
    for (const pose of needed) board.sequences.set("else", [{ pose, time: 1000, dwell: 0, passes: false }]);
    store.store = async (part) => { // as the board does
        for (const [name, pose] of part.poses) board.poses.set(name, pose);
        for (const [name, steps] of part.sequences) board.sequences.set(name, steps);
    };
    store.remove = async (names) => done.push(...names);
    desk.ask = async (question) => (done.push(question), answer);
    return { desk, done };
}

test("store: what was renamed or deleted here is removed on the board, too, if the user says so", async () => {
    const { desk, done } = await deskThatLoaded();

    desk.showPose("up");
    await desk.renamePose("top");
    await desk.renameSequence("nod");
    await desk.deletePose("down");
    await desk.storeAll();
    assert.deepEqual(done, [texts.motion.askRemove(["pose up", "pose down", "sequence seq1"]), "pose up", "pose down", "sequence seq1"]);
    done.length = 0;
    await desk.storeAll();
    assert.deepEqual(done, []); // asked once
});

test("store: a pose that another sequence of the board needs stays, and all stays if the user says no", async () => {
    const needed = await deskThatLoaded({ needed: ["down"] });

    await needed.desk.deletePose("down");
    await needed.desk.storeAll();
    assert.deepEqual(needed.done, []);
    const kept = await deskThatLoaded({ answer: false });

    await kept.desk.deletePose("down");
    await kept.desk.storeAll();
    assert.deepEqual(kept.done, [texts.motion.askRemove(["pose down"])]);
});

test("store: what the page never had stays on the board unasked", async () => {
    const { desk, done } = await deskThatLoaded();

    desk.store.stored.setPose("other", new Map([[1, 7]]));
    await desk.storeAll();
    assert.deepEqual(done, []);
});

test("delete: the poses of a recording go with its sequence, and come back with it", async () => {
    const { session, desk } = await recording(200);

    desk.motions.setPose("up", new Map([[1, 512]]));
    await desk.recordings.end();
    await desk.recordings.toSequence();
    const all = [...desk.motions.poses.keys()];

    assert.ok(all.length > 2);
    desk.showPose("rec1x1");
    await desk.changeStep(0, { pose: "up" });
    await desk.deleteSequence();
    assert.deepEqual([...desk.motions.poses.keys()], ["up", "rec1x1"]); // the sequence did not use them, or they are no recording's
    assert.equal(desk.pose, "rec1x1");
    session.notices.at(-1).undo();
    assert.deepEqual([...desk.motions.poses.keys()], all);
});

test("delete: a pose of a recording stays if another sequence has it, and one that goes is not shown", async () => {
    const { desk } = await recording(400, (ms) => (ms > 100 ? 512 + Math.min(ms - 100, 200) : 512));

    await desk.recordings.end();
    assert.equal(desk.recordings.latest.length, 200); // without the standstill at begin and end
    await desk.recordings.toSequence();
    const [{ pose }] = desk.steps;

    await desk.newSequence();
    await desk.addStep();
    assert.equal(desk.steps[0].pose, pose);
    desk.showSequence("rec1");
    desk.showPose("rec1x2");
    await desk.deleteSequence();
    assert.deepEqual([...desk.motions.poses.keys()], [pose]);
    assert.equal(desk.pose, "");
});

test("playhead: the board's step, then the time since; none in another sequence", async () => {
    const { desk } = await deskWithBoard();
    const { session } = desk;
    let now = 0;

    await desk.changeStep(0, { time: 2000 });
    await desk.addStep();
    session.clock = { now: () => now };
    desk.store.names = ["other", "seq1"];
    desk.store.stored = desk.motions.partOf("seq1");
    session.robot.motion = { state: 2, play: 2, step: 2, override: 50 };
    assert.equal(desk.playhead(), 2000);
    now = 400;
    assert.equal(desk.playhead(), 2200);
    session.robot.motion.paused = 1;
    now = 900;
    assert.equal(desk.playhead(), 2200);
    desk.motions.setAngle("up", 1, 10);
    assert.equal(desk.playhead(), NaN, "edited: the curves are not what plays");
    desk.motions.setAngle("up", 1, 512);
    assert.equal(desk.playhead(), 2200);
    session.robot.motion.play = 1;
    assert.equal(desk.playhead(), NaN);
});

test("playhead: the page plays; none once the sequence is edited, none in a sequence while a recording plays", async () => {
    const { session, desk } = deskWith("up");

    session.state = "connected";
    session.robot = { servos: new Map(), ids: [] };
    await desk.addStep();
    desk.player.play = () => new Promise(() => {});
    Object.assign(desk, { by: "page" });
    desk.store = { canPlay: false };
    desk.play();
    await turn();
    Object.assign(desk.player, { state: "playing", time: 300 });
    assert.deepEqual([desk.playhead(), desk.playhead({})], [300, NaN]);
    await desk.changeStep(0, { time: 700 });
    assert.equal(desk.playhead(), NaN);
});

test("speed, loop and times: of a motion that the page has not begun the speed is the board's, the others are unknown", async () => {
    const { desk } = await deskWithBoard();
    const { session } = desk;
    const tell = (motion) => {
        session.robot.motion = motion;
        session.dispatchEvent(new Event("change"));
    };

    tell({ state: 2, play: 1, step: 1, override: 10 });
    assert.deepEqual([desk.percent, desk.isOwn], [10, false]);
    desk.percent = 40; // the user moves the slider, and the board has not taken it yet
    tell({ state: 2, play: 1, step: 1, override: 10 });
    assert.equal(desk.percent, 40);
    tell({ state: 0, override: 40, error: 0 });
    await desk.play();
    tell({ state: 2, play: 1, step: 1, override: 40 });
    assert.deepEqual([desk.percent, desk.isOwn], [40, true]);
    tell({ state: 0, override: 40, error: 0 });
    assert.equal(desk.isOwn, false);
});

test("End: what is stored first is not played then; what begins is ended", async () => {
    const { desk, done } = await deskWithBoard();
    const { store } = desk;
    let finish = null;

    store.end = async () => done.push("end");
    store.store = () => new Promise((resolve) => (done.push("store"), (finish = resolve)));
    const playing = desk.play();

    await turn();
    assert.ok(desk.isStarting);
    desk.end();
    finish();
    await playing;
    assert.deepEqual([done, desk.isStarting], [["store"], false]);

    store.store = async () => {};
    store.play = async () => (done.push("play"), desk.end());
    await desk.play();
    assert.deepEqual(done, ["store", "play", "end"]);
    store.play = async () => done.push("play again");
    await desk.play();
    assert.equal(done.at(-1), "play again", "the next one plays");
});

test("replay: the outcome names the speed", async () => {
    const { desk } = await recording(200, (t) => 512 + t);

    await desk.recordings.end();
    desk.player.play = async () => true;
    desk.percent = 200;
    await desk.playRecording();
    assert.equal(desk.recordings.replay.percent, 200);
    assert.match(texts.motion.replayed({ largest: 1, id: 1, mean: 1, percent: 200 }), /^Replay at 200 %: /);
});

test("a step that is too fast for a servo: the text says that the step is too short", () => {
    assert.equal(texts.motion.tooFast({ step: 5, id: 1, needed: "0.03" }), "Step 5 is too short: servo 1 needs 0.03 s.");
});

test("remove: sequences go first, and the caller's list stays as it is", async () => {
    const session = new Session({ tables: tables() });
    const store = new MotionStore(session);
    const names = ["pose up", "sequence nod"];
    const lines = [];

    session.controller = { run: async (line) => lines.push(line) };
    store.load = async () => {};
    await store.remove(names);
    assert.deepEqual(lines, ["sequence delete nod", "pose delete up"]);
    assert.deepEqual(names, ["pose up", "sequence nod"]);
});

test("loop and times: another sequence begins without, a renamed one keeps them", async () => {
    const { desk } = deskWith("up");

    await desk.addStep();
    desk.setLoop(true);
    desk.times = 3;
    await desk.renameSequence("nod");
    assert.deepEqual([desk.isLoop, desk.times], [true, 3]);
    await desk.newSequence();
    assert.deepEqual([desk.isLoop, desk.times], [false, 1]);
    desk.setLoop(true);
    desk.showSequence("nod");
    assert.equal(desk.isLoop, false);
});

test("storeAll: a button pressed twice stores once", async () => {
    const { desk } = deskWith("up");
    let loads = 0;

    desk.store.load = () => new Promise(() => loads++);
    desk.storeAll();
    desk.storeAll();
    assert.equal(loads, 1);
});

test("play: a goal that the wire does not take names the controller, not torque", async () => {
    const servo = { torque: true, isEndless: false, raw: { position: 512 } };
    const session = Object.assign(new EventTarget(), {
        isConnected: true, stopState: "none", clock: { now: () => 0 }, wire: { state: "synchronising" },
        takeMotion: () => {}, robot: { isInhibited: false, servos: new Map([[1, servo]]), setGoal: () => false },
    });

    await assert.rejects(new Player(session).goTo(new Map([[1, 600]])), { code: "silent" });
});

test("play: pressed several times begins once", async () => {
    const { session, desk } = deskWith("up");
    const lines = [];
    const answers = [];

    session.state = "connected";
    session.robot = { motion: { state: 0 }, servos: new Map(), ids: [] };
    session.controller = { hasCommand: () => true, hasMotion: true };
    await desk.addStep();
    Object.assign(desk.store, { load: async () => {}, stored: desk.motions.partOf(desk.sequence) });
    desk.store.play = (name) => new Promise((resolve) => (lines.push(name), answers.push(resolve)));
    const first = desk.play();
    const all = [first, desk.play(), desk.play()];

    await new Promise((resolve) => setImmediate(resolve));
    answers.forEach((answer) => answer());
    await Promise.all(all);
    assert.deepEqual([lines, session.notices], [[desk.sequence], []]);
    assert.equal(desk.isPlaying, true); // until the state of the motion is read
});

/* A desk with pose "up" of an idle board. `gate.open()` ends the store or load that is under way. */
function deskAtGate() {
    const { session, desk } = deskWith("up");
    const gate = {};
    const closed = new Promise((resolve) => (gate.open = resolve));

    desk.store.load = async () => {};
    return { session, desk, gate, closed };
}

const turn = () => new Promise((resolve) => setImmediate(resolve));
const down = (desk) => desk.motions.setPose("down", new Map([[1, 600]]));

for (const [step, replaced] of [["load", "load"], ["store", "store"]])
    test(`storeAll: a pose captured during the ${step} is not stored, not counted, and unsaved`, async () => {
        const { session, desk, gate, closed } = deskAtGate();
        let sent = null;

        desk.store.store = async (motions) => (sent = [...motions.poses.keys()]);
        const call = desk.store[replaced];

        desk.store[replaced] = async (motions) => (await call(motions), await closed);
        const stored = desk.storeAll();

        await turn();
        down(desk);
        gate.open();
        await stored;
        assert.deepEqual(sent, ["up"]);
        assert.match(session.notices[0].text, /confirmed 1 pose and/);
        assert.ok(desk.hasUnsaved);
        await desk.storeAll();
        assert.ok(!desk.hasUnsaved);
    });

for (const isReplaced of [true, false])
    test(`load: a pose captured during the load is asked about: ${isReplaced ? "replaced" : "kept"}`, async () => {
        const { desk, gate, closed } = deskAtGate();
        const asked = [];

        desk.motions.isChanged = false;
        desk.ask = async (text) => (asked.push(text), isReplaced);
        desk.store.load = () => closed;
        const loaded = desk.load();

        await turn();
        down(desk);
        gate.open();
        await loaded;
        assert.deepEqual(asked, [texts.motion.askReplacePage]);
        assert.equal(desk.motions.poses.has("down"), !isReplaced);
    });
