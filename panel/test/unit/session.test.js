// SPDX-License-Identifier: MIT
/* The session at a fake port and a fake clock: stop and release. */

import assert from "node:assert/strict";
import test from "node:test";
import { packetChangesOwnMode, sendLine } from "../../src/model/by_hand.js";
import { CommandError } from "../../src/model/controller.js";
import { Session } from "../../src/model/session.js";
import { read, reset, write } from "../../src/wire/packet.js";
import { texts } from "../../src/texts/texts.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const ALARMS = 0x14;
const BUS_STATE = 0x11;
const RESET_CAUSE = 0x12;
const INHIBIT = 0x17;
const TORQUE = 0x18;

async function rig({ hasConsole = true, onText = null, onPacket = null, ids = [1] } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });

    port.hasConsole = hasConsole;
    Object.assign(port, { onText, onPacket });
    for (const id of ids) port.addServo(id, 1);
    const connect = session.connect(port);

    await clock.advance(10000);
    await connect;
    port.written = [];
    return { clock, port, session };
}

/* Connects at the load of the page; another client has the port for `ms`. At `leaveAt` the user disconnects.
 * Returns the states and the codes of the notices. */
async function load(ms, { leaveAt, stopAt } = {}) {
    const clock = new FakeClock();
    const session = new Session({ tables: tables(), clock });
    const states = [];
    let sent = "";

    session.addEventListener("change", () => states.at(-1) !== session.state && states.push(session.state));
    session.connectAtLoad(() => {
        const port = new FakePort();
        const write = port.write.bind(port);

        port.write = (bytes) => {
            sent += String.fromCharCode(...bytes);
            return write(bytes);
        };
        port.open = async () => {
            port.isOpen = true;
            port.isMute = clock.now() < ms;
            if (!port.isMute) return;
            clock.after(1, () => port.say("cds55xx-sim: another client is connected; close it first"));
            clock.after(2, () => port.unplug("closed"));
        };
        return port;
    });
    if (leaveAt) {
        await clock.advance(leaveAt);
        await session.disconnect();
    }
    if (stopAt) {
        await clock.advance(stopAt);
        session.stop();
    }
    await clock.advance(20000);
    return { states, codes: session.notices.map(({ code }) => code), ...(stopAt && { sent }) };
}

test("connectAtLoad: waits 5 s for a taken port, then tells; the state does not change meanwhile", async () => {
    const late = await load(4000);

    assert.deepEqual(late.states, ["connecting", "connected"]);
    assert.ok(!late.codes.includes("port-taken"));
    assert.deepEqual(await load(Infinity), { states: ["connecting", "disconnected"], codes: ["port-taken"] });
});

test("connectAtLoad: a stop before the port is there stays told, and is sent when it is there", async () => {
    const { sent, codes } = await load(4000, { stopAt: 1000 });

    assert.ok(sent.includes("\x18"));
    assert.ok(codes.some((code) => code.startsWith("stop-")), codes.join());
});

test("connectAtLoad: Disconnect ends it", async () => {
    assert.deepEqual(await load(Infinity, { leaveAt: 1000 }), { states: ["connecting", "disconnected"], codes: [] });
});

/* A port that opens after `ms`. */
function slowPort(clock, ms) {
    const port = new FakePort();

    port.open = () => new Promise((resolve) => clock.after(ms, () => resolve(port.isOpen = true)));
    return port;
}

test("connect: Disconnect while the port opens closes it", async () => {
    const clock = new FakeClock();
    const session = new Session({ tables: tables(), clock });
    const port = slowPort(clock, 1000);
    const connect = session.connect(port);

    await clock.advance(100);
    await session.disconnect();
    await clock.advance(5000);
    await connect;
    assert.deepEqual([session.state, port.isOpen, port.written.length, session.notices], ["disconnected", false, 0, []]);
});

test("connect: of several in a row only the last one stays open", async () => {
    const clock = new FakeClock();
    const session = new Session({ tables: tables(), clock });
    const ports = [1000, 500, 100, 1].map((ms) => slowPort(clock, ms));
    const connects = ports.slice(0, 2).map((port) => session.connect(port));

    await clock.advance(50);
    await session.disconnect();
    connects.push(...ports.slice(2).map((port) => session.connect(port)));
    await clock.advance(10000);
    await Promise.all(connects);
    assert.deepEqual(ports.map(({ isOpen }) => isOpen), [false, false, false, true]);
    assert.equal(session.state, "connected");
    assert.ok(ports.slice(0, 3).every(({ written }) => !written.length));
});

test("disconnect: an endless turn of the page is ended before the port closes, also at pagehide, while a reply is due", async () => {
    const { clock, port, session } = await rig({ ids: [1, 2] });
    const speeds = () => port.packets.filter((bytes) => bytes[4] === 3 && bytes[5] === 0x20).map((bytes) => [bytes[2], bytes[6] + 256 * bytes[7]]);

    port.servos.get(1).set([0, 0, 0, 0], 0x06);
    await clock.advance(2000);
    assert.equal(session.robot.setTurn(1, 20), true);
    await clock.advance(100);
    assert.equal(speeds().length, 1);
    port.isMute = true;
    await clock.advance(20);
    session.disconnect(); // nothing is awaited: the page goes
    assert.deepEqual(speeds().slice(1), [[1, 0]]);
    assert.equal(port.isOpen, false);
});

test("disconnect: a turn that has ended, or was stopped, needs no packet", async () => {
    const { clock, port, session } = await rig();
    const leave = async (end) => {
        session.robot.setTurn(1, 20);
        await clock.advance(100);
        await Promise.all([end(), clock.advance(2000)]);
        return session.robot.endsOfTurns();
    };

    port.servos.get(1).set([0, 0, 0, 0], 0x06);
    await clock.advance(2000);
    assert.deepEqual(await leave(() => session.robot.hold(1)), []);
    assert.deepEqual(await leave(() => session.stop()), []);
});

test("search without a console: its IDs without servo are no errors of the traffic", async () => {
    const clock = new FakeClock();
    const session = new Session({ tables: tables(), clock });
    const port = new FakePort();

    port.hasConsole = false;
    port.addServo(1);
    port.offline.add(7); // the device reports that some servos did not answer
    session.connect(port);
    await clock.advance(5000);
    assert.deepEqual(session.robot.ids, [1]);
    assert.ok(session.traffic.select({}, 999).some(({ bytes, direction }) => direction === "in" && bytes[4] === 0x80));
    assert.deepEqual(session.traffic.select({ errorsOnly: true, withPolling: true }, 9).map((row) => session.traffic.describe(row).text), []);
});

const errorsOf = (session) => session.traffic.select({ errorsOnly: true, withPolling: true }, Infinity);

test("traffic: what the first contact asks in vain is no error", async () => {
    for (const [onPacket, hasConsole] of [[(bytes) => bytes[2] === 253, true], [null, false]]) {
        const { session } = await rig({ onPacket, hasConsole });

        assert.ok(session.traffic.select({ withPolling: true }, Infinity).some(({ isUnanswered }) => isUnanswered));
        assert.deepEqual(errorsOf(session).map(({ line, bytes }) => line || bytes), []);
        assert.deepEqual([session.wire.hasDevice, session.wire.hasConsole], [!onPacket, hasConsole]);
    }
});

test("traffic: a marker that gets no reply later is an error", async () => {
    const { session, port, clock } = await rig();

    port.onText = () => true;
    session.controller.run("version").catch(() => {});
    await clock.advance(20000);
    const lines = errorsOf(session).map(({ line }) => line).filter((line) => line.startsWith("help "));

    assert.ok(lines.length >= 6, lines.join());
});

test("packets by hand: those that change or save the page's own mode belong to the view Board", async () => {
    const packets = {
        save: write(253, 0x10, [1]), within: write(253, 0x0c, [0, 0, 0, 0, 1]), mode: write(253, 0x08, [2]), id: write(253, 3, [254]), rate: write(253, 4, [16]), reset: reset(253),
        read: read(253, 0x10, 1), before: write(253, 0x0c, [0x10, 0x27, 0, 0]), behind: write(253, 0x14, [0]), servo: write(1, 0x10, [1]), servoReset: reset(1),
    };
    const ofBoard = async (options) => {
        const { session } = await rig(options);

        return Object.keys(packets).filter((name) => packetChangesOwnMode(session, packets[name]));
    };

    assert.deepEqual(await ofBoard({}), ["save", "within", "mode", "id", "rate", "reset"]);
    assert.deepEqual(await ofBoard({ hasConsole: false }), []);
});

test("stop: Ctrl-X leaves before anything else", async () => {
    const { port, session } = await rig();
    let stops = 0;

    session.robot.forgetGoals = () => (stops = port.stops);
    session.stop();
    assert.equal(stops, 1);
});

test("stop: without a known servo torque is not told to be off", async () => {
    const { clock, session } = await rig({ ids: [] });

    await Promise.all([session.stop(), clock.advance(2000)]);
    assert.equal(session.stopState, "unchecked");
    assert.equal(session.isInhibited, true);
    assert.ok(!session.notices.some(({ code }) => code === "stop-unverified"));
});

test("stop: servos that do not answer, and those with torque, are told apart", async () => {
    const { clock, port, session } = await rig({ ids: [1, 2, 3] });
    const stop = async () => {
        await Promise.all([session.stop(), clock.advance(5000)]);
        return session.notices.find(({ code }) => code === "stop-unverified");
    };

    port.offline.add(2);
    const silent = await stop();

    assert.equal(silent.text, "Driving is inhibited. No answer, so torque is not known: servo 2.");
    assert.match(silent.remedy, /switch off the power of the servos.*Check power and plug.*“Diagnosis”.*“Find servos”/);
    port.servos.get(3).slice = (from, to) => [...Uint8Array.prototype.slice.call(port.servos.get(3), from, to)].map((byte, at) => (from + at === TORQUE ? 1 : byte));
    const both = await stop();

    assert.equal(both.text, "Driving is inhibited. Torque is still on: servo 3. No answer, so torque is not known: servo 2.");
    assert.match(both.remedy, /^Press Stop again.*Check power and plug/);
});

test("notices: one lists all servos; a release withdraws it", async () => {
    const { clock, port, session } = await rig();
    const shown = () => session.notices.map(({ code }) => code).filter((code) => !["console", "other-version"].includes(code));

    for (const id of [3, 1, 3]) session.notify({ code: "goal-unconfirmed", id });
    session.notify({ code: "inhibited", id: 2 });
    session.notify({ code: "inhibited", ids: [3, 4] });
    assert.deepEqual(shown(), ["goal-unconfirmed", "inhibited"]);
    assert.match(session.notices.at(-2).text, /^Servos 1, 3 did not confirm/);
    assert.match(session.notices.at(-1).text, /^Torque of servos 2, 3, 4 stays off/);
    await Promise.all([session.release(), clock.advance(1000)]);
    assert.deepEqual(shown(), []);
    session.notify({ code: "stop-no-inhibit" });
    await Promise.all([session.stop(), clock.advance(2000)]);
    assert.deepEqual(shown(), []);
    port.isMute = true;
    await clock.advance(5000);
    assert.deepEqual(shown(), ["silent"]);
    port.isMute = false;
    await clock.advance(5000);
    assert.deepEqual(shown(), ["back"]);
});

test("notices: information goes away by itself, renewed it stays longer; warnings and errors stay", async () => {
    const { clock, session } = await rig();
    const shown = () => session.notices.map(({ code }) => code);

    session.notices = [];
    session.notify({ code: "motion-stored", poses: 1, sequences: 1 });
    session.notify({ code: "motion-deleted", detail: "up", undo: () => {} });
    session.notify({ code: "level-silent", id: 1 });
    session.notify({ code: "motion-short" });
    await clock.advance(5000);
    session.notify({ code: "motion-stored", poses: 1, sequences: 1 });
    await clock.advance(5000);
    assert.deepEqual(shown(), ["motion-deleted", "level-silent", "motion-short", "motion-stored"]);
    await clock.advance(5000);
    assert.deepEqual(shown(), ["motion-deleted", "level-silent", "motion-short"]);
    await clock.advance(10000);
    assert.deepEqual(shown(), ["level-silent", "motion-short"]);
    await clock.advance(60000);
    assert.deepEqual(shown(), ["level-silent", "motion-short"]);
});

test("notices: too many never push one about safety out", async () => {
    const { session } = await rig();
    const shown = () => session.notices.map(({ code }) => code);

    session.notices = [];
    session.notify({ code: "stop-not-sent" });
    session.notify({ code: "motion-loaded", poses: 1, sequences: 1 });
    for (const id of [3, 4]) session.notify({ code: "turn-not-ended", id });
    for (let line = 0; line < 30; line++) session.notify({ code: "command", line: `read ${line}`, number: 2, message: "no reply", remedy: "" });
    assert.equal(shown().length, 20);
    assert.deepEqual(shown().slice(0, 3), ["stop-not-sent", "turn-not-ended", "command"]);
    assert.equal(session.notices[1].text, "Servos 3, 4 did not confirm the end of endless turn.");
    assert.match(session.notices.at(-1).text, /read 29/);
});

test("busy: it is told when a command begins", async () => {
    const { port, session } = await rig();
    let isBusy = false;

    port.onText = () => true; // no reply
    session.addEventListener("change", () => (isBusy = session.isBusy));
    session.wire.command("monitor");
    assert.equal(isBusy, true);
});

test("stop: without a connection it is told that nothing was sent", async () => {
    const { session } = await rig();
    const codes = () => session.notices.filter(({ code }) => code === "stop-not-sent").length;

    await session.disconnect();
    await session.stop();
    assert.equal(codes(), 1);
    const fresh = new Session({ tables: tables() });

    await fresh.stop();
    assert.equal(fresh.notices[0].code, "stop-not-sent");
});

/* A robot that is stopped. */
async function stopped(options) {
    const it = await rig(options);
    const stop = it.session.stop();

    await it.clock.advance(2000);
    await stop;
    assert.equal(it.session.stopState, "verified");
    return it;
}

test("stop: torque off is not told any more once no feedback has confirmed it for 2 s, as during a long command", async () => {
    const { clock, port, session } = await stopped();

    await clock.advance(20000);
    assert.equal(session.stopState, "verified");
    let shown;

    session.addEventListener("change", () => (shown = session.stopState));
    port.onText = (line) => line === "motion wait" && (port.isMute = true); // it dies as soon as it has the line
    session.wire.command("motion wait", { timeout: 600000 }).catch(() => {});
    await clock.advance(1500);
    assert.equal(shown, "verified");
    await clock.advance(1000);
    assert.equal(shown, "none");
    assert.equal(session.state, "connected"); // nothing else tells it
});

test("clear: alarms are forgotten, the inhibit stays", async () => {
    const { clock, port, session } = await stopped();

    port.device[ALARMS] = 4;
    await Promise.all([session.robot.clearAlarms(), clock.advance(1000)]);
    assert.equal(port.device[ALARMS], 0);
    assert.ok(!port.lines.includes("clear"));
    assert.equal(session.robot.device.inhibit, 1);
    assert.equal(session.stopState, "verified");
});

test("clear: refused without device while inhibited", async () => {
    const { clock, port, session } = await rig();
    let driving = "inhibited until 'release'";
    const clear = () => session.robot.clearAlarms().then(() => "ok", (error) => error.code);

    session.wire.hasDevice = false;
    port.onText = (line) => line === "status" && (port.say(`driving: ${driving}`, "ok"), true);
    assert.deepEqual(await Promise.all([clear(), clock.advance(1000)]), ["clear-inhibited", undefined]);
    driving = "allowed; inhibited: 1";
    assert.deepEqual(await Promise.all([clear(), clock.advance(1000)]), ["clear-inhibited", undefined]);
    assert.ok(!port.lines.includes("clear"));
    driving = "allowed";
    assert.deepEqual(await Promise.all([clear(), clock.advance(1000)]), ["ok", undefined]);
    assert.ok(port.lines.includes("clear"));
});

test("release: a lost link is acknowledged first", async () => {
    const { clock, port, session } = await stopped();
    let isLost = true;

    port.onText = (line) => {
        if (line === "clear") isLost = false;
        return line === "release" && isLost && (port.say("error 65: the host link was lost"), true);
    };
    await Promise.all([session.release(), clock.advance(1000)]);
    assert.deepEqual(port.lines.filter((line) => line === "clear" || line === "release"), ["release", "clear", "release"]);
    assert.ok(!session.notices.some(({ code }) => code === "command"));
    assert.equal(session.stopState, "none");
});

test("release: by packets; a refusal is told, the stop stays", async () => {
    const { clock, port, session } = await stopped({ hasConsole: false });

    port.refusals.set(253, 0x08);
    await Promise.all([session.release(), clock.advance(1000)]);
    assert.ok(session.notices.some(({ code }) => code === "release-refused"));
    assert.equal(session.stopState, "verified");
    port.refusals.clear();
    await Promise.all([session.release(), clock.advance(1000)]);
    assert.equal(port.device[INHIBIT], 0);
    assert.equal(session.stopState, "none");
});

const untrue = {
    "the controller was released elsewhere": { change: (port) => (port.device[INHIBIT] = 0), isInhibited: false },
    "a servo has torque": { change: (port) => (port.servos.get(1)[TORQUE] = 1), isInhibited: true },
    "the torque of a servo cannot be read": { change: (port) => port.offline.add(1), isInhibited: true },
    "the controller is silent": { change: (port) => (port.isMute = true), isInhibited: true },
    "the port is lost": { change: (port) => port.unplug(), isInhibited: false },
};

for (const [what, { change, isInhibited }] of Object.entries(untrue))
    test(`stop: torque off is shown no longer when ${what}`, async () => {
        const { clock, port, session } = await stopped();

        await clock.advance(5000);
        assert.equal(session.stopState, "verified");
        change(port);
        await clock.advance(3000);
        assert.equal(session.stopState, "none");
        assert.equal(session.isInhibited, isInhibited);
    });

const resets = {
    "echoes a line": (port) => (port.echo = true),
    "has forgotten its servos": (port) => (port.forgets = true),
    "has another RESET_CAUSE": (port) => (port.device[RESET_CAUSE] = 8),
    "tells its banner": (port) => port.say("cds55xx 0.1.0 test"),
};

for (const [what, reset] of Object.entries(resets))
    test(`reset: the page begins again when the controller ${what}`, async () => {
        const { clock, port, session } = await stopped();

        port.onText = (line) => {
            if (line === "mode program") port.echo = port.forgets = false;
            if (port.echo) port.say(line);
            return line === "servos" && port.forgets && (port.say("no servo known: 'scan' finds servos", "ok"), true);
        };
        await clock.advance(6000);
        session.robot.servos.get(1).inhibit = "stopped";
        port.written = [];
        assert.ok(!session.notices.some(({ code }) => code === "reset"));
        port.device[INHIBIT] = 0;
        const before = session.starts;

        reset(port);
        await clock.advance(7000);
        assert.equal(session.starts, before + 1);
        assert.ok(session.notices.some(({ code }) => code === "reset"));
        assert.equal(port.lines.filter((line) => line === "mode program").length, 1);
        assert.equal(session.robot.servos.get(1).inhibit, "");
        assert.equal(session.isInhibited, false);
    });

test("reset: without device a stop before it is not shown any more", async () => {
    const { clock, port, session } = await rig();

    session.wire.hasDevice = false;
    session.stopState = "unverified";
    assert.equal(session.isInhibited, true);
    port.say("cds55xx 0.1.0 test");
    await clock.advance(100);
    assert.equal(session.isInhibited, false);
});

test("reset: a scan of the user that finds nothing is none", async () => {
    const { clock, port, session } = await stopped();
    let isForgotten = false;

    port.onText = (line) => {
        if (line === "scan") isForgotten = true;
        return isForgotten && (line === "servos" || line === "scan") && (port.say("ok"), true);
    };
    await clock.advance(6000);
    await Promise.all([session.controller.run("scan"), clock.advance(7000)]);
    assert.ok(!session.notices.some(({ code }) => code === "reset"));
});

test("notices: a command that failed is not told any more once the same operation succeeds", async () => {
    const { clock, port, session } = await rig();
    const failed = () => session.notices.filter(({ code }) => code === "command").map(({ text }) => /“(.*)”/.exec(text)[1]);
    let isFailing = true;

    port.onText = (line) => isFailing && line !== "servos" && (port.say("error 40: too many servos"), true);
    for (const line of ["new 77", "id 1 9", "id 2 9", "play wave"])
        await Promise.all([session.attempt(() => session.controller.run(line)), clock.advance(100)]);
    assert.deepEqual(failed(), ["new 77", "id 1 9", "id 2 9", "play wave"]);
    isFailing = false;
    for (const line of ["new 7", "id 1 8"]) await Promise.all([session.controller.run(line), clock.advance(100)]);
    assert.deepEqual(failed(), ["id 2 9", "play wave"]);
    await Promise.all([sendLine(session, "play  wave"), clock.advance(100)]);
    assert.deepEqual(failed(), ["id 2 9"]);
});

test("notices: an error goes once its cause is gone", async () => {
    const { clock, port, session } = await rig();
    const codes = () => session.notices.map(({ code, number }) => number ?? code);
    const servo = session.robot.servos.get(1);
    const tell = (number) => session.notify({ code: "command", line: `x ${number}`, number, message: "", remedy: "" });

    session.notices = [];
    port.onText = (line) => /^(?:servos forget|release)$/.test(line) && (port.say("ok"), true);
    for (const number of [40, 12, 54, 64, 65, 85]) tell(number);
    session.notify({ code: "motion-ended", number: 12, message: "", remedy: "" });
    await Promise.all([session.controller.run("servos forget"), clock.advance(100)]);
    assert.deepEqual(codes(), [12, 54, 64, 65, 85, 12]);
    await Promise.all([session.release(), clock.advance(100)]);
    assert.deepEqual(codes(), [85]);
    port.device[INHIBIT] = 1;
    await clock.advance(1000);
    tell(54);
    port.device[INHIBIT] = 0; // by a line by hand
    await clock.advance(1000);
    assert.deepEqual(codes(), [85]);
    servo.torque = false;
    session.notify({ code: "motion-torque", ids: [1] });
    assert.deepEqual(codes(), [85, "motion-torque"]);
    servo.torque = true;
    session.robot.dispatchEvent(new Event("change"));
    assert.deepEqual(codes(), [85]);
});

test("notices: that servos do not answer is told until all answer again", async () => {
    const { clock, port, session } = await rig({ ids: [1, 2] });
    const codes = () => session.notices.map(({ code }) => code);

    session.notices = [];
    session.notify({ code: "servo-silent", id: 2 });
    port.offline.add(2);
    await clock.advance(100);
    port.offline.delete(2);
    await clock.advance(500);
    assert.deepEqual(codes(), ["servo-silent"]); // a reply that was lost
    for (const id of [1, 2]) port.offline.add(id);
    await clock.advance(700);
    session.notify({ code: "motion-ended", number: 83 });
    session.notify({ code: "motion-ended", number: 81, id: 1 });
    session.notify({ code: "command", line: "ping 2", number: 9, message: "", remedy: "" }); // the line was held low
    port.offline.delete(1);
    await clock.advance(500);
    assert.deepEqual(codes(), ["servo-silent", "motion-ended", "motion-ended", "command"]);
    port.offline.delete(2);
    await clock.advance(500);
    assert.deepEqual(session.notices.map(({ number }) => number), [81]); // this motion ended for another reason
});

test("disconnect: asks unless torque is known to be off, and tells what the controller does", async () => {
    const { clock, port, session } = await rig();
    const askedWith = (action, ms) => texts.connect.askDisconnect({ action, ms });
    const [servo] = session.robot.servos.values();
    const asks = [true, null, false].map((torque) => ((servo.torque = torque), session.mayHaveTorque));

    assert.deepEqual(asks, [true, true, false]);
    assert.match(askedWith(1, 0), /goes on with its last orders\./);
    assert.match(askedWith(0, 500), /goes on with its last orders\./);
    assert.match(askedWith(1, 500), /After 500 ms the controller inhibits driving; a movement under way goes on/);
    assert.match(askedWith(2, 500), /After 500 ms the controller switches torque off for servos that answer/);
    assert.match(texts.connect.askDisconnect({}), /unless link_loss_ms/);
    port.device.set([2, 0xf4, 1], 9); // link_loss_action, link_loss_ms
    await clock.advance(1000);
    assert.deepEqual(session.linkLoss, { ms: 500, action: 2 });
    port.unplug();
    assert.match(session.notices.find(({ code }) => code === "lost").text, /After 500 ms the controller switches torque off for servos that answer/);
});

test("notices: the remedy of a command names buttons of the page, not commands", () => {
    const remedyOf = (number) => new CommandError("x", { number, text: "y; 'z'" }, [], tables().errors).remedy;

    for (const { remedy } of Object.values(tables().errors)) assert.doesNotMatch(remedy, /(?<!\w)'/);
    assert.match(remedyOf(12), /press “Release”$/);
    assert.equal(remedyOf(57), "give it more time in the view Motion");
    assert.match(remedyOf(40), /send “servos forget” by the console of the view Packets/);
    assert.match(remedyOf(84), /press “Torque on”/);
    assert.equal(remedyOf(41), "'z'");
});

test("servos forget: typed in the console, the page knows no servo either, and does not scan", async () => {
    const { clock, port, session } = await rig();
    let isForgotten = false;

    port.onText = (line) => {
        if (line === "servos forget") isForgotten = true;
        return isForgotten && line.startsWith("servos") && (port.say("no servo known: 'scan' finds servos", "ok"), true);
    };
    assert.deepEqual(session.robot.ids, [1]);
    await Promise.all([sendLine(session, "servos forget"), clock.advance(7000)]);
    assert.deepEqual(session.robot.ids, []);
    assert.ok(!port.lines.includes("scan"));
    assert.ok(!session.notices.some(({ code }) => code === "reset"));
});

test("release: torque is switched at once, before INHIBIT is read again", async () => {
    const { clock, port, session } = await stopped();

    port.onText = (line) => {
        if (line !== "release") return false;
        port.device[INHIBIT] = 0;
        port.say("ok");
        return true;
    };
    await session.release();
    assert.equal(session.isInhibited, false);
    await Promise.all([session.robot.setTorque(1, true), clock.advance(500)]);
    assert.equal(port.servos.get(1)[TORQUE], 1);
});

test("release: one releases all servos that are inhibited by themselves", async () => {
    let why = ", inhibited: lost its state";
    const { clock, session } = await rig({
        ids: [1, 2, 3],
        onText(line) {
            if (line === "release") this.say((why = "") || "ok");
            else if (line === "servos") this.say(`servo 1: online${why}`, `servo 2: online${why}`, "servo 3: online", "ok");
            else return false;
            return true;
        },
    });

    await clock.advance(6000);
    assert.deepEqual([session.lostIds, session.isInhibited], [[1, 2], false]);
    await Promise.all([session.release(), clock.advance(10)]);
    assert.deepEqual(session.lostIds, []); // at once, not at the next reply of `servos`
});

test("stop: one that was not confirmed is confirmed as soon as the torque of each servo reads off", async () => {
    const { clock, port, session } = await rig({ ids: [1, 2] });

    port.offline.add(2);
    await Promise.all([session.stop(), clock.advance(5000)]);
    assert.equal(session.stopState, "unverified");
    port.offline.delete(2);
    await clock.advance(1000);
    assert.equal(session.stopState, "verified");
    assert.deepEqual(session.notices.filter(({ code }) => code.startsWith("stop")), []);
    session.robot.end();
    await clock.advance(3000);
    assert.equal(session.stopState, "none"); // nothing confirms it any more
});

/* Each Ctrl-X begins a torque off of 1.4 s, and no packet is answered meanwhile. */
for (const isKnown of [true, false])
    test(`stop: a line that is held low, ${isKnown ? "known" : "not known"}, does not make the controller silent`, async () => {
        const { clock, port, session } = await rig({ ids: [1, 2] });
        let [stops, busyUntil] = [0, 0];

        if (isKnown) port.device[BUS_STATE] = 2;
        port.offline.add(1).add(2);
        await clock.advance(1000);
        port.onPacket = () => {
            if (stops !== port.stops) [stops, busyUntil] = [port.stops, clock.now() + 1400];
            return clock.now() < busyUntil;
        };
        await Promise.all([session.stop(), clock.advance(10000)]);
        assert.equal(session.stopOutcome.inhibited, isKnown);
        assert.deepEqual(session.notices.map(({ code }) => code).filter((code) => /stop|silent|back/.test(code)), [isKnown ? "stop-unverified" : "stop-no-inhibit"]);
    });

test("notices: that an ID is taken does not name the rate", async () => {
    const { clock, port, session } = await rig();

    port.onText = (line) => line === "id 1 2" && (port.say("error 50: servo 1: the new ID or rate is taken"), true);
    await Promise.all([session.attempt(() => session.controller.order("id 1 2")), clock.advance(500)]);
    assert.equal(session.notices.at(-1).text, "“id 1 2”: error 50, servo 1: the new ID is taken.");
});

test("release: the button stays until INHIBIT reads 0", async () => {
    const { clock, port, session } = await stopped();

    port.onText = (line) => line === "release" && (port.say("ok"), true);
    await Promise.all([session.release(), clock.advance(1000)]);
    assert.equal(session.isInhibited, true);
    port.device[INHIBIT] = 0;
    await clock.advance(1000);
    assert.equal(session.isInhibited, false);
});

test("notices: a lost port is told once, also during a search", async () => {
    const { port, session, clock } = await rig({ onText: (line) => line.startsWith("scan") });
    const search = session.attempt(() => session.controller.scan());

    await clock.advance(100);
    port.unplug();
    await search;
    assert.deepEqual(session.notices.map(({ code }) => code).filter((code) => ["lost", "closed"].includes(code)), ["lost"]);
    await session.attempt(() => session.controller.scan()); // asked for behind it
    assert.ok(!session.notices.some(({ code }) => code === "closed"));
});
