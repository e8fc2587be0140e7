// SPDX-License-Identifier: MIT
/* Torque while a command of the console has the wire, at a fake port and a fake clock. */

import assert from "node:assert/strict";
import test from "node:test";
import { sendLine, sendPacket } from "../../src/model/by_hand.js";
import { Session } from "../../src/model/session.js";
import { INSTRUCTION, word, wordAt, write } from "../../src/wire/packet.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const GOAL = 0x1e;
const POSITION = 0x24;
const TORQUE = 0x18;

/* A session whose port answers each packet after `delay` ms. A search of the view Set-up runs until the test ends it. */
async function rig({ ids = [1], torque = 0, delay = 3 } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });
    const answer = port.answer.bind(port);

    port.answer = (bytes) => clock.after(delay, () => answer(bytes));
    port.onText = (line) => line.startsWith("scan");
    for (const id of ids) port.addServo(id, torque);
    const connected = session.connect(port);

    await clock.advance(3000);
    await connected;
    port.written = [];
    const search = async (ms) => {
        const done = session.controller.run("scan", { timeout: 30000 });

        for (const end = clock.now() + ms; clock.now() < end; await clock.advance(1000)) port.say("1 of 254 asked");
        port.say("0 found", "ok");
        await clock.advance(1000);
        await done;
    };

    return { clock, port, session, robot: session.robot, search };
}

const writes = (port, address) =>
    port.packets.filter((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === address).map((bytes) => [bytes[2], bytes[6]]);
const notice = ({ notices }, code) => notices.find((one) => one.code === code);
const moveTo = (port, id, raw) => port.servos.get(id).set(word(raw), POSITION);

for (const step of ["limits", "position", "goal", "read back"])
    test(`torque on: a command behind the step "${step}" does not lead to an old goal`, async () => {
        const { clock, port, session, robot, search } = await rig();
        const reads = { limits: 0x06, position: POSITION, goal: GOAL, "read back": GOAL };
        const instruction = step === "goal" ? INSTRUCTION.WRITE : INSTRUCTION.READ;
        let searched = null;

        port.onPacket = (bytes) => {
            if (bytes[2] === 1 && bytes[4] === instruction && bytes[5] === reads[step]) searched ??= search(20000);
            return false;
        };
        const done = session.attempt(() => robot.setTorque(1, true));

        await clock.advance(100);
        assert.ok(searched);
        moveTo(port, 1, 256);
        await searched;
        await clock.advance(1000);
        await done;
        const registers = port.servos.get(1);

        assert.deepEqual([registers[TORQUE], robot.servos.get(1).torque], [0, false]);
        assert.match(notice(session, "torque-on-late").text, /^Torque of servo 1 stays off/);
    });

test("torque on: begins again with the position if the joint moves meanwhile", async () => {
    const { clock, port, robot } = await rig();
    let moves = 1;

    port.onPacket = (bytes) => {
        if (bytes[2] === 1 && bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL && moves-- > 0) moveTo(port, 1, 400);
        return false;
    };
    const done = robot.setTorque(1, true);

    await clock.advance(1000);
    await done;
    assert.deepEqual([wordAt(port.servos.get(1), GOAL), port.servos.get(1)[TORQUE]], [400, 1]);
});

test("torque on: stays off while the joint moves", async () => {
    const { clock, port, session, robot } = await rig();
    let position = 300;

    port.onPacket = (bytes) => {
        if (bytes[2] === 1 && bytes[4] === INSTRUCTION.WRITE) moveTo(port, 1, (position += 40));
        return false;
    };
    const done = session.attempt(() => robot.setTorque(1, true));

    await clock.advance(2000);
    await done;
    assert.equal(writes(port, TORQUE).length, 0);
    assert.match(notice(session, "joint-moves").text, /^Servo 1 moved/);
});

for (const isOn of [true, false])
    test(`torque ${isOn ? "on" : "off"}: dropped if a command has the wire, and told`, async () => {
        const { clock, port, session, robot, search } = await rig({ torque: isOn ? 0 : 1 });
        const searched = search(20000);

        await clock.advance(100);
        const done = session.attempt(() => robot.setTorque(1, isOn));

        await searched;
        await clock.advance(1000);
        await done;
        assert.deepEqual(writes(port, TORQUE), []);
        assert.ok(notice(session, isOn ? "torque-on-late" : "torque-off-late"), JSON.stringify(session.notices));
    });

test("torque late: told while the command still runs", async () => {
    const { clock, session, robot, search } = await rig();

    search(20000);
    await clock.advance(100);
    session.attempt(() => robot.setTorque(1, true));
    await clock.advance(2100);
    assert.ok(notice(session, "torque-on-late"));
    await clock.advance(20000);
});

test("torque of all: a command ends it, the servos that are left are named", async () => {
    const { clock, port, session, robot, search } = await rig({ ids: [1, 2, 3] });
    let searched = null;

    port.onPacket = (bytes) => {
        if (bytes[2] === 2 && bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL) searched ??= search(20000);
        return false;
    };
    const done = session.attempt(() => robot.setTorqueAll(true, session.notify.bind(session)));

    await clock.advance(100);
    await searched;
    await clock.advance(3000);
    await done;
    assert.deepEqual(writes(port, TORQUE), [[1, 1]]);
    assert.match(notice(session, "torque-on-late").text, /^Torque of servos 2, 3 stays off/);
});

test("release: dropped if a command has the wire", async () => {
    const { clock, port, session, search } = await rig();
    const searched = search(20000);

    await clock.advance(100);
    session.release();
    await searched;
    await clock.advance(1000);
    assert.ok(!port.lines.includes("release"));
    assert.ok(notice(session, "late"));
});

test("packet and line by hand: dropped if a command has the wire", async () => {
    const { clock, port, session, search } = await rig();
    const searched = search(20000);
    const bytes = write(1, TORQUE, [1]);

    await clock.advance(100);
    const codes = [sendPacket(session, bytes), sendLine(session, "set 1 TORQUE_ENABLE 1")].map((sent) => sent.then(() => "sent", ({ code }) => code));

    await searched;
    await clock.advance(1000);
    assert.deepEqual(await Promise.all(codes), ["late", "late"]);
    assert.deepEqual([writes(port, TORQUE), port.lines.filter((line) => line.startsWith("set"))], [[], []]);
});
