// SPDX-License-Identifier: MIT
/* Counters, status, alarms and settings, from the lines and registers of a controller. */

import assert from "node:assert/strict";
import test from "node:test";
import { parseAlarms, parseStatus } from "../../src/model/board.js";
import { countedFrom, counterRows, healthOf, parseCounters, readCounters, startOf } from "../../src/model/counters.js";
import { Session } from "../../src/model/session.js";
import { Settings, risksOf } from "../../src/model/settings.js";
import { INSTRUCTION } from "../../src/wire/packet.js";
import { texts } from "../../src/texts/texts.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort, status } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const all = tables();

/* ---- counters ---- */

test("parseCounters: count, part of scan, and since when", () => {
    const { since, counts } = parseCounters(["since the reset, 0 s ago", "sent 266, of these 257 by scan and diagnose", "stale replies 3"]);

    assert.equal(since, "since the reset, 0 s ago");
    assert.deepEqual(counts.get("sent"), { count: 266, ofScan: 257 });
    assert.deepEqual(counts.get("stale_replies"), { count: 3, ofScan: 0 });
});

test("counterRows: all counters of the device and nothing else", () => {
    const names = counterRows(all).map(({ name }) => name);

    assert.equal(names.length, 27);
    assert.equal(names[0], "BUS_SENT");
    for (const name of ["BUS_BAUD", "HOST_BAUD", "BUS_STATE", "FAILED"]) assert.ok(!names.includes(name), name);
});

test("healthOf: ignores counts of a scan; each trouble has a text", () => {
    const rows = [{ key: "timeouts", count: 251, ofScan: 251 }, { key: "corrupt", count: 2, ofScan: 0 }];

    assert.deepEqual(healthOf(rows), [{ key: "corrupt", count: 2 }]);
    for (const row of counterRows(all)) {
        const key = row.name.replace(/^BUS_/, "").toLowerCase();

        for (const finding of healthOf([{ key, count: 1, ofScan: 0 }])) assert.match(texts.packets.findings[finding.key](1, [3]), /1/);
    }
});

test("healthOf: knows all troubles that have a text, in the order of the texts", () => {
    const keys = Object.keys(texts.packets.findings);

    assert.deepEqual(healthOf(keys.map((key) => ({ key, count: 1, ofScan: 0 }))).map(({ key }) => key), keys);
});

test("healthOf: missing replies name the servos that are silent now, else the button that counts anew", () => {
    const { timeouts } = texts.packets.findings;

    assert.match(timeouts(5, [3, 7]), /5 transactions.*No answer now: servos 3, 7\.$/);
    assert.match(timeouts(5, [], 2), /Now all servos answer: press “Count from now”\.$/);
    assert.doesNotMatch(timeouts(5, [], 0), /Now all/);
});

test("healthOf: is right behind 65535, too", () => {
    assert.deepEqual(healthOf([{ key: "timeouts", count: 10, ofScan: 1000 }]), [{ key: "timeouts", count: 10 + 65536 - 1000 }]);
});

test("countedFrom: what was counted before is left out, also behind 65535", () => {
    const start = startOf({ since: "since the reset, 9 s ago", rows: [{ key: "timeouts", count: 65535, ofScan: 3 }] });
    const rows = [{ key: "timeouts", count: 1, ofScan: 3 }, { key: "sent", count: 7, ofScan: 0 }];

    assert.equal(start.age, 9);
    assert.deepEqual(countedFrom(start, rows).map(({ count, ofScan }) => [count, ofScan]), [[2, 0], [7, 0]]);
    assert.equal(countedFrom(null, rows), rows);
});

/* ---- status and alarms ---- */

test("parseStatus: what an owner needs with its meaning, the rest as details", () => {
    assert.deepEqual(parseStatus(["reset by watchdog", "bus ok at 1000000bps", "stack: 1 of 2 bytes unused", "odd"]), [
        { label: "Last reset by", text: "watchdog: the firmware hung", isDetail: false },
        { label: "Bus", text: "ok at 1000000bps", isDetail: false },
        { label: "stack", text: "1 of 2 bytes unused", isDetail: true },
        { label: "odd", text: "", isDetail: true },
    ]);
    assert.match(parseStatus(["bus held low at 1000000bps"])[0].text, /line is held low: .* Switch off the power/);
});

test("parseAlarms: each condition has a remedy", () => {
    assert.deepEqual(parseAlarms(["alarm of servo 3: overheating", "alarm of others: overload", "other"]), [
        { who: "Servo 3", condition: "overheating" },
        { who: "Unlisted servo, ID not known", condition: "overload" },
    ]);
});

test("texts: one of a kind is not told as many", () => {
    assert.equal(texts.motion.missing(1), "1 position is missing");
    assert.equal(texts.motion.room({ poses: 1, sequences: 2 }), "Free on the board: 1 pose, 2 sequences.");
});

/* ---- settings ---- */

const LINES = { device_id: 253, host_baud: 1, bus_baud: 1, return_delay: 254, repeats: 0, echo: 0, link_loss_ms: 0,
    link_loss_action: 1, alarm_report: 0, cycle_us: 4000 };

/* A session at a fake controller whose mode was `mode` before the page came. */
async function rig({ mode = 2, hasConsole = true } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: all, clock });

    port.hasConsole = hasConsole;
    port.addServo(1);
    port.onText = (line) => {
        if (line === "settings echo") port.say(`echo = ${mode}`, "ok");
        else if (line === "settings") port.say(...Object.entries(LINES).map(([name, value]) => `${name} = ${value}`), "settings at start: as saved", "ok");
        else return false;
        return true;
    };
    const connect = session.connect(port);

    await clock.advance(10000);
    await connect;
    session.robot.end();
    await clock.advance(100);
    port.written = [];
    return { clock, port, session, settings: new Settings(session) };
}

test("read: values, origin, and the mode before the page", async () => {
    const { settings } = await rig();

    await settings.read();
    assert.equal(settings.values.get("cycle_us"), 4000);
    assert.equal(settings.values.get("echo"), 2);
    assert.equal(settings.origin, "as saved");
    assert.equal(settings.isSaved, null);
});

test("apply: a value is in force at once and not saved", async () => {
    const { port, settings } = await rig();

    await settings.read();
    await settings.apply({ cycle_us: 5000 });
    assert.ok(port.lines.includes("settings cycle_us 5000"));
    assert.equal(settings.isSaved, false);
});

test("isSaved: as the values are; a refused value changes nothing", async () => {
    const { port, settings } = await rig();

    await settings.read();
    port.onText = (line) => line === "settings cycle_us 1" && (port.say("error 33: number out of range"), true);
    await assert.rejects(settings.apply({ cycle_us: 1 }), { number: 33 });
    assert.equal(settings.isSaved, null);
    await settings.save();
    await settings.apply({ cycle_us: 5000 });
    assert.equal(settings.isSaved, false);
    await settings.apply({ cycle_us: 4000 });
    assert.equal(settings.isSaved, true);
    port.onText = (line) => line === "settings" && (port.say("bus_baud = 9", "ok"), true); // by the view Set-up
    await settings.read();
    assert.equal(settings.isSaved, false);
});

test("save: the mode of before is saved, not that of the page", async () => {
    const { port, settings } = await rig();

    await settings.read();
    port.written = [];
    await settings.save();
    assert.deepEqual(port.lines, ["settings echo 2", "save", "settings echo 0"]);
    assert.equal(settings.isSaved, true);
});

test("save: a mode that is chosen here is saved", async () => {
    const { port, settings } = await rig();

    await settings.read();
    await settings.apply({ echo: 1 });
    port.written = [];
    await settings.save();
    assert.deepEqual(port.lines, ["settings echo 1", "save", "settings echo 0"]);
});

test("save: the page has its mode back if saving fails", async () => {
    const { port, settings } = await rig();

    await settings.read();
    port.onText = (line) => line === "save" && (port.say("error 58: busy"), true);
    await assert.rejects(settings.save(), { name: "CommandError", number: 58 });
    assert.equal(port.lines.at(-1), "settings echo 0");
    assert.notEqual(settings.isSaved, true);
});

test("save: the page has its mode back after a stop", async () => {
    const { clock, port, session, settings } = await rig();

    await settings.read();
    for (const during of ["settings echo 2", "save"]) {
        port.onText = (line) => line === during && (session.stop(), true);
        const failed = assert.rejects(settings.save(), { code: "stopped" });

        await clock.advance(5000);
        await failed;
        assert.equal(session.stopOutcome.verified, true); // no feedback comes here, so it is not shown for long
        assert.equal(port.lines.at(-1), "settings echo 0", during);
    }
});

test("save: restores the page's mode after a silence", async () => {
    const { clock, port, settings } = await rig();

    await settings.read();
    port.onText = (line) => line === "save" && (port.isMute = true);
    const failed = assert.rejects(settings.save(), { code: "timeout" });

    await clock.advance(20000);
    port.isMute = false;
    await clock.advance(5000);
    await failed;
    assert.equal(port.lines.at(-1), "settings echo 0");
});

test("apply: the wire follows another ID of the device", async () => {
    const { session, settings } = await rig();

    await settings.read();
    await settings.apply({ device_id: 200 });
    assert.equal(session.wire.deviceId, 200);
    await assert.rejects(settings.apply({ device_id: 1 }), { code: "device-id-taken" });
    await settings.apply({ device_id: 254 });
    assert.equal(session.wire.hasDevice, false);
});

test("defaults: in force, not saved, and the page keeps its mode", async () => {
    const { port, settings } = await rig();

    await settings.read();
    port.written = [];
    await settings.defaults();
    assert.deepEqual(port.lines, ["defaults", "settings echo 0"]);
    assert.equal(settings.values.get("echo"), 2);
    assert.equal(settings.isSaved, false);
});

test("defaults: at another host rate the page does not wait for an answer", async () => {
    const { clock, port, session, settings } = await rig();
    const { onText } = port;

    await settings.read();
    port.onText = (line) => {
        if (line === "defaults") queueMicrotask(() => (port.isMute = true));
        return port.isMute || onText(line);
    };
    let isOver = false;
    const defaults = settings.defaults().then(() => (isOver = true));

    await clock.advance(60000);
    assert.ok(isOver);
    await defaults;
    assert.ok(session.notices.some(({ code }) => code === "host-rate"));
});

test("bridge: settings by the registers of the device", async () => {
    const { port, settings, clock } = await rig({ hasConsole: false });

    port.device.set([253, 1, 1, 254, 0, 2, 1, 0xf4, 1, 0xa0, 0x0f, 0], 3);
    await settings.read();
    assert.equal(settings.values.get("link_loss_ms"), 500);
    assert.equal(settings.values.get("cycle_us"), 4000);
    assert.equal(settings.values.get("echo"), 2);
    await settings.apply({ cycle_us: 5000 });
    assert.deepEqual([...port.device.slice(0x0c, 0x0e)], [0x88, 0x13]);
    const save = settings.save();

    await clock.advance(100);
    port.device[0x10] = 0; // the EEPROM is written
    await clock.advance(100);
    await save;
    assert.equal(settings.isSaved, true);
});

test("bridge: a failed EEPROM and a refused value are errors", async () => {
    const { port, settings, clock } = await rig({ hasConsole: false });

    await settings.read();
    port.refusals.set(253, 0x08);
    await assert.rejects(settings.apply({ cycle_us: 5000 }), { code: "setting-refused", setting: "cycle_us" });
    port.refusals.clear();
    const save = settings.save();
    const failed = assert.rejects(save, { code: "not-saved" });

    port.device[0x10] = 2;
    await clock.advance(100); // long before the page gives up
    await failed;
});

test("bridge: refused defaults are told as such", async () => {
    const { port, settings } = await rig({ hasConsole: false });

    port.onPacket = (bytes) => bytes[4] === INSTRUCTION.RESET && (port.answer(status(253, 0x40)), true);
    await assert.rejects(settings.defaults(), { code: "defaults-refused" });
});

test("readCounters: the device's and the console's together", async () => {
    const { port, session } = await rig();

    port.device.set([5, 0], 0x34);
    port.onText = (line) => line === "counters" && (port.say("since the reset, 1 s ago", "timeouts 4, of these 3 by scan and diagnose", "ok"), true);
    const { since, rows } = await readCounters(session.controller);
    const row = (key) => rows.find((one) => one.key === key);

    assert.match(since, /reset/);
    assert.deepEqual([row("timeouts").count, row("timeouts").ofScan], [4, 3]);
    assert.equal(row("host_packets").count, 5);
    assert.ok(port.packets.some((bytes) => bytes[4] === INSTRUCTION.READ && bytes[5] === 0x18));
});

test("readCounters: of one servo only what the console tells", async () => {
    const { port, session } = await rig();

    port.onText = (line) => line === "counters 1" && (port.say("since servo 1 joined the robot", "ok 2", "timeouts 0", "ok"), true);
    const { rows } = await readCounters(session.controller, 1);

    assert.deepEqual(rows.map(({ key, count }) => [key, count]), [["ok", 2], ["timeouts", 0]]);
});

test("settings: asks before feedback or Stop would be lost", () => {
    assert.deepEqual(risksOf({ bus_baud: 16, device_id: 254 }), ["bus_baud", "device_id"]);
    assert.deepEqual(risksOf({ device_id: 100, echo: 1 }), []);
    for (const name of risksOf({ bus_baud: 16, device_id: 254 })) assert.match(texts.board.risks[name], new RegExp(name));
});
