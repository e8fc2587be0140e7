// SPDX-License-Identifier: MIT
/* The operations of the view Set-up, at a fake port and a fake clock. */

import assert from "node:assert/strict";
import test from "node:test";
import { Session } from "../../src/model/session.js";
import { Settings } from "../../src/model/settings.js";
import { Setup } from "../../src/model/setup.js";
import { texts } from "../../src/texts/texts.js";
import { INSTRUCTION } from "../../src/wire/packet.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const MIN_VOLTAGE = 0x0c;
const MAX_VOLTAGE = 0x0d;
const RETURN_LEVEL = 0x10;
const TORQUE = 0x18;

/* A session with servos. Without a console the page knows only what packets tell. */
async function rig({ ids = [1, 2, 3], hasConsole = true, onText = () => false } = {}) {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });
    const setup = new Setup(session);
    const help = tables().commands.map(({ usage, what }) => `  ${usage}: ${what}`);

    port.hasConsole = hasConsole;
    ids.forEach((id) => (port.addServo(id)[MAX_VOLTAGE] = 160));
    port.onText = (line) => {
        if (onText(line, port)) return true;
        if (line === "version") port.say("cds55xx 0.1.0 test", "ok");
        else if (line === "help") port.say(...help, "ok");
        else if (line === "servos") port.say(...[...port.servos.keys()].map((id) => `servo ${id}: online, torque off`), "ok");
        else if (/^set \d+/.test(line)) setRegister(port, line);
        else return false;
        return true;
    };
    const connected = session.connect(port);

    await clock.advance(hasConsole ? 1000 : 8000);
    await connected;
    return { clock, port, session, setup, row: (name) => setup.rows.find((one) => one.name === name) };
}

/* "set 1 MIN_VOLTAGE 65raw" */
function setRegister(port, line) {
    const [, id, name, raw] = /^set (\d+) (\w+) (\d+)raw$/.exec(line);
    const { address, bytes } = tables().registers.find((row) => row.name === name);

    port.servos.get(Number(id)).set(bytes === 2 ? [raw & 0xff, raw >> 8] : [raw], address);
    port.say("written", "ok");
}

/* Waits for what `call` starts, while the clock goes on. */
async function finish(clock, promise, ms = 1000) {
    await clock.advance(ms);
    return promise;
}

const writesOf = (port) => port.packets.filter((bytes) => bytes[4] === INSTRUCTION.WRITE);
const setLines = (port) => port.lines.filter((line) => line.startsWith("set "));
const codes = (session) => session.notices.map(({ code }) => code);

test("freeId: the lowest from 2 on that no servo has, 1 last", async () => {
    const { setup } = await rig({ ids: [1, 2, 4] });

    assert.equal(setup.freeId, 3);
    assert.doesNotMatch(texts.setup.newIdHint(3), /has seen/); // a servo that gave its ID up was seen
    setup.found = [{ id: 3 }];
    assert.equal(setup.freeId, 5);
});

test("search: progress, servos and remarks; a key ends it", async () => {
    const { setup, port, clock } = await rig({ onText: (line, { say }) => line === "scan all" });
    const search = setup.search("all");

    await clock.advance(10);
    port.say("254 of 1524 asked, now at 500000bps", "id 9 model 1 at 57143bps, set to another rate");
    await clock.advance(10);
    assert.deepEqual([setup.operation.kind, setup.operation.done, setup.operation.total], ["search", 254, 1524]);
    setup.end();
    await clock.advance(10);
    assert.equal(port.written.at(-1)[0], 0x0d);
    port.say("servo 9: finding 8: two servos seem to have this ID", "error 49: ended by a key or packet");
    await finish(clock, search);
    assert.deepEqual(setup.found, [{ id: 9, model: 1, rate: 57143 }]);
    assert.deepEqual(setup.remarks, ["servo 9: finding 8: two servos seem to have this ID"]);
    assert.equal(setup.isPartial, true);
    assert.deepEqual(codes(setup.session), []);
});

const deaf = {
    search: { line: "scan rescue", start: (setup) => setup.search("rescue"), told: (setup) => setup.isPartial },
    "new servo": { line: "new 4", start: (setup) => setup.setUpNew(4), told: (setup) => setup.outcome?.kind === "newEnded" },
    diagnosis: { line: "diagnose 9", start: (setup) => setup.diagnose(9), told: (setup) => setup.isDiagnosisEnded },
};

for (const [what, { line: command, start, told }] of Object.entries(deaf))
    test(`${what}: ends within 2 s though the controller ignores the key`, async () => {
        const { setup, clock, session } = await rig({ onText: (line) => line === command || line === "" });
        const run = start(setup);

        await clock.advance(100);
        setup.end();
        await clock.advance(2000);
        assert.equal(setup.isRunning, false);
        await run;
        assert.equal(told(setup), true);
        assert.deepEqual(codes(session), []);
    });

for (const action of [0, 1])
    test(`search, new servo, diagnosis: link_loss_ms is ${action ? "0 meanwhile" : "left alone"} with link_loss_action ${action}`, async () => {
        let ms = 1000;
        const onText = (line, at) => {
            const set = /^settings link_loss_ms (\d+)$/.exec(line);

            if (set) ms = Number(set[1]);
            if (line === "settings") at.say(`link_loss_ms = ${ms} ms`, `link_loss_action = ${action}`, "ok");
            return line === "settings";
        };
        const { setup, clock, session, port } = await rig({ onText });

        for (const start of Object.values(deaf).map((each) => each.start)) await finish(clock, start(setup), 5000);
        assert.deepEqual(codes(session), []);
        await finish(clock, setup.search(""), 5000); // watched: by packets
        const lines = port.lines.filter((line) => /^(scan|new|diagnose|settings link)/.test(line));
        const unwatched = (line) => (action ? ["settings link_loss_ms 0", line, "settings link_loss_ms 1000"] : [line]);

        assert.deepEqual(lines, [...["scan rescue", "new 4", "diagnose 9"].flatMap(unwatched), ...(action ? [] : ["scan"])]);
        assert.deepEqual(setup.ids, [1, 2, 3]);
    });

test("search: no scan follows one that was ended", async () => {
    const { setup, clock, port } = await rig({ ids: [], onText: (line, at) => line === "scan all" || (line === "" && (at.say("error 49: ended"), true)) });
    const search = setup.search("all");

    await clock.advance(100);
    port.written = [];
    setup.end();
    await finish(clock, search);
    assert.deepEqual(port.lines.filter((line) => line.startsWith("scan")), []);
});

test("search: one that a stop ends is not shown as complete", async () => {
    const { clock, session, setup } = await rig({ onText: (line, at) => line === "scan all" && (at.say("id 1 model 1 at 1000000bps"), true) });
    const search = setup.search("all");

    await clock.advance(100);
    const stop = session.stop();

    await finish(clock, Promise.all([search, stop]));
    assert.deepEqual(session.notices.filter(({ code }) => code === "stopped").map(({ text, level }) => [text, level]), [["Ended by Stop.", "info"]]);
    assert.deepEqual(setup.found.map(({ id }) => id), [1]);
    assert.equal(setup.isPartial, true);
});

test("search: no packet leaves while the command runs", async () => {
    const { setup, port, clock } = await rig({ onText: (line) => line === "scan" });
    const search = setup.search("");

    await clock.advance(50);
    const before = port.packets.length;

    await clock.advance(500);
    assert.equal(port.packets.length, before);
    assert.equal(setup.session.isBusy, true);
    port.say("0 found, 254 asked", "ok");
    await finish(clock, search);
    assert.ok(port.packets.length > before);
});

test("one operation at a time", async () => {
    const { setup, clock, port } = await rig();
    const first = setup.readAll(1);

    assert.equal(await setup.readAll(2), undefined);
    await finish(clock, first);
    assert.equal(setup.registers.id, 1);
    assert.equal(port.packets.some((bytes) => bytes[2] === 2 && bytes[4] === INSTRUCTION.READ && bytes[6] === 50), false);
});

test("new servo: its steps, then it is the chosen one", async () => {
    const { setup, port, clock } = await rig({
        onText: (line, at) => {
            if (line !== "new 4") return false;
            at.servos.set(4, at.servos.get(1).slice());
            at.say("step 1 of 4: search at six rates, about 4 s; a key ends it", "step 2 of 4: return delay 2 us", "ok");
            return true;
        },
    });

    await finish(clock, setup.setUpNew(4));
    assert.equal(setup.steps.length, 2);
    assert.equal(setup.outcome.kind, "new");
    assert.equal(setup.id, 4);
    assert.deepEqual(codes(setup.session), []);
    assert.ok(port.lines.includes("new 4"));
    assert.match(texts.setup.newDone(4), new RegExp(`others again, then press “${texts.setup.search}”`));
});

test("new servo: an ID of the list is refused, and set up once the list is forgotten", async () => {
    let isListed = true;
    const { setup, port, clock } = await rig({
        onText: (line, at) => {
            if (line === "servos forget") isListed = false;
            if (line !== "new 4" || !isListed) return false;
            at.say("error 95: servo 1: this ID is in the robot's list, nothing was written; unplug the servo of the robot");
            return true;
        },
    });

    await finish(clock, setup.setUpNew(4));
    assert.deepEqual(codes(setup.session), []); // the outcome has the remedy
    assert.deepEqual(setup.outcome, { kind: "newKnown", lines: [], id: 4 });
    await finish(clock, setup.setUpNew(4, { forgets: true }));
    assert.equal(setup.outcome.kind, "new");
    assert.deepEqual(port.lines.filter((line) => /^new|forget/.test(line)), ["new 4", "servos forget", "new 4"]);
    isListed = true;
    await finish(clock, setup.setUpNew(4));
    await finish(clock, setup.search(""));
    assert.equal(setup.outcome, null); // the offer to forget the list is of the list before
});

test("freeId: not that of a servo that the controller has forgotten, but one that its servo has given up", async () => {
    const { setup, port, clock } = await rig({ onText: (line, at) => (line === "servos forget" || line.startsWith("id ")) && (at.say("ok"), true) });

    port.servos.delete(2);
    port.servos.delete(3);
    await finish(clock, setup.session.robot.findServos(), 8000);
    assert.deepEqual(setup.ids, [1]);
    assert.equal(setup.freeId, 4);
    port.addServo(3);
    await finish(clock, setup.search(""), 8000);
    port.servos.delete(3);
    await finish(clock, setup.changeId(3, 5), 8000);
    assert.equal(setup.freeId, 3);
});

/* A controller that watches its link; servo 9 is under diagnosis. */
async function unwatched() {
    const onText = (line, at) => (line === "settings" ? (at.say("link_loss_ms = 1000 ms", "link_loss_action = 2", "ok"), true) : line === "diagnose 9");
    const it = await rig({ onText });
    const run = it.setup.diagnose(9);

    await it.clock.advance(100);
    assert.deepEqual(codes(it.session), ["unwatched"]);
    return { ...it, run, settings: new Settings(it.session) };
}

test("freeId: not that of a servo of an earlier connection, nor of one seen before the view was opened", async () => {
    const { clock, session, port } = await rig();

    for (const id of [2, 3]) port.servos.delete(id);
    await session.disconnect();
    await finish(clock, session.connect(port));
    assert.deepEqual(session.robot.ids, [1]);
    assert.equal(new Setup(session).freeId, 4);
});

test("link_loss_ms: set back after a stop; the notice goes", async () => {
    const { clock, session, port, run } = await unwatched();

    session.stop();
    await finish(clock, run, 5000);
    assert.equal(port.lines.findLast((line) => /link_loss/.test(line)), "settings link_loss_ms 1000");
    assert.ok(!codes(session).includes("unwatched"));
});

test("link_loss_ms: set back before any other line that waits", async () => {
    const { clock, session, port, run } = await unwatched();
    const other = session.controller.run("bus");

    await clock.advance(100);
    port.say("ok");
    await finish(clock, Promise.all([run, other]));
    assert.deepEqual(port.lines.slice(port.lines.indexOf("diagnose 9")).filter((line) => /link|bus/.test(line)), ["settings link_loss_ms 1000", "bus"]);
});

test("link_loss_ms: nothing is saved while it is 0 for a command", async () => {
    const { clock, port, run, settings } = await unwatched();

    await assert.rejects(settings.save(), { code: "unwatched-still", ms: 1000 });
    port.say("ok");
    await finish(clock, run);
    await finish(clock, settings.save());
    assert.deepEqual(port.lines.filter((line) => /link|save/.test(line)).slice(-2), ["settings link_loss_ms 1000", "save"]);
});

test("link_loss_ms: the outcome of a command stays if it cannot be set back", async () => {
    const { clock, session, setup, port, run, settings } = await unwatched();
    const { onText } = port;

    port.onText = (line) => (line === "settings link_loss_ms 1000" ? (port.say("error 63: the EEPROM is being written"), true) : onText(line));
    port.say("finding 9: no servo answers", "error 49: ended by a key or packet");
    setup.end();
    await finish(clock, run);
    assert.equal(setup.isDiagnosisEnded, true);
    assert.deepEqual(codes(session), ["unwatched-still"]);
    port.onText = onText;
    await finish(clock, settings.apply({ link_loss_ms: 700 }));
    assert.deepEqual(codes(session), []);
});

test("link_loss_ms: a port that is lost meanwhile is told at the next connection, too", async () => {
    const { clock, session, port, run } = await unwatched();

    port.unplug();
    await finish(clock, run);
    assert.ok(codes(session).includes("unwatched-still"));
    await finish(clock, session.connect(port));
    assert.ok(codes(session).includes("unwatched-still"));
    assert.ok(!codes(session).includes("lost"));
});

test("link_loss_ms: set back by a packet before the port is closed", async () => {
    const { clock, session, port, run } = await unwatched();

    session.disconnect();
    await finish(clock, run);
    assert.deepEqual([...port.device.slice(10, 12)], [0xe8, 3]);
    assert.ok(!codes(session).includes("unwatched-still"));
});

test("change of an ID: a full list is forgotten first, and a search fills it again, also after a refusal", async () => {
    const ids = Array.from({ length: 18 }, (_, index) => index + 1);
    const { setup, port, clock } = await rig({
        ids,
        onText: (line, at) => {
            if (line === "id 18 51") at.say("error 50: servo 18: the new ID or rate is taken");
            else if (line === "scan") at.say(...ids.map((id) => `id ${id} model 1`), "18 found, 254 asked", "ok");
            else return false;
            return true;
        },
    });

    assert.equal(setup.isFull, true);
    assert.match(texts.setup.askId(18, true), /list is full.*forget/);
    assert.ok(!/full/.test(texts.setup.askId(18, false)));
    await finish(clock, setup.changeId(18, 50));
    assert.equal(setup.outcome.kind, "id");
    await finish(clock, setup.changeId(18, 51));
    assert.deepEqual(port.lines.filter((line) => /forget|scan|^id/.test(line)), ["servos forget", "id 18 50", "scan", "servos forget", "id 18 51", "scan"]);
    assert.equal(setup.ids.length, 18);
});

test("rate of the bus: read from the controller, again after each change", async () => {
    let rate = 1000000;
    const { setup, clock } = await rig({
        onText: (line, at) => {
            if (line === "baud 1 57600bps") at.say(`ID 1 at ${(rate = 57143)}bps`, "ok");
            else if (line === "bus") at.say(`bus ok at ${rate}bps`, "ok");
            else return false;
            return true;
        },
    });

    assert.equal(setup.busRate, 1000000);
    await finish(clock, setup.changeRate(1, 57600));
    assert.deepEqual([setup.busRate, setup.outcome.kind], [57143, "rate"]);
});

test("found: a search in the view Robot takes what was found before out, but not at other rates", async () => {
    const { clock, session, setup } = await rig();

    await finish(clock, setup.search(""));
    setup.found = [{ id: 1, rate: null }, { id: 3, rate: 19200 }];
    await clock.advance(6000);
    assert.equal(setup.found.length, 2);
    session.robot.setServos([1, 2]);
    assert.deepEqual(setup.found, [{ id: 3, rate: 19200 }]);
});

test("found: a change of ID or rate is shown; one of the bus takes those at its rate out", async () => {
    const { setup, clock } = await rig({ onText: (line, at) => /^(?:id|bus|baud|factory) /.test(line) && (at.say("ok"), true) });
    const foundAfter = async (change) => {
        setup.found = [{ id: 1, rate: null }, { id: 2, rate: 57143 }, { id: 3, rate: 19200 }];
        await finish(clock, change());
        return setup.found?.map(({ id, rate }) => [id, rate]) ?? null;
    };

    assert.deepEqual(await foundAfter(() => setup.changeId(2, 7)), [[1, null], [7, 57143], [3, 19200]]);
    assert.deepEqual(await foundAfter(() => setup.changeId(1, 8)), [[8, null], [2, 57143], [3, 19200]]);
    assert.deepEqual(await foundAfter(() => setup.changeRate(2, 500000)), [[2, 500000], [3, 19200]]);
    assert.deepEqual(await foundAfter(() => setup.factory(3)), [[2, 57143], [1, 1000000]]);
    assert.deepEqual(await foundAfter(() => setup.changeRateOfBus(57600)), [[2, 57143], [3, 19200]]);
    assert.equal(await foundAfter(() => setup.changeRateOfAll(57600)), null);
});

test("change of an ID: a servo that stays as it was is not told as partly done", async () => {
    const { setup, clock } = await rig({
        onText: (line, at) => line === "id 1 2" && (at.say("unchanged: ID 1 at 1000000bps", "error 50: ID in use"), true),
    });

    await finish(clock, setup.changeId(1, 2));
    assert.equal(setup.outcome.kind, "unchanged");
});

test("new servo: one that is not alone is told in words of the page", async () => {
    const { setup, clock } = await rig({ onText: (line, at) => line === "new 4" && (at.say("step 1 of 4: search at six rates", "error 89: the new servo is not alone, nothing was written; then 'new' again"), true) });

    await finish(clock, setup.setUpNew(4));
    assert.match(setup.session.notices[0].remedy, new RegExp(`press “${texts.setup.newStart}”`));
    assert.deepEqual(setup.steps, []);
});

test("new servo: waits through a silent search of 4 s", async () => {
    const { setup, port, clock } = await rig({ onText: (line) => line === "new 4" });
    const setUp = setup.setUpNew(4);

    await clock.advance(4500);
    port.say("error 88: no servo answers at any rate; check power, plug, wiring; then 'new' with this servo alone, 'scan rescue' or 'diagnose'");
    await finish(clock, setUp);
    assert.deepEqual(codes(setup.session), ["command"]);
    assert.equal(setup.outcome, null);
});

test("diagnosis: findings with text and remedy of the tables", async () => {
    const { setup, clock } = await rig({
        onText: (line, port) => {
            if (line !== "diagnose 9") return false;
            port.say("finding 11: no servo has this ID", "asked 4, answered 0, damaged 0, silent 4", "ID 1 at 1000000bps", "ok");
            return true;
        },
    });

    await finish(clock, setup.diagnose(9));
    assert.equal(setup.findings.length, 1);
    const [{ id, text, remedy, measured, isGood }] = setup.findings;

    assert.deepEqual([id, isGood], [9, false]);
    assert.deepEqual(measured.map(texts.setup.measured), ["Asked 4 times: 0 good replies, 0 damaged, 4 without reply.", "Servo 1 answers at 1000000 bit/s."]);
    assert.equal(text, tables().findings[11].text);
    assert.equal(remedy, tables().findings[11].remedy);
});

test("diagnosis: that a servo does not answer is told until it answers", async () => {
    const { setup, port, clock } = await rig({ onText: (line, at) => line === "diagnose 2" && (at.say("finding 11: no servo has this ID", "ok"), true) });

    port.offline.add(2);
    await finish(clock, setup.diagnose(2));
    assert.equal(setup.findings.length, 1);
    port.offline.clear();
    await clock.advance(1000);
    assert.deepEqual(setup.findings, []);
});

test("rate of all: a servo that stays is named", async () => {
    const { setup, clock } = await rig({
        onText: (line, port) => {
            if (line !== "baud all 500000bps") return false;
            port.say("servo 1: stays at 1000000bps: refused by a servo", "bus at 500000bps", "error 87: not all servos of the list did it; the lines above name them");
            return true;
        },
    });

    await finish(clock, setup.changeRateOfAll(500000));
    assert.equal(setup.outcome.kind, "partly");
    assert.equal(setup.outcome.lines[0], "servo 1: stays at 1000000bps: refused by a servo");
    assert.deepEqual(codes(setup.session), ["command"]);
});

test("write: by the console, and read back", async () => {
    const { setup, port, clock, row } = await rig();

    assert.equal(await finish(clock, setup.write(1, row("MIN_VOLTAGE"), 65)), true);
    assert.deepEqual(setLines(port), ["set 1 MIN_VOLTAGE 65raw"]);
    assert.equal(setup.registers.bytes[MIN_VOLTAGE], 65);
});

test("write: a refusal of the console is told", async () => {
    const { setup, clock, row, session } = await rig({
        onText: (line, port) => {
            if (!line.startsWith("set 1")) return false;
            port.say("error 21: servo 1: range error; a value or address is out of its range, read-only, or locked until power-off");
            return true;
        },
    });

    assert.equal(await finish(clock, setup.write(1, row("MIN_VOLTAGE"), 65)), undefined);
    assert.deepEqual(codes(session), ["command"]);
    assert.match(session.notices[0].remedy, /locked until power-off/);
});

test("write: a value that the servo does not keep is told", async () => {
    const { setup, clock, row, session } = await rig({ onText: (line, port) => line.startsWith("set 1") && (port.say("ok"), true) });

    assert.equal(await finish(clock, setup.write(1, row("MIN_VOLTAGE"), 65)), undefined);
    assert.deepEqual(codes(session), ["register-not-taken"]);
});

test("write: a reply that is lost is no failure if the register has the value", async () => {
    const { setup, clock, row, session } = await rig({
        onText: (line, port) => {
            if (!line.startsWith("set 1")) return false;
            if (line.includes("MIN")) port.servos.get(1)[MIN_VOLTAGE] = 65;
            port.say("error 2: servo 1: no reply by the deadline; check power, wiring, ID and baud rate of the servo");
            return true;
        },
    });

    assert.equal(await finish(clock, setup.write(1, row("MIN_VOLTAGE"), 65)), true);
    assert.deepEqual(codes(session), []);
    assert.equal(await finish(clock, setup.write(1, row("MAX_VOLTAGE"), 150)), undefined);
    assert.deepEqual(codes(session), ["command"]);
});

/* A servo that answers PING only once its status return level is 0. */
const silent = (port) => (bytes) => bytes[2] === 1 && port.servos.get(1)[RETURN_LEVEL] === 0 && bytes[4] !== INSTRUCTION.PING;

test("write: a status return level that silences the servo is told as not read back", async () => {
    const { setup, port, clock, row, session } = await rig();

    port.servos.get(1)[RETURN_LEVEL] = 2;
    port.onPacket = silent(port);
    await finish(clock, setup.readAll(1));
    assert.equal(await finish(clock, setup.write(1, row("STATUS_RETURN_LEVEL"), 0), 5000), true);
    assert.deepEqual(codes(session), ["level-silent"]);
    assert.equal(setup.registers.isOld, true);
});

test("restore: a servo that is dead behind its new level is told as silent", async () => {
    const { setup, port, clock } = await rig();
    const isDead = { value: false };
    const file = await finish(clock, setup.backup(1));

    port.servos.get(1)[MIN_VOLTAGE] = 65;
    port.servos.get(1)[RETURN_LEVEL] = 2;
    port.onPacket = (bytes) => silent(port)(bytes) || (isDead.value && bytes[2] === 1);
    await finish(clock, setup.compare(file, 1), 2000);
    const said = port.say.bind(port);

    port.say = (...lines) => ((isDead.value ||= port.servos.get(1)[RETURN_LEVEL] === 0), said(...lines));
    await finish(clock, setup.restore(), 9000);
    assert.deepEqual(setup.restored.map(({ row, why }) => [row.name, why]), [["MIN_VOLTAGE", ""], ["STATUS_RETURN_LEVEL", "servo-silent"]]);
});

test("write: no endless turn, and no limit beyond the goal, while torque is on", async () => {
    const { setup, port, clock, row, session } = await rig();
    const write = (name, raw) => finish(clock, setup.write(1, row(name), raw));

    port.servos.get(1)[TORQUE] = 1;
    assert.equal(await write("CCW_ANGLE_LIMIT", 0), undefined);
    assert.equal(await write("CW_ANGLE_LIMIT", 600), undefined);
    assert.deepEqual([setLines(port), codes(session)], [[], ["limits-move"]]);
    assert.equal(await write("CW_ANGLE_LIMIT", 100), true);
    port.servos.get(1)[TORQUE] = 0;
    assert.equal(await write("CW_ANGLE_LIMIT", 0), true);
    assert.equal(await write("CCW_ANGLE_LIMIT", 0), true);
});

test("write: by a packet without console; refusal is told", async () => {
    const { setup, port, clock, row, session } = await rig({ hasConsole: false });

    assert.equal(setup.has("new"), false);
    session.robot.setServos([1, 2, 3]);
    assert.equal(await finish(clock, setup.write(2, row("MIN_VOLTAGE"), 65)), true);
    assert.equal(writesOf(port).length, 1);
    port.refusals.set(2, 0x08);
    assert.equal(await finish(clock, setup.write(2, row("MIN_VOLTAGE"), 66)), undefined);
    assert.ok(codes(session).includes("refused"));
});

test("readAll: a servo that does not answer is told", async () => {
    const { setup, port, clock, session } = await rig();

    port.offline.add(2);
    await finish(clock, setup.readAll(2), 3000);
    assert.deepEqual(codes(session), ["servo-silent"]);
});

test("restore: writes what differs, nothing else", async () => {
    const { setup, port, clock } = await rig();
    const file = await finish(clock, setup.backup(null));

    assert.deepEqual(JSON.parse(file).servos.map(({ id }) => id), [1, 2, 3]);
    port.servos.get(1)[MIN_VOLTAGE] = 65;
    port.servos.get(3)[MAX_VOLTAGE] = 140;
    await finish(clock, setup.compare(file, null));
    assert.deepEqual(setup.plan.servos.map(({ changes }) => changes.length), [1, 0, 1]);
    assert.deepEqual(setLines(port), []);
    await finish(clock, setup.restore());
    assert.deepEqual(setLines(port), ["set 1 MIN_VOLTAGE 0raw", "set 3 MAX_VOLTAGE 160raw"]);
    assert.deepEqual(setup.restored.map(({ id, why }) => [id, why]), [[1, ""], [3, ""]]);
    assert.equal(setup.plan, null);
});

test("restore of all: a servo that is missing is named, the others are restored", async () => {
    const { setup, port, clock, session } = await rig();
    const file = await finish(clock, setup.backup(null));

    for (const id of [1, 2, 3]) port.servos.get(id)[MIN_VOLTAGE] = 65;
    port.offline.add(1);
    await finish(clock, setup.compare(file, null), 3000);
    assert.deepEqual(setup.plan.servos.map(({ id }) => id), [2, 3]);
    assert.deepEqual(session.notices.map(({ code, ids }) => [code, ids]), [["servo-silent", [1]]]);
    port.offline.add(2);
    await finish(clock, setup.restore(), 3000);
    assert.deepEqual(setLines(port), ["set 3 MIN_VOLTAGE 0raw"]);
    assert.deepEqual(setup.restored.map(({ id, why }) => [id, why]), [[3, ""]]);
    assert.deepEqual(session.notices.map(({ code, ids }) => [code, ids]), [["servo-silent", [1, 2]]]);
    port.offline.add(3);
    await finish(clock, setup.compare(file, null), 3000);
    assert.equal(setup.plan, null);
});

test("restore: shows what a servo did not take", async () => {
    const isLocked = { value: false };
    const { setup, port, clock } = await rig({
        onText: (line, at) => {
            if (!isLocked.value || !/^set 1 MIN/.test(line)) return false;
            at.say("error 21: servo 1: range error; locked until power-off");
            return true;
        },
    });
    const file = await finish(clock, setup.backup(1));

    port.servos.get(1).set([65, 140], MIN_VOLTAGE);
    isLocked.value = true;
    await finish(clock, setup.compare(file, 1));
    await finish(clock, setup.restore());
    assert.deepEqual(setup.restored.map(({ row, why }) => [row.name, why]), [
        ["MIN_VOLTAGE", "servo 1: range error; a value or address is out of its range, read-only, or locked until power-off"],
        ["MAX_VOLTAGE", ""],
    ]);
});

test("restore: a servo that has changed meanwhile gets nothing", async () => {
    const { setup, port, clock, session } = await rig();
    const file = await finish(clock, setup.backup(1));

    port.servos.get(1)[MIN_VOLTAGE] = 65;
    await finish(clock, setup.compare(file, 1));
    port.servos.get(1)[MIN_VOLTAGE] = 70;
    await finish(clock, setup.restore());
    assert.deepEqual(setLines(port), []);
    assert.deepEqual(codes(session), ["backup-changed"]);
});

test("restore: a stop ends it, the rest is not written", async () => {
    const { setup, port, clock, session } = await rig({ onText: (line) => /^set /.test(line) });
    const file = await finish(clock, setup.backup(1));

    port.servos.get(1).set([65, 140], MIN_VOLTAGE);
    await finish(clock, setup.compare(file, 1));
    const restored = setup.restore();

    await clock.advance(100);
    assert.equal(setLines(port).length, 1);
    session.stop();
    await finish(clock, restored);
    assert.equal(setLines(port).length, 1);
    assert.deepEqual(setup.restored.map(({ why }) => why), ["unconfirmed", "ended"]);
    assert.ok(codes(session).includes("stopped"));
});

test("compare: file of another servo, model, or a silent servo", async () => {
    const { setup, port, clock, session } = await rig();
    const file = await finish(clock, setup.backup(1));

    const refused = async (text, id, ms) => {
        await finish(clock, setup.compare(text, id), ms);
        assert.equal(setup.plan, null);
        return codes(session);
    };

    assert.deepEqual(await refused(file, 2), ["backup-other-id"]);
    port.servos.get(1)[1] = 9;
    assert.deepEqual(await refused(file, 1), ["backup-other-model"]);
    port.offline.add(1);
    assert.deepEqual(await refused(file, null, 3000), ["servo-silent"]);
    assert.deepEqual(await refused("{", 1), ["backup-foreign"]);
    port.offline.clear();
    port.servos.get(1)[1] = 1;
    await finish(clock, setup.compare(file, 1));
    assert.deepEqual(codes(session), []); // a file that is accepted withdraws the notice of the one before
    assert.deepEqual(setLines(port), []);
});

test("a set-up that begins on a connection keeps what it reads", async () => {
    const { clock, session } = await rig();
    const setup = new Setup(session);

    await finish(clock, setup.readAll(1));
    assert.equal(setup.registers.id, 1);
});

test("another connection: nothing of the last one is shown", async () => {
    const { setup, port, clock, session } = await rig();

    await finish(clock, setup.readAll(1));
    await session.disconnect();
    const connected = session.connect(port);

    await clock.advance(1000);
    await connected;
    assert.equal(setup.registers, null);
});

/* A restore of MIN_VOLTAGE of servos 1 to 3; `onSet(port, session)` is called at the first command `set`. */
async function restoring(onSet) {
    let calls = 0;
    let it = null;

    it = await rig({ onText: (line, port) => Boolean(line.startsWith("set ") && calls++ === 0 && onSet(port, it.session)) });
    const file = await finish(it.clock, it.setup.backup(null));

    for (const id of [1, 2, 3]) it.port.servos.get(id).set([65, 150], MIN_VOLTAGE);
    for (const id of [1, 2, 3]) it.port.servos.get(id).set([0, 2], 8); // CCW_ANGLE_LIMIT
    await finish(it.clock, it.setup.compare(file, null));
    await finish(it.clock, it.setup.restore(), 3000);
    return it;
}

test("restore: what a stop or a lost port leaves unwritten is shown", async () => {
    for (const onSet of [(port, session) => session.stop(), (port) => port.unplug()]) {
        const { setup } = await restoring((...all) => (onSet(...all), true));

        assert.equal(setup.restored.length, 9);
        assert.deepEqual(setup.restored.map(({ why }) => why), ["unconfirmed", ...new Array(8).fill("ended")]);
    }
});

test("restore: torque that is switched on meanwhile refuses limits that would move the servo", async () => {
    const { setup, port, session } = await restoring((port) => {
        port.servos.get(3)[TORQUE] = 1;
        port.servos.get(3).set([0, 0], 8); // endless turn, which the file ends
    });

    assert.ok(codes(session).includes("limits-move"));
    assert.ok(setup.restored.filter(({ id }) => id === 3).every(({ why }) => why === "ended"));
    assert.ok(setLines(port).every((line) => !line.startsWith("set 3")));
});

test("ID of the device: no servo gets it, and none is proposed", async () => {
    const { setup, session, port, clock } = await rig();

    await finish(clock, setup.changeId(1, 253));
    await finish(clock, setup.setUpNew(253));
    assert.deepEqual(port.lines.filter((line) => /^(id|new) /.test(line)), []);
    assert.match(session.notices.find(({ code }) => code === "id-of-device").text, /^253 is the ID of the controller/);
    session.wire.deviceId = 4;
    assert.equal(setup.freeId, 5);
});

test("ID of the device: a servo that has it is told, its card does not show the device", async () => {
    const { session, port, clock } = await rig({ onText: (line, { say }) => line === "scan" });

    port.onText = (line) => line === "servos" && (port.say("servo 1: online, torque off", "servo 253: online, torque off", "ok"), true);
    await finish(clock, session.robot.findServos());
    assert.deepEqual(session.robot.ids, [1]);
    assert.match(session.notices.find(({ code }) => code === "servo-behind-device").text, /^Servo 253 has the ID of the controller/);
});

test("restore: what a lost port has left is shown after another connection", async () => {
    const { setup, port, session, clock } = await restoring((it) => (it.unplug(), true));
    const whys = () => setup.restored?.map(({ why }) => why);
    const before = whys();
    const connected = session.connect(port);

    await clock.advance(1000);
    await connected;
    assert.equal(session.state, "connected");
    assert.deepEqual(whys(), before);
    assert.equal(setup.isRestoreEarlier, true);
    setup.forgetPlan();
    assert.deepEqual([setup.restored, setup.isRestoreEarlier], [null, false]);
});

test("restore: one that was carried out in full is not shown after another connection", async () => {
    const { setup, port, session, clock } = await rig();
    const file = await finish(clock, setup.backup(1));

    port.servos.get(1)[MIN_VOLTAGE] = 65;
    await finish(clock, setup.compare(file, 1));
    await finish(clock, setup.restore());
    assert.deepEqual(setup.restored.map(({ why }) => why), [""]);
    const connected = session.connect(port);

    await clock.advance(1000);
    await connected;
    assert.equal(setup.restored, null);
});

test("write: a limit that another program has changed meanwhile is not crossed", async () => {
    const { clock, port, session, setup, row } = await rig();

    for (const [low, high, at] of [["CW_ANGLE_LIMIT", "CCW_ANGLE_LIMIT", 0x08], ["MIN_VOLTAGE", "MAX_VOLTAGE", MAX_VOLTAGE]]) {
        await finish(clock, setup.readAll(1));
        port.servos.get(1).set([60, 0].slice(0, row(high).bytes), at);
        assert.equal(await finish(clock, setup.write(1, row(low), 70)), undefined);
        assert.match(session.notices.at(-1).text, new RegExp(`${low} .* would be above ${high}`));
        await finish(clock, setup.write(1, row("MAX_TORQUE"), 500));
    }
    assert.deepEqual(setLines(port), ["set 1 MAX_TORQUE 500raw", "set 1 MAX_TORQUE 500raw"]);
});
