// SPDX-License-Identifier: MIT
/* Poses and sequences on the real firmware in the simulator: store, load, play; a replay by the page. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { MotionDesk } from "../../src/model/motion_desk.js";
import { MotionStore } from "../../src/model/motion_store.js";
import { Motions, keywordsOf } from "../../src/model/motions.js";
import { readMotions, textOfMotions } from "../../src/model/motion_text.js";
import { pathOfPoints, pathOfSequence } from "../../src/model/path.js";
import { Player } from "../../src/model/player.js";
import { Recorder, compare } from "../../src/model/recording.js";
import { Session } from "../../src/model/session.js";
import { PtyPort, ROOT, Simulator } from "../support/simulator.js";
import { tables } from "../support/tables.js";

const WAVE = `group 1 2 3
pose set left 448raw 576raw 512raw
pose set middle 512raw 512raw 512raw
sequence wave new left 0.4s
sequence wave add middle 0.2s pass
sequence wave add left 0.4s dwell 0.1s
`;

const contents = ({ poses, sequences }) => [Object.fromEntries(poses), Object.fromEntries(sequences)];
const read = (text) => readMotions(text, { keywords: keywordsOf(tables()) }).motions;

async function connect(t, options = {}) {
    const simulator = await Simulator.start({ board: "arduino-mega", ...options });
    const session = new Session({ tables: tables() });

    t.after(async () => {
        await session.disconnect();
        session.withdraw(session.notices.map(({ code }) => code)); // no timer of them keeps the test
        await simulator.end();
    });
    await session.connect(new PtyPort(simulator.path));
    assert.equal(session.state, "connected", JSON.stringify(session.notices));
    return { simulator, session, store: new MotionStore(session) };
}

/* Waits until `is` holds; asked at each event of the session. */
function until(session, is) {
    return new Promise((resolve) => {
        const look = () => {
            if (!is()) return;
            for (const name of ["change", "feedback"]) session.removeEventListener(name, look);
            resolve();
        };

        for (const name of ["change", "feedback"]) session.addEventListener(name, look);
        look();
    });
}

/* Plays `path`, and again, twice at most, if a busy machine has held it up. */
async function playWhole(t, player, path) {
    for (let tries = 1; ; tries++)
        try {
            return await player.play(path);
        } catch (error) {
            if (error.code !== "motion-late" || tries === 3) throw error;
            t.diagnostic(`held up ${tries} times`);
        }
}

async function torqueOn(session) {
    for (const id of session.robot.ids) await session.robot.setTorque(id, true);
}

test("store: loads what it stored, leaves the group as it was", async (t) => {
    const { session, store } = await connect(t);

    await session.controller.run("group 2 3");
    await store.load();
    assert.ok(store.stored.isEmpty && store.canPlay);
    assert.ok(store.room.poses >= 48, `${store.room.poses}`);
    await store.store(read(WAVE));
    assert.equal(textOfMotions(store.stored), WAVE);
    assert.deepEqual(store.names, ["wave"]);
    assert.deepEqual(await session.controller.run("group"), ["group 2 3 sync"]);
    await store.remove(["pose left", "sequence wave"]);
    assert.deepEqual([[...store.stored.poses.keys()], store.names], [["middle"], []]);
});

test("store: 18 servos in lines of full length", async (t) => {
    const { store } = await connect(t, { servos: "1-18" });
    const motions = new Motions();

    motions.setPose("abcdefgh", Array.from({ length: 18 }, (_, index) => [index + 1, 1023 - index]));
    await store.load();
    await store.store(motions);
    assert.deepEqual(store.stored.poses, motions.poses);
});

test("store: a line that fails leaves what was there before", async (t) => {
    const { session, store } = await connect(t);
    const run = session.controller.run.bind(session.controller);

    await store.load();
    await store.store(read(WAVE));
    const other = read(`group 1 2 3
pose set fresh 1raw 2raw 3raw
pose set left 1raw 2raw 3raw
sequence wave new left 1s
sequence second new fresh 1s
`);

    for (const bad of ["pose set left", "sequence wave", "sequence second"]) {
        let hasFailed = false;

        session.controller.run = (line, options) => {
            const fails = !hasFailed && line.startsWith(bad);

            hasFailed ||= fails;
            return run(fails ? "pose set x 999" : line, options);
        };
        await assert.rejects(store.store(other), { name: "CommandError" });
        session.controller.run = run;
        await store.load();
        assert.deepEqual(contents(store.stored), contents(read(WAVE)), bad);
        assert.ok(session.notices.some(({ code }) => code === "motion-taken-back"));
    }
    assert.deepEqual(store.replaced(other, new Motions()), ["left", "wave"]);
});

test("store: a stop between the lines leaves what was there before", async (t) => {
    const { session, store } = await connect(t);
    const run = session.controller.run.bind(session.controller);

    await store.load();
    session.controller.run = (line, options) => {
        if (line.startsWith("sequence wave add")) {
            session.controller.run = run;
            session.stop();
        }
        return run(line, options);
    };
    await assert.rejects(store.store(read(WAVE)), { code: "stopped" });
    await store.load();
    assert.ok(store.stored.isEmpty, textOfMotions(store.stored));
    await until(session, () => session.stopState === "verified");
});

test("store: too many servos are refused before anything is sent", async (t) => {
    const { session, store } = await connect(t);
    const all = new Motions();

    await store.load();
    await store.store(read(WAVE));
    all.setPose("many", Array.from({ length: 16 }, (_, index) => [index + 100, 1]));
    await assert.rejects(store.store(all), { code: "motion-joints" });
    all.setPose("many", [[1, 1]]);
    store.room = { poses: 0, sequences: 0 };
    await assert.rejects(store.store(all), { code: "motion-room" });
    assert.deepEqual(await session.controller.run("pose list"), ["left", "middle"]);
});

test("load: a sequence with a deleted pose is left out", async (t) => {
    const { session, store } = await connect(t);

    await store.load();
    await store.store(read(WAVE));
    await session.controller.run("pose delete middle");
    await store.load();
    assert.deepEqual(store.gone, ["wave"]);
    assert.deepEqual([...store.stored.poses.keys()], ["left"]);
    await store.store(read(WAVE));
    assert.equal(textOfMotions(store.stored), WAVE);
});

test("play: loop, override, pause, resume, end", async (t) => {
    const { session, store } = await connect(t);
    const motion = () => session.robot.motion;

    await store.load();
    await store.store(read(WAVE));
    await torqueOn(session);
    await store.play("wave", { times: 0, percent: 50 });
    await until(session, () => motion()?.state === 2 && motion().step > 1);
    assert.equal(motion().override, 50);
    assert.equal(store.playing, "wave");
    await store.override(150);
    await until(session, () => motion().override === 150);
    await store.setPaused(true);
    await until(session, () => motion().paused === 1);
    await assert.rejects(store.store(read(WAVE)), { code: "motion-playing" });
    await store.setPaused(false);
    await until(session, () => motion().paused === 0);
    await store.end();
    await until(session, () => motion().state === 0);
    await assert.rejects(store.setPaused(true), { code: "motion-none" });
});

test("play: ends where the sequence ends", async (t) => {
    const { session, store } = await connect(t);

    await store.load();
    await store.store(read(WAVE));
    await torqueOn(session);
    await store.play("wave");
    await until(session, () => session.robot.motion?.state === 2);
    await until(session, () => session.robot.motion.state === 0);
    assert.equal(session.robot.motion.error, 0);
    assert.ok(Math.abs(session.robot.servos.get(1).raw.position - 448) <= 3);
});

test("play: its end names the servo that has lost its power", async (t) => {
    const folder = mkdtempSync(join(tmpdir(), "poke-"));
    const socket = join(folder, "poke");
    const { session, store } = await connect(t, { options: ["--poke", socket] });

    t.after(() => rmSync(folder, { recursive: true }));
    new MotionDesk(session);
    await store.load();
    await store.store(read(WAVE));
    await torqueOn(session);
    await store.play("wave", { times: 0 });
    await until(session, () => session.robot.motion?.state === 2);
    execFileSync(join(ROOT, "build/host/cds55xx-sim"), ["poke", socket, "power 2 off"]);
    const told = () => session.notices.find(({ code }) => code === "motion-ended");

    await until(session, told);
    assert.match(told().text, /^Servo 2: the motion has ended with error \d+: /);
});

test("replay: follows a recording and measures the error", async (t) => {
    const { session, store } = await connect(t);
    const { robot } = session;
    const recorder = new Recorder(robot, session.clock);
    const player = new Player(session);

    await store.load();
    await store.store(read(WAVE.replaceAll("0.4s", "0.8s").replace("0.2s", "0.6s")));
    await torqueOn(session);
    recorder.start([1, 2, 3]);
    await store.play("wave");
    await until(session, () => robot.motion?.state === 2);
    await until(session, () => robot.motion.state === 0);
    const recording = recorder.end();
    const path = pathOfPoints(recording.ids, recording.samples);

    assert.ok(recording.rate >= 20, `${recording.rate} samples a second`);
    assert.equal(await playWhole(t, player, path), true);
    const { largest, samples } = compare(path, player.samples);

    t.diagnostic(`largest error ${largest.toFixed(1)} steps in ${samples} samples`);
    assert.ok(samples > 20 && largest < 40, `${largest} steps in ${samples} samples`);
});

test("replay: a stop ends it, and no goal follows", async (t) => {
    const { session } = await connect(t);
    const player = new Player(session);
    const goals = [];

    session.wire.addEventListener("traffic", ({ detail }) => detail.direction === "out" && goals.push(detail));
    await torqueOn(session);
    const path = pathOfSequence([{ pose: "a", time: 5000, dwell: 0, passes: false }], new Map([["a", new Map([[1, 100]])]]), new Map([[1, 512]]));
    const played = playWhole(t, player, path);

    await until(session, () => session.robot.servos.get(1).raw.position < 480);
    const stop = session.stop();
    const sent = goals.length;

    assert.equal(await played, false); // Stop tells its own state
    await stop;
    assert.equal(session.stopState, "verified");
    assert.ok(goals.slice(sent).every(({ bytes }) => bytes[4] !== 3 || bytes[5] !== 0x1e), "a goal left after the stop");
});

test("replay: torque off is refused before anything is sent", async (t) => {
    const { session } = await connect(t);
    const path = pathOfPoints([1, 2], [{ t: 0, raw: [500, 500] }, { t: 1000, raw: [600, 600] }]);

    await until(session, () => session.robot.servos.get(2).torque === false);
    await assert.rejects(new Player(session).play(path), { code: "motion-torque", ids: [1, 2] });
});

test("firmware without motions: stores, or neither", async (t) => {
    const { store } = await connect(t, { board: "atmega128" });

    assert.deepEqual([store.canStore, store.canPlay], [true, false]);
    await store.load();
    await store.store(read(WAVE));
    assert.equal(textOfMotions(store.stored), WAVE);
    const other = await connect(t, { board: "arbotix" });

    assert.deepEqual([other.store.canStore, other.store.canPlay], [false, false]);
});
