// SPDX-License-Identifier: MIT
/* The operations of the view Set-up with the real firmware in the simulator: profiles full, console and bridge. */

import assert from "node:assert/strict";
import test from "node:test";
import { Session } from "../../src/model/session.js";
import { Settings } from "../../src/model/settings.js";
import { Setup } from "../../src/model/setup.js";
import { PtyPort, Simulator } from "../support/simulator.js";
import { tables } from "../support/tables.js";

const MIN_VOLTAGE = 0x0c;
const FACTORY_MIN_VOLTAGE = 60;

async function rig(t, options) {
    const simulator = await Simulator.start(options);
    const session = new Session({ tables: tables() });
    const setup = new Setup(session);

    t.after(async () => {
        await session.disconnect();
        await simulator.end();
    });
    await session.connect(new PtyPort(simulator.path));
    assert.equal(session.state, "connected", JSON.stringify(session.notices));
    session.notices = [];
    return { session, setup, simulator, row: (name) => setup.rows.find((one) => one.name === name) };
}

const codes = (session) => session.notices.map(({ code, text }) => `${code}: ${text}`);

/* Backup, change, compare, restore of all servos. */
async function restoreAll({ session, setup, row }) {
    const file = await setup.backup(null);

    assert.equal(await setup.write(2, row("MIN_VOLTAGE"), 65), true);
    assert.equal(await setup.write(3, row("CCW_ANGLE_LIMIT"), 700), true);
    assert.equal(setup.registers.bytes[8] | (setup.registers.bytes[9] << 8), 700);
    await setup.compare(file, null);
    assert.deepEqual(
        setup.plan.servos.flatMap(({ id, changes }) => changes.map(({ row: { name }, now, file: saved }) => [id, name, now, saved])),
        [
            [2, "MIN_VOLTAGE", 65, FACTORY_MIN_VOLTAGE],
            [3, "CCW_ANGLE_LIMIT", 700, 1023],
        ],
    );
    await setup.restore();
    assert.deepEqual(setup.restored.map(({ id, why }) => [id, why]), [[2, ""], [3, ""]]);
    await setup.readAll(2);
    assert.equal(setup.registers.bytes[MIN_VOLTAGE], FACTORY_MIN_VOLTAGE);
    await setup.compare(file, null);
    assert.deepEqual(setup.plan.servos.flatMap(({ changes }) => changes), []);
    assert.deepEqual(codes(session), []);
}

test("profile full: backup, change, restore", async (t) => restoreAll(await rig(t)));

test("link_loss_ms: back in force after the port was closed during a search", async (t) => {
    const { session, setup, simulator } = await rig(t);
    const settings = new Settings(session);

    await settings.read();
    await settings.apply({ link_loss_ms: 1500 });
    const search = setup.search("rescue");

    await new Promise((resolve) => setTimeout(resolve, 500));
    assert.equal(session.controller.unwatchedMs, 1500);
    await session.disconnect();
    await search;
    await session.connect(new PtyPort(simulator.path));
    await settings.read();
    assert.equal(settings.values.get("link_loss_ms"), 1500);
});

/* A restore of two registers and of the level at which servo 1 answers PING only, or PING and READ. */
async function restoreLevel({ session, setup, row }, level) {
    const file = JSON.parse(await setup.backup(1));

    file.servos[0].registers.STATUS_RETURN_LEVEL = level;
    assert.equal(await setup.write(1, row("MIN_VOLTAGE"), 65), true);
    assert.equal(await setup.write(1, row("MAX_VOLTAGE"), 150), true);
    await setup.compare(JSON.stringify(file), 1);
    await setup.restore();
    assert.deepEqual(setup.restored.map((one) => [one.row.name, one.why]), [
        ["MIN_VOLTAGE", ""], ["MAX_VOLTAGE", ""], ["STATUS_RETURN_LEVEL", level === 0 ? "unread" : ""],
    ]);
    assert.deepEqual(codes(session), []);
}

for (const [profile, options] of [["full", {}], ["bridge", { elf: "bridge" }]])
    for (const level of [0, 1])
        test(`profile ${profile}: restore of the status return level ${level}`, async (t) => {
            const robot = await rig(t, options);

            if (profile === "bridge") await robot.setup.search("");
            await restoreLevel(robot, level);
        });

test("profile console: backup, change, restore", async (t) => {
    const robot = await rig(t, { board: "arbotix" });

    assert.equal(robot.session.controller.profile, "console");
    assert.equal(robot.setup.has("new"), false);
    assert.equal(robot.setup.has("id"), true);
    await restoreAll(robot);
});

test("profile bridge: search by packets, backup, change, restore", async (t) => {
    const robot = await rig(t, { elf: "bridge" });

    assert.equal(robot.session.controller.profile, "bridge");
    await robot.setup.search("");
    assert.deepEqual(robot.setup.found.map(({ id }) => id), [1, 2, 3]);
    await restoreAll(robot);
});

test("profile full: search, ID, rates of all, factory values", async (t) => {
    const { setup, session } = await rig(t, { servos: "2-4" });

    await setup.search("");
    assert.deepEqual(setup.found.map(({ id, model }) => [id, model]), [[2, 1], [3, 1], [4, 1]]);
    await setup.changeId(4, 9);
    assert.equal(setup.id, 9);
    assert.deepEqual(setup.ids, [2, 3, 9]);
    await setup.changeRateOfAll(500000);
    assert.equal(setup.outcome.kind, "rateOfAll");
    await setup.search("all");
    assert.deepEqual(setup.found.map(({ id, rate }) => [id, rate]), [[2, 500000], [3, 500000], [9, 500000]]);
    await setup.changeRateOfAll(1000000);
    await setup.factory(9);
    assert.equal(setup.outcome.kind, "factory");
    await setup.search("");
    assert.deepEqual(setup.found.map(({ id }) => id), [1, 2, 3]);
    assert.deepEqual(codes(session), []);
    await setup.changeId(2, 3);
    assert.match(codes(session)[0], /error 50, servo 2: the new ID is taken/);
});

test("profile full: a new servo gets its ID; not beside another", async (t) => {
    const alone = await rig(t, { servos: "1" });

    await alone.setup.setUpNew(5);
    assert.equal(alone.setup.outcome.kind, "newKnown"); // the page has found servo 1
    await alone.setup.setUpNew(5, { forgets: true });
    assert.equal(alone.setup.outcome.kind, "new", JSON.stringify(alone.session.notices));
    assert.match(alone.setup.steps.at(-1), /^servo 5 is set up/);
    assert.ok(alone.setup.ids.includes(5));
    const many = await rig(t);

    await many.setup.setUpNew(7);
    assert.equal(many.setup.outcome, null);
    assert.match(codes(many.session)[0], /error 89, the new servo is not alone/);
});

test("profile full: a search is ended by a key", async (t) => {
    const { setup, session } = await rig(t);

    for (const how of ["all", "rescue"]) {
        const progress = new Promise((resolve) => setup.addEventListener("change", () => setup.operation?.done > 0 && resolve()));
        const search = setup.search(how);

        await progress;
        setup.end();
        await search;
        assert.equal(setup.isPartial, true);
        assert.deepEqual(setup.found.map(({ id }) => id), [1, 2, 3]);
    }
    assert.deepEqual(codes(session), []);
});

test("profile full: new and diagnose are ended by a key", async (t) => {
    const { setup, session } = await rig(t);
    const begun = () => new Promise((resolve) => session.addEventListener("traffic", resolve, { once: true }));

    for (const call of [() => setup.setUpNew(9), () => setup.diagnose(9)]) {
        const isBegun = begun();
        const run = call();

        await isBegun;
        setup.end();
        await run;
    }
    assert.equal(setup.outcome.kind, "newEnded");
    assert.equal(setup.isDiagnosisEnded, true);
    assert.deepEqual(codes(session), []);
});

test("profile full: diagnosis of one, of all, of an absent servo", async (t) => {
    const { setup, session } = await rig(t);

    await setup.diagnose(2);
    assert.deepEqual(setup.findings.map(({ id, number, measured }) => [id, number, measured[1]]), [[2, 1, "ID 2 at 1000000bps"]]);
    await setup.diagnose("all");
    assert.deepEqual(setup.findings.map(({ id, number }) => [id, number]), [[1, 1], [2, 1], [3, 1]]);
    await setup.diagnose(9);
    assert.deepEqual(setup.findings.map(({ id, number, isGood }) => [id, number, isGood]), [[9, 11, false]]);
    assert.deepEqual(codes(session), []);
});

test("refusals: a locked servo, a goal while driving is inhibited", async (t) => {
    const { setup, session, row } = await rig(t);
    const file = await setup.backup(1);

    await setup.write(1, row("MIN_VOLTAGE"), 65);
    assert.equal(await setup.write(1, row("LOCK"), 1), true);
    assert.equal(await setup.write(1, row("MAX_VOLTAGE"), 150), undefined);
    assert.match(session.notices.at(-1).remedy, /locked until power-off/);
    await setup.compare(file, 1);
    await setup.restore();
    assert.equal(setup.restored.length, 1);
    assert.match(setup.restored[0].why, /locked until power-off/);
    await session.stop();
    assert.equal(await setup.write(2, row("TORQUE_ENABLE"), 1), undefined);
    assert.match(session.notices.at(-1).text, /driving is inhibited/);
});
