// SPDX-License-Identifier: MIT
/* Jog: a servo moves while a key is held, at a fake port and a fake clock. */

import assert from "node:assert/strict";
import test from "node:test";
import { Jog } from "../../src/model/jog.js";
import { Session } from "../../src/model/session.js";
import { rawOfDegrees } from "../../src/model/units.js";
import { INSTRUCTION, word, wordAt } from "../../src/wire/packet.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const GOAL = 0x1e;
const SPEED = 0x20;

async function rig({ torque = 1, isEndless = false } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });

    const registers = port.addServo(1, torque);

    if (isEndless) registers.set([0, 0, 0, 0], 0x06);
    port.onText = (line) => line === "servos" && (port.say(`servo 1: online, torque ${torque ? "on" : "off"}`, "ok"), true);
    session.connect(port);
    await clock.advance(1000);
    const written = (address) =>
        port.packets
            .filter((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === address)
            .map((bytes) => wordAt(bytes, 6));

    return { clock, port, session, registers, jog: new Jog(session), goals: () => written(GOAL), speeds: () => written(SPEED) };
}

test("jog: the goal runs ahead of the position, and hold ends it", async () => {
    const { clock, registers, jog, goals } = await rig();

    assert.equal(jog.start(1, 1, 20), true);
    await clock.advance(60);
    registers.set(word(530), 0x24);
    await clock.advance(60);
    jog.stop();
    await clock.advance(1000);
    const sent = goals();

    assert.equal(sent[0], 512 + 102); // 30 degrees
    assert.equal(sent.at(-2), 530 + 102);
    assert.equal(sent.at(-1), 530);
    assert.equal(jog.id, null);
});

test("jog: stays within the angle limits", async () => {
    const { clock, registers, jog, goals } = await rig();

    registers.set([...word(500), ...word(520)], 0x06);
    await clock.advance(1500);
    jog.start(1, -1, 60);
    await clock.advance(100);
    assert.equal(goals()[0], 500);
});

test("jog: sends no goal while no feedback comes", async () => {
    const { clock, port, jog, goals } = await rig();

    jog.start(1, 1, 20);
    await clock.advance(200);
    port.isMute = true;
    await clock.advance(20);
    const before = goals().length;

    await clock.advance(3000);
    assert.equal(goals().length, before);
});

test("jog: ignored while torque is off", async () => {
    const { clock, jog, goals } = await rig({ torque: 0 });

    assert.equal(jog.start(1, 1, 20), false);
    assert.equal(jog.id, null);
    await clock.advance(500);
    assert.deepEqual(goals(), []);
});

test("jog: a stop ends it, no goal leaves after it", async () => {
    const { clock, session, jog, goals } = await rig();

    jog.start(1, 1, 20);
    await clock.advance(200);
    session.stop();
    const before = goals().length;

    await clock.advance(2000);
    assert.equal(jog.id, null);
    jog.stop();
    await clock.advance(1000);
    assert.equal(session.stopState, "verified");
    assert.equal(goals().length, before);
});

/* Presses and releases the key 24 times a second, for 2 s. Returns the times at which a goal left. */
async function mash({ clock, port, jog }) {
    const times = [];
    const write = port.write.bind(port);

    port.write = (bytes) => {
        if (bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL) times.push(clock.now());
        write(bytes);
    };
    for (let press = 0; press < 48; press++) {
        jog.start(1, press % 2 ? 1 : -1, 20);
        await clock.advance(21);
        jog.stop();
        await clock.advance(21);
    }
    return times;
}

test("jog: keys that are mashed send at most 20 goals a second, and the last one is the hold", async () => {
    const it = await rig();
    const times = await mash(it);
    const most = Math.max(...times.map((begin) => times.filter((time) => time >= begin && time < begin + 1000).length));

    assert.ok(most <= 20 && most >= 10, `${most} goals in a second`);
    it.registers.set(word(540), 0x24);
    it.jog.start(1, 1, 20);
    it.jog.stop();
    await it.clock.advance(100);
    assert.equal(it.goals().at(-1), 540);
    assert.equal(it.session.robot.servos.get(1).goalState, "confirmed");
});

test("jog: a hold that waits for its turn is void after a stop", async () => {
    const { clock, session, jog, goals } = await rig();

    jog.start(1, 1, 20);
    await clock.advance(200);
    const before = goals().length;

    jog.stop();
    session.stop();
    await clock.advance(2000);
    assert.equal(session.stopState, "verified");
    assert.ok(goals().length <= before + 1);
    assert.deepEqual(session.notices.map(({ code }) => code).filter((code) => code !== "other-version" && code !== "console"), []);
});

/* The key is released while the controller is silent. Returns the goals that leave when it answers. */
async function endInSilence(meanwhile) {
    const it = await rig();
    const { clock, port, jog, goals } = it;

    jog.start(1, 1, 20);
    await clock.advance(200);
    port.isMute = true;
    await clock.advance(50);
    jog.stop();
    await clock.advance(5000);
    const before = goals().length;

    await meanwhile(it);
    port.isMute = false;
    await clock.advance(3000);
    return goals().slice(before);
}

test("jog: its end reaches a controller that was silent", async () => {
    assert.deepEqual(await endInSilence(({ registers }) => registers.set(word(570), 0x24)), [570]);
    assert.deepEqual(await endInSilence(({ registers }) => (registers[0x18] = 0)), [], "torque went off");
    assert.deepEqual(await endInSilence(({ session }) => void session.stop()), [], "a stop came first");
});

test("jog: a servo in endless turn is not moved", async () => {
    const { clock, jog, goals, speeds } = await rig({ isEndless: true });

    assert.equal(jog.start(1, -1, 20), false);
    await clock.advance(500);
    assert.deepEqual(speeds(), []);
    assert.deepEqual(goals(), []);
});

test("jog: a hold that fails is a notice", async () => {
    const { clock, port, session, jog } = await rig();

    jog.start(1, 1, 20);
    await clock.advance(100);
    port.refusals.set(1, 0x08);
    jog.stop();
    await clock.advance(500);
    assert.ok(session.notices.some(({ code }) => code === "refused"), JSON.stringify(session.notices));
});

for (const delay of [2, 20, 60])
    for (const gap of [0, 5, 10, 60])
        test(`jog: a goal ${gap} ms after its end is the last one, replies take ${delay} ms`, async () => {
            const { clock, port, session, jog, goals } = await rig();
            const answer = port.answer.bind(port);

            port.answer = (bytes) => clock.after(delay, () => answer(bytes));
            jog.start(1, 1, 20);
            await clock.advance(300);
            jog.stop();
            await clock.advance(gap);
            session.robot.setGoal(1, 200);
            await clock.advance(2000);
            assert.equal(goals().at(-1), rawOfDegrees(200), `${goals().slice(-3)}`);
            assert.equal(session.robot.servos.get(1).goalState, "confirmed");
        });
