// SPDX-License-Identifier: MIT
/* Counters, settings, alarms and packets by hand, at the real firmware of each profile. */

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { readAlarms, readStatus } from "../../src/model/board.js";
import { sendLine, sendPacket } from "../../src/model/by_hand.js";
import { readCounters } from "../../src/model/counters.js";
import { Session } from "../../src/model/session.js";
import { Settings } from "../../src/model/settings.js";
import { ping, read, syncWrite, write } from "../../src/wire/packet.js";
import { PtyPort, Simulator } from "../support/simulator.js";
import { tables } from "../support/tables.js";

/* A session that is connected to a simulated board. It ends with the test. */
async function connected(t, options = {}) {
    const simulator = await Simulator.start(options);
    const session = new Session({ tables: tables() });

    t.after(async () => {
        await session.disconnect();
        session.withdraw(session.notices.map(({ code }) => code)); // no timer of them keeps the test
        await simulator.end();
    });
    await session.connect(new PtyPort(simulator.path));
    assert.equal(session.state, "connected");
    return { session, simulator };
}

const FIRMWARES = [
    { board: "atmega128", elf: "controller", profile: "full" },
    { board: "arbotix", elf: "controller", profile: "console" },
    { board: "atmega128", elf: "bridge", profile: "bridge" },
];

for (const { board, elf, profile } of FIRMWARES) {
    test(`${profile}: counters of the bus and of the host link`, async (t) => {
        const { session } = await connected(t, { board, elf });

        assert.equal(session.controller.profile, profile);
        const { rows } = await readCounters(session.controller);
        const row = (key) => rows.find((one) => one.key === key);

        assert.equal(rows.length, 27);
        assert.ok(row("sent").count > 0);
        assert.ok(row("host_packets").count > 0);
        assert.equal(row("timeouts").ofScan > 0, profile === "full");
    });

    test(`${profile}: a setting is put in force, saved, and set back`, async (t) => {
        const { session } = await connected(t, { board, elf });
        const settings = new Settings(session);

        await settings.read();
        assert.equal(settings.values.size, tables().settings.length);
        assert.equal(settings.values.get("cycle_us"), 4000);
        assert.equal(settings.values.get("echo"), 2);
        await settings.apply({ cycle_us: 5000, link_loss_ms: 700 });
        await settings.save();
        await settings.read();
        assert.equal(settings.values.get("cycle_us"), 5000);
        assert.equal(settings.values.get("link_loss_ms"), 700);
        await settings.defaults();
        await settings.read();
        assert.equal(settings.values.get("cycle_us"), 4000);
        assert.equal(settings.values.get("echo"), 2);
    });

    test(`${profile}: status and alarms`, async (t) => {
        const { session } = await connected(t, { board, elf });

        while (!session.robot.device) await new Promise((resolve) => session.addEventListener("change", resolve, { once: true }));
        const status = await readStatus(session);

        assert.ok(status.some(({ label, text }) => label === "Last reset by" && text === "power"));
        assert.equal(status.some(({ isDetail }) => isDetail), profile !== "bridge");
        await sendPacket(session, write(1, 0x06, [0xff, 0xff])); // out of range
        const alarmed = () => (session.wire.hasConsole ? true : session.robot.device.alarms !== 0);

        while (!alarmed()) await new Promise((resolve) => session.addEventListener("change", resolve, { once: true }));
        assert.deepEqual(await readAlarms(session), [{ who: "Servo 1", condition: "range" }]);
        await session.robot.clearAlarms();
        while (!(session.wire.hasConsole || session.robot.device.alarms === 0))
            await new Promise((resolve) => session.addEventListener("change", resolve, { once: true }));
        assert.deepEqual(await readAlarms(session), []);
    });
}

test("settings: saved ones and the mode survive power-off", async (t) => {
    const folder = mkdtempSync(join(tmpdir(), "panel-"));
    const options = ["--eeprom", join(folder, "eeprom")];
    const simulator = await Simulator.start({ options });
    const session = new Session({ tables: tables() });

    t.after(() => rmSync(folder, { recursive: true }));
    await session.connect(new PtyPort(simulator.path));
    const settings = new Settings(session);

    await settings.read();
    await settings.apply({ repeats: 1 });
    await settings.save();
    await session.disconnect();
    await simulator.end();
    const { session: again } = await connected(t, { options });
    const kept = new Settings(again);

    await kept.read();
    assert.equal(kept.values.get("repeats"), 1);
    assert.equal(kept.values.get("echo"), 2);
    assert.equal(kept.origin, "as saved");
});

test("by hand: replies of one servo, none due, absent servo", async (t) => {
    const { session } = await connected(t);
    const [reply] = await sendPacket(session, read(1, 0x24, 2));

    assert.equal(reply.parameters.length, 2);
    assert.deepEqual(await sendPacket(session, syncWrite(0x19, 1, [[1, [1]], [2, [1]]])), []);
    await assert.rejects(sendPacket(session, ping(99)), { code: "timeout" });
    assert.equal((await sendPacket(session, ping(1)))[0].id, 1);
});

test("by hand: a driving packet is refused while inhibited", async (t) => {
    const { session } = await connected(t);

    await session.stop();
    assert.equal(session.stopState, "verified");
    await assert.rejects(sendPacket(session, write(1, 0x18, [1])), { code: "timeout" });
    const { rows } = await readCounters(session.controller);

    assert.equal(rows.find(({ key }) => key === "bridge_refused").count, 1);
    await session.release();
    assert.equal((await sendPacket(session, write(1, 0x18, [1])))[0].error, 0);
});

test("by hand: a key ends a running line, a stop cancels it", async (t) => {
    const { session } = await connected(t);
    const end = new AbortController();
    const lines = [];
    const onLine = (text) => {
        lines.push(text);
        end.abort();
    };
    const reply = await sendLine(session, "monitor 1 as plot", { onLine, signal: end.signal });

    assert.equal(reply.error, null);
    assert.ok(lines.length > 0);
    await assert.rejects(
        sendLine(session, "monitor 1 as plot", { onLine: () => session.stop() }),
        { code: "stopped" },
    );
});

test("traffic: what was sent by hand is told from the polling", async (t) => {
    const { session } = await connected(t);

    await sendPacket(session, read(1, 0x1e, 2));
    const shown = session.traffic.select({ group: "READ", id: 1 }, 200).map((row) => session.traffic.describe(row));

    assert.deepEqual(shown.map(({ name, text }) => `${name} ${text}`), ["READ GOAL_POSITION", "ok GOAL_POSITION 150.1°"]);
    assert.equal(session.traffic.select({ group: "SYNC READ" }, 200).length, 0);
    assert.ok(session.traffic.select({ group: "SYNC READ", withPolling: true }, 200).length > 0);
});

test("capture: a long session of 18 servos plays: its gap is behind the start-up, between two lines", async (t) => {
    const { session } = await connected(t, { servos: "1-18" });
    const { capture } = session;

    capture.onBytes = () => {};
    Object.assign(capture.port, { write: () => {} });
    for (let count = 0; count < 25000; count++) { // as after some hours
        capture.write(ping(99));
        capture.port.onBytes(ping(99));
    }
    const { ReplayPort } = await import("../../src/port/replay.js");
    const replayed = new Session({ tables: tables() });

    t.after(() => replayed.disconnect());
    await replayed.connect(new ReplayPort(capture.text));
    assert.equal(replayed.state, "connected");
    assert.equal(replayed.robot.ids.length, 18);
    const [before, behind] = capture.text.split(/# .*\n/);

    assert.match(before, /in .*\n$/);
    assert.match(behind, /^out /);
});

test("capture: a session can be played again", async (t) => {
    const { session } = await connected(t);

    while (session.robot.rate < 5) await new Promise((resolve) => session.addEventListener("feedback", resolve, { once: true }));
    await session.stop();
    const { ReplayPort } = await import("../../src/port/replay.js");
    const replayed = new Session({ tables: tables() });

    t.after(() => replayed.disconnect());
    await replayed.connect(new ReplayPort(session.capture.text));
    assert.equal(replayed.state, "connected");
    assert.deepEqual(replayed.robot.ids, [1, 2, 3]);
    while (replayed.robot.rate < 5) await new Promise((resolve) => replayed.addEventListener("feedback", resolve, { once: true }));
    await replayed.stop(); // the capture has the stop of the robot
    assert.equal(replayed.stopState, "none");
    assert.deepEqual(replayed.notices.map(({ code, level }) => [code, level]), [["stop-replay", "info"]]);
});
