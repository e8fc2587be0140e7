// SPDX-License-Identifier: MIT
/* The robot: feedback, goals and torque, at a fake port and a fake clock. */

import assert from "node:assert/strict";
import test from "node:test";
import { Controller } from "../../src/model/controller.js";
import { GOAL_AGE_MS, GOAL_PERIOD_MS, Robot } from "../../src/model/robot.js";
import { INSTRUCTION, wordAt, write } from "../../src/wire/packet.js";
import { Wire } from "../../src/wire/wire.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort, status } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const GOAL = 0x1e;
const SPEED = 0x20;
const TORQUE = 0x18;

async function rig({ ids = [1, 2], torque = 1, start = true } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const wire = new Wire(port, { clock });
    const robot = new Robot(new Controller(wire, tables()));
    const notices = [];

    robot.addEventListener("notice", ({ detail }) => notices.push(detail));
    ids.forEach((id) => port.addServo(id, torque));
    await wire.open();
    robot.setServos(ids);
    if (start) {
        robot.start();
        await clock.advance(100);
    }
    return { clock, port, wire, robot, notices, servo: robot.servos.get(ids[0]) };
}

/* Goals that were written, as [ID, goal, speed]. */
const goals = (port) =>
    port.packets
        .filter((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL)
        .map((bytes) => [bytes[2], wordAt(bytes, 6), wordAt(bytes, 8)]);

test("feedback: values of all servos", async () => {
    const { robot, servo } = await rig();

    assert.equal(servo.position.toFixed(1), "150.1");
    assert.equal(servo.voltage, 12);
    assert.equal(servo.temperature, 32);
    assert.equal(servo.torque, true);
    assert.equal(servo.presence, "online");
    assert.equal(servo.high, 300);
    assert.ok(robot.rate > 0);
});

test("feedback: a servo that fails is offline, the others go on", async () => {
    const { robot, port, clock } = await rig();

    port.offline.add(2);
    await clock.advance(100);
    assert.equal(robot.servos.get(2).presence, "offline");
    assert.equal(robot.servos.get(2).torque, null);
    assert.equal(robot.servos.get(1).presence, "online");
    assert.ok(!robot.servos.get(1).isOld(clock.now()));
    await clock.advance(1000);
    assert.ok(robot.servos.get(2).isOld(clock.now()));
});

test("feedback: 50 servos are asked in groups of 31", async () => {
    const { port } = await rig({ ids: Array.from({ length: 50 }, (_, index) => index + 1) });
    const sizes = new Set(port.packets.filter((bytes) => bytes[4] === INSTRUCTION.SYNC_READ && bytes[5] === 0x24)
        .map((bytes) => bytes.length - 8));

    assert.deepEqual(sizes, new Set([31, 19]));
});

test("feedback: goes on after a timeout", async () => {
    const { port, clock, servo } = await rig();

    port.isMute = true;
    await clock.advance(1000);
    assert.ok(servo.isOld(clock.now()));
    port.isMute = false;
    await clock.advance(3000);
    assert.ok(!servo.isOld(clock.now()));
});

test("feedback: an ID that no servo can have does not end it", async () => {
    const { robot, port, clock, servo } = await rig();

    robot.setServos([1, 303]);
    assert.deepEqual(robot.ids, [1]);
    port.servos.get(1)[0x24] = 7;
    await clock.advance(200);
    assert.equal(servo.raw.position, 0x207);
});

test("feedback: an error of the page is told and does not end it", async () => {
    const { robot, port, clock, notices, servo } = await rig();
    const take = servo.takeFeedback;

    servo.takeFeedback = () => assert.fail("broken");
    await clock.advance(200);
    assert.equal(notices[0].message, "broken");
    servo.takeFeedback = take;
    port.servos.get(1)[0x24] = 7;
    await clock.advance(200);
    assert.equal(servo.raw.position, 0x207);
});

test("feedback: the reply to a packet that was not carried out is no data", async () => {
    const { robot, port, clock, wire, notices } = await rig();
    const controller = new Controller(wire, tables());
    const resets = [];
    const found = [];

    robot.addEventListener("reset", () => resets.push(1));
    await clock.advance(1000);
    port.onPacket = (bytes) => {
        port.answer(status(bytes[2] === 254 ? 253 : bytes[2], 0x40)); // instruction error
        return true;
    };
    const code = controller.scanByPackets({ onFound: (servo) => found.push(servo) }).then(() => "ok", (error) => error.code);

    await clock.advance(2000);
    assert.deepEqual([await code, found, resets], ["refused", [], []]);
    assert.equal(robot.servos.get(1).presence, "online");
    assert.equal(robot.device.resetCause, 0);
    assert.ok(notices.some((notice) => notice.code === "refused"));
});

test("feedback: ends when the port is lost", async () => {
    const { port, clock } = await rig();

    port.unplug();
    const count = port.written.length;

    await clock.advance(10000);
    assert.equal(port.written.length, count);
});

test("goal: the mode of the servo is read again after what a user sends, and what changes a servo", async () => {
    for (const sent of [{ source: "hand", text: "turn 1 0", bytes: [] }, { source: "hand", bytes: [] }, { source: "page", text: "id 2 1", bytes: [] },
        { source: "page", bytes: write(1, 6, [0, 0, 0, 0]) }]) {
        const { robot, port, clock, servo } = await rig();

        robot.setGoal(1, 160);
        await clock.advance(100);
        port.servos.get(1).set([0, 0, 0, 0], 6); // endless turn
        robot.note(sent);
        robot.setGoal(1, 170);
        await clock.advance(20);
        assert.equal(goals(port).length, 1);
        assert.equal(servo.goalState, "dropped");
        assert.equal(servo.isEndless, true);
    }
});

test("goal: one that waits behind a line by hand does not leave", async () => {
    const { robot, port, clock, wire, servo } = await rig();

    wire.addEventListener("traffic", ({ detail }) => detail.direction === "out" && robot.note(detail));
    robot.setGoal(1, 160);
    await clock.advance(100);
    port.onText = (line) => line === "ping 1";
    const order = () => {
        wire.command("ping 1"); // of the page: the mode stays known
        wire.command("turn 1 0", { source: "hand" });
        robot.setGoal(1, 170);
    };

    robot.addEventListener("feedback", order, { once: true });
    await clock.advance(50);
    port.servos.get(1).set([0, 0, 0, 0], 6);
    port.say("ok"); // of ping
    await clock.advance(500);
    assert.ok(port.lines.includes("turn 1 0"));
    assert.equal(goals(port).length, 1);
    assert.equal(servo.goalState, "dropped");
});

test("hold: ends the turn of a servo that has just begun endless turn", async () => {
    const { robot, port, clock } = await rig();

    port.servos.get(1).set([0, 0, 0, 0], 6);
    port.servos.get(1).set([0xff, 0], SPEED);
    robot.note({ source: "hand", text: "turn 1 50", bytes: [] });
    const held = robot.hold(1);

    await clock.advance(100);
    await held;
    assert.equal(wordAt(port.servos.get(1), SPEED), 0);
});

test("goal: sent once, at 20 rpm", async () => {
    const { robot, port, clock, servo } = await rig();

    assert.equal(robot.setGoal(1, 90), true);
    await clock.advance(1000);
    assert.deepEqual(goals(port), [[1, 307, 330]]);
    assert.equal(servo.goalState, "confirmed");
});

test("goal: ignored while torque is off or not known", async () => {
    const { robot, port, clock } = await rig({ torque: 0 });

    assert.equal(robot.setGoal(1, 90), false);
    robot.servos.get(1).torque = null;
    assert.equal(robot.setGoal(1, 90), false);
    assert.equal(robot.setGoal(77, 90), false);
    await clock.advance(1000);
    assert.deepEqual(goals(port), []);
});

test("goal: ignored while driving is inhibited", async () => {
    const { robot, port, clock } = await rig();

    port.device[0x17] = 1;
    await clock.advance(500);
    assert.equal(robot.isInhibited, true);
    assert.equal(robot.setGoal(1, 90), false);
});

test("goal: at most 20 a second, the newest wins", async () => {
    const { robot, port, clock } = await rig();

    for (let ms = 0; ms < 1000; ms += 5) {
        robot.setGoal(1, 100 + ms / 100);
        await clock.advance(5);
    }
    await clock.advance(200);
    const sent = goals(port);

    assert.ok(sent.length <= 1000 / GOAL_PERIOD_MS + 1 && sent.length >= 10, `${sent.length} goals`);
    assert.equal(sent.at(-1)[1], Math.round((109.95 * 1023) / 300));
});

test("goal: dropped if the wire is busy for too long", async () => {
    const { robot, port, wire, clock, servo } = await rig();

    port.onText = (line) => line === "save";
    const command = wire.command("save");

    robot.setGoal(1, 90);
    await clock.advance(GOAL_AGE_MS + 50);
    port.say("ok");
    await command;
    await clock.advance(1000);
    assert.deepEqual(goals(port), []);
    assert.equal(servo.goalState, "dropped");
});

test("goal: unanswered is unconfirmed and never sent again", async () => {
    const { robot, port, clock, servo, notices } = await rig();

    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.WRITE;
    robot.setGoal(1, 90);
    await clock.advance(3000);
    assert.equal(goals(port).length, 1);
    assert.equal(servo.goalState, "unconfirmed");
    assert.deepEqual(notices, [{ code: "goal-unconfirmed", id: 1, why: "" }]);
});

test("goal: refused by the servo", async () => {
    const { robot, port, clock, servo, notices } = await rig();

    port.refusals.set(1, 0x02);
    robot.setGoal(1, 90);
    await clock.advance(500);
    assert.equal(servo.goalState, "refused");
    assert.deepEqual(notices, [{ code: "goal-refused", id: 1, why: "angle limit" }]);
});

test("goal: a stop drops the goals that wait", async () => {
    const { robot, port, wire, clock } = await rig();

    robot.setGoal(1, 90);
    robot.setGoal(2, 90);
    robot.forgetGoals();
    const stop = wire.stop({ servos: robot.ids });

    assert.equal(robot.setGoal(1, 10), false);
    await clock.advance(5000);
    assert.equal((await stop).verified, true);
    assert.deepEqual(goals(port), []);
});

test("goal: dropped with its servo, and a stop copes", async () => {
    const { robot, port, clock } = await rig();

    robot.setGoal(1, 90);
    robot.setServos([2]);
    robot.forgetGoals();
    robot.setServos([1, 2]);
    await clock.advance(1000);
    assert.deepEqual(goals(port), []);
});

/* Speeds that were written alone, as [ID, speed]. */
const turns = (port) =>
    port.packets
        .filter((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === SPEED)
        .map((bytes) => [bytes[2], wordAt(bytes, 6)]);

test("turn: the speed has a sign, and hold ends it", async () => {
    const { robot, port, clock } = await rig();

    port.servos.get(1).set([0, 0, 0, 0], 0x06);
    await clock.advance(1500);
    assert.equal(robot.servos.get(1).isEndless, true);
    assert.equal(robot.setTurn(1, 20), true);
    await clock.advance(100);
    robot.setTurn(1, -20);
    await clock.advance(100);
    await Promise.all([robot.hold(1), clock.advance(100)]);
    assert.deepEqual(turns(port), [[1, 330], [1, 330 | 0x400], [1, 0]]);
    assert.deepEqual(goals(port), []);
});

test("turn: a servo that turns already is told once", async () => {
    const { robot, port, clock, notices } = await rig({ start: false });

    for (const id of [1, 2]) port.servos.get(id).fill(0, 6, 10);
    port.servos.get(1).set([0x4a, 0x05], SPEED);
    robot.start();
    await clock.advance(3000);
    robot.setTurn(2, 20);
    await clock.advance(3000);
    assert.deepEqual(notices, [{ code: "turning", id: 1 }]);
});

test("hold: makes the position the goal, drops the waiting goal", async () => {
    const { robot, port, clock } = await rig();

    robot.setGoal(1, 90);
    await clock.advance(20);
    robot.setGoal(1, 60); // waits for its turn
    port.servos.get(1).set([0x2c, 0x01], 0x24);
    await Promise.all([robot.hold(1), clock.advance(500)]);
    assert.deepEqual(goals(port), [[1, 307, 330], [1, 300, 330]]);
});

test("hold: waits for a busy wire, it is never dropped", async () => {
    const { robot, port, wire, clock } = await rig();

    port.onText = (line) => line === "save";
    const command = wire.command("save");
    const hold = robot.hold(1);

    await clock.advance(GOAL_AGE_MS + 500);
    assert.deepEqual(goals(port), []);
    port.say("ok");
    await command;
    await Promise.all([hold, clock.advance(500)]);
    assert.deepEqual(goals(port), [[1, 512, 330]]);
});

test("hold: a line behind the read of the position leads to no old goal", async () => {
    const { robot, port, wire, clock } = await rig();
    let command = null;

    port.onText = (line) => line === "save";
    port.onPacket = (bytes) => {
        if (bytes[2] === 1 && bytes[4] === INSTRUCTION.READ) command ??= wire.command("save", { timeout: 60000 });
        return false;
    };
    const hold = robot.hold(1);

    await clock.advance(10000);
    assert.ok(command);
    assert.deepEqual(goals(port), []);
    port.servos.get(1).set([0x2c, 0x01], 0x24);
    port.say("ok");
    await command;
    await Promise.all([hold, clock.advance(500)]);
    assert.deepEqual(goals(port), [[1, 300, 330]]);
});

test("hold: stays within the angle limits", async () => {
    const { robot, port, clock } = await rig();

    port.servos.get(1).set([0x00, 0x01, 0xf0, 0x01], 0x06);
    await clock.advance(1500);
    await Promise.all([robot.hold(1), clock.advance(100)]);
    assert.deepEqual(goals(port), [[1, 0x1f0, 330]]);
});

test("hold: does nothing after a stop", async () => {
    const { robot, port, wire, clock } = await rig();

    robot.forgetGoals();
    const stop = wire.stop({ servos: robot.ids });

    await robot.hold(1);
    await clock.advance(1000);
    robot.takeStop(await stop);
    await robot.hold(1);
    assert.deepEqual(goals(port), []);
});

test("stop: isInhibited is true once the stop is confirmed", async () => {
    const { robot } = await rig({ start: false });

    robot.takeStop({ inhibited: true, off: [1, 2], on: [] });
    assert.ok(robot.isInhibited);
    robot.takeStop({ inhibited: false, off: [1, 2], on: [] });
    assert.ok(robot.isInhibited, "a stop that is not confirmed says nothing of the inhibit");
});

test("torque of all: a servo that fails is told, the others go on", async () => {
    const { robot, port, clock } = await rig({ ids: [1, 2, 3], torque: 0 });
    const failed = [];

    port.refusals.set(2, 0x08);
    await Promise.all([robot.setTorqueAll(true, (error) => failed.push([error.code, error.id])), clock.advance(1000)]);
    assert.deepEqual(failed, [["refused", 2]]);
    assert.deepEqual([1, 2, 3].map((id) => port.servos.get(id)[TORQUE]), [1, 0, 1]);
});

test("torque of all: while driving is inhibited each servo is named", async () => {
    const { robot, clock } = await rig({ ids: [1, 2, 3], torque: 0 });

    robot.device.inhibit = 1;
    await Promise.all([assert.rejects(robot.setTorqueAll(true, () => {}), { code: "inhibited", ids: [1, 2, 3] }), clock.advance(10)]);
});

test("torque of all: a stop ends it", async () => {
    const { robot, port, wire, clock } = await rig({ ids: [1, 2, 3], torque: 0, start: false });

    robot.servos.forEach((servo) => (servo.presence = "online"));
    const code = robot.setTorqueAll(true, () => {}).then(() => "ok", (error) => error.code);
    const stop = wire.stop({ servos: robot.ids });

    await clock.advance(2000);
    assert.equal(await code, "stopped");
    assert.equal((await stop).verified, true);
    assert.deepEqual([1, 2, 3].map((id) => port.servos.get(id)[TORQUE]), [0, 0, 0]);
});

test("hold: an endless turn whose end is lost is not shown as confirmed", async () => {
    const { robot, port, clock, servo } = await rig();

    port.servos.get(1).fill(0, 6, 10);
    await clock.advance(1500);
    robot.setTurn(1, 20);
    await clock.advance(200);
    assert.equal(servo.goalState, "confirmed");
    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.WRITE;
    const code = robot.hold(1).then(() => "ok", (error) => error.code);

    await clock.advance(2000);
    assert.equal(await code, "turn-not-ended");
    assert.equal(servo.goalState, "unconfirmed");
});

test("torque of all: off cancels on", async () => {
    const { robot, port, clock } = await rig({ ids: [1, 2, 3], torque: 0 });
    const torques = () => [1, 2, 3].map((id) => port.servos.get(id)[TORQUE]);
    const fail = (error) => assert.fail(error);
    let off = null;

    port.onPacket = (bytes) => {
        if (bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL) off ??= robot.setTorqueAll(false, fail);
    };
    await Promise.all([robot.setTorqueAll(true, fail), clock.advance(1000)]);
    await off;
    assert.deepEqual(torques(), [0, 0, 0]);
    off = true;
    const on = robot.setTorqueAll(true, fail);
    const one = robot.setTorque(2, false);

    await Promise.all([on, one, clock.advance(1000)]);
    assert.deepEqual(torques(), [1, 0, 1]);
});

test("torque on: not tried while driving is inhibited", async () => {
    const { robot, port, clock } = await rig({ torque: 0 });

    port.device[0x17] = 1;
    await clock.advance(500);
    await assert.rejects(robot.setTorque(1, true), { code: "inhibited" });
    assert.deepEqual(goals(port), []);
});

test("alarms: cleared by the device", async () => {
    const { robot, port, clock } = await rig();

    port.device[0x14] = 0x04;
    await clock.advance(500);
    assert.equal(robot.device.alarms, 0x04);
    await Promise.all([robot.clearAlarms(), clock.advance(500)]);
    assert.equal(robot.device.alarms, 0);
});

test("servos: packets find those beyond the 18 of the console", async () => {
    const ids = Array.from({ length: 40 }, (_, index) => 2 * index + 1);
    const { robot, port, clock } = await rig({ ids, start: false });
    const listed = ids.slice(0, 18);
    let isKnown = false;

    port.onText = (line) => {
        if (line === "servos") port.say(...(isKnown ? listed.map((id) => `servo ${id}: online, torque off`) : ["no servo known"]), "ok");
        if (line === "scan") port.say(...listed.map((id) => `id ${id} model 1`), "40 found, 254 asked", "ok");
        return line === "servos" || line === "scan";
    };
    for (isKnown of [false, true]) {
        robot.setServos([]);
        await Promise.all([robot.findServos(), clock.advance(1000)]);
        assert.deepEqual(robot.ids, ids, isKnown ? "known" : "by a scan");
    }
});

test("scan by packets: all IDs except the device's", async () => {
    const { port, wire, clock } = await rig({ ids: [0, 250, 253], start: false });
    const controller = new Controller(wire, tables());
    const scan = async () => {
        const found = [];

        port.written = [];
        await Promise.all([controller.scanByPackets({ onFound: ({ id }) => found.push(id) }), clock.advance(1000)]);
        return { found, asked: port.packets.flatMap((bytes) => [...bytes.slice(7, -1)]) };
    };
    const { found, asked } = await scan();

    assert.deepEqual(asked, Array.from({ length: 253 }, (_, id) => id));
    assert.deepEqual(found, [0, 250]);
    wire.deviceId = 100;
    port.onPacket = (bytes) => port.answer(status(100, 0, [...bytes.slice(7, -1)])); // each servo has its ID
    assert.deepEqual((await scan()).found, Array.from({ length: 254 }, (_, id) => id).filter((id) => id !== 100));
});

test("rate: sinks while no feedback comes", async () => {
    const { robot, port, clock } = await rig();

    await clock.advance(1000);
    assert.ok(robot.rate > 10);
    port.isMute = true;
    await clock.advance(1500);
    assert.equal(robot.rate, 0);
});

test("torque on: the goal becomes the present position first", async () => {
    const { robot, port, servo } = await rig({ torque: 0, start: false });

    port.servos.get(1).set([0x34, 0x01], 0x24);
    await robot.setTorque(1, true);
    const writes = port.packets.filter((bytes) => bytes[2] === 1 && bytes[4] === INSTRUCTION.WRITE);

    assert.deepEqual(goals(port), [[1, 0x134, 330]]);
    assert.deepEqual(writes.map((bytes) => bytes[5]), [GOAL, TORQUE]);
    assert.equal(servo.torque, true);
});

test("torque on: a servo in endless turn stands still", async () => {
    const { robot, port } = await rig({ torque: 0, start: false });

    port.servos.get(1).set([0, 0, 0, 0], 0x06);
    await robot.setTorque(1, true);
    assert.equal(goals(port)[0][2], 0);
});

test("torque on: stays off if the goal is not kept", async () => {
    const { robot, port } = await rig({ torque: 0, start: false });

    Object.defineProperty(port.servos.get(1), "set", { value: () => {} }); // it forgets what it is told
    port.servos.get(1)[0x1e] = 99;
    await assert.rejects(robot.setTorque(1, true), { code: "goal-not-kept" });
    assert.equal(port.servos.get(1)[TORQUE], 0);
    assert.ok(!port.packets.some((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === TORQUE));
});

test("torque on: a servo that does not answer is named", async () => {
    const { robot, port, clock } = await rig({ torque: 0 });

    port.offline.add(2);
    for (const isOn of [true, false]) {
        const failed = assert.rejects(robot.setTorque(2, isOn), { code: "servo-silent", id: 2 });

        await clock.advance(2000);
        await failed;
    }
});

test("torque on: a stop between its steps keeps it off", async () => {
    const { robot, port, wire, clock } = await rig({ torque: 0, start: false });
    const code = robot.setTorque(1, true).then(() => "ok", (error) => error.code);
    const stop = wire.stop({ servos: [1] });

    await clock.advance(1000);
    assert.equal(await code, "stopped");
    assert.equal((await stop).verified, true);
    assert.equal(port.servos.get(1)[TORQUE], 0);
});

test("torque on: a servo that is inhibited by itself is told as inhibited, the others go on", async () => {
    const { robot, port, clock } = await rig({ torque: 0 });
    const errors = [];

    port.onText = (line) => line === "servos" && (port.say("servo 1: online, torque off, inhibited: lost its state", "servo 2: online, torque off", "ok"), true);
    port.onPacket = (bytes) => bytes[2] === 1 && bytes[4] === INSTRUCTION.WRITE; // the controller sends no packet that drives it
    await Promise.all([robot.setTorqueAll(true, ({ code, id }) => errors.push([code, id])), clock.advance(3000)]);
    assert.deepEqual(errors, [["inhibited", 1]]);
    assert.equal(port.servos.get(2)[TORQUE], 1);
});

test("torque off: one packet", async () => {
    const { robot, port, servo } = await rig({ start: false });

    await robot.setTorque(1, false);
    assert.equal(port.servos.get(1)[TORQUE], 0);
    assert.equal(servo.torque, false);
});

test("servos: a line of the command tells inhibit and alarms", async () => {
    const { port, clock, robot } = await rig();

    port.onText = (line) => line === "servos" && (port.say(
        "servo 1: online, torque off, inhibited: lost its state",
        "servo 2: online, torque on, alarms: overheating + overload", "ok"), true);
    port.device[0x14] = 0x24;
    await clock.advance(1000);
    assert.equal(robot.servos.get(1).inhibit, "lost");
    assert.deepEqual(robot.servos.get(2).alarms, ["overheating", "overload"]);
});
