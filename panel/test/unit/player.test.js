// SPDX-License-Identifier: MIT
/* A replay by the page while a command of the console has the wire, at a fake port and a fake clock. */

import assert from "node:assert/strict";
import test from "node:test";
import { Player } from "../../src/model/player.js";
import { Session } from "../../src/model/session.js";
import { INSTRUCTION, wordAt } from "../../src/wire/packet.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

const GOAL = 0x1e;
const POSITION = 0x24;
const SLOW = { ids: [1], duration: 60000, at: (t) => [100 + (Math.min(t, 60000) / 60000) * 800] };

/* A servo that is at its goal at once. The port answers each packet after 3 ms, and no line that begins with "scan". */
async function rig() {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });
    const answer = port.answer.bind(port);
    const registers = port.addServo(1, 1);
    const move = () => {
        registers.copyWithin(POSITION, GOAL, GOAL + 2);
        clock.after(10, move);
    };

    port.answer = (bytes) => clock.after(3, () => answer(bytes));
    port.onText = (line) => line.startsWith("scan");
    move();
    const connected = session.connect(port);

    await clock.advance(3000);
    await connected;
    port.written = [];
    const goals = () => port.packets.filter((bytes) => bytes[4] === INSTRUCTION.WRITE && bytes[5] === GOAL).map((bytes) => wordAt(bytes, 6));

    return { clock, port, session, goals, player: new Player(session) };
}

test("replay: ends while a command has the wire; no goal leaves behind it", async () => {
    const { clock, port, session, goals, player } = await rig();
    const played = player.play(SLOW).then(() => "played", ({ code }) => code);

    await clock.advance(6000);
    assert.equal(player.state, "playing");
    const search = session.controller.scan({ how: "all" });

    await clock.advance(1000);
    assert.equal(player.state, "idle");
    assert.equal(await played, "late");
    const before = goals().length;

    port.say("0 found", "ok");
    await clock.advance(10);
    await search;
    await clock.advance(2000);
    assert.deepEqual(goals().slice(before), []);
});

for (const [what, stop, expected] of [
    ["the user's Stop", { stopState: "verified" }, "ended"],
    ["the user's Stop, under way", { stopState: "stopping" }, "ended"],
    ["another program", {}, "motion-inhibited"],
])
    test(`replay and go to: an inhibit by ${what}`, async () => {
        for (const call of [(player) => player.play(SLOW), (player) => player.goTo(new Map([[1, 900]]))]) {
            const { clock, port, session, player } = await rig();

            port.answer = () => {}; // the servo does not arrive
            const played = call(player).then(() => "ended", ({ code }) => code);

            session.robot.takeStop({ inhibited: stop.stopState !== "stopping", off: [], on: [1] });
            Object.assign(session, stop);
            await clock.advance(100);
            assert.equal(await played, expected);
        }
    });

test("replay: ends if the page is held up; no goal leaves late", async () => {
    const { clock, goals, player } = await rig();
    const played = player.play(SLOW).then(() => "played", ({ code }) => code);

    await clock.advance(6000);
    assert.equal(player.state, "playing");
    const before = goals().length;

    clock.stall(500);
    await clock.advance(1000);
    assert.equal(await played, "motion-late");
    assert.deepEqual(goals().slice(before), []);
});

test("replay: goes on behind a command of 0.2 s", async () => {
    const { clock, port, session, goals, player } = await rig();
    const played = player.play(SLOW).then(() => "played", ({ code }) => code);

    await clock.advance(6000);
    const search = session.controller.scan();

    await clock.advance(200);
    port.say("0 found", "ok");
    await clock.advance(10);
    await search;
    const before = goals().length;

    await clock.advance(1000);
    assert.equal(player.state, "playing");
    assert.ok(goals().length > before);
    player.end();
    await clock.advance(1000);
    await played;
});

test("go to: ends if its goal could not leave", async () => {
    const { clock, port, session, goals, player } = await rig();
    const search = session.controller.scan();

    await clock.advance(100);
    const gone = player.goTo(new Map([[1, 900]])).then(() => "there", ({ code }) => code);

    await clock.advance(1000);
    assert.equal(await gone, "late");
    port.say("0 found", "ok");
    await clock.advance(10);
    await search;
    await clock.advance(1000);
    assert.deepEqual(goals(), []);
});

test("go to: a goal that was dropped behind a short command is sent again", async () => {
    const { clock, port, session, goals, player } = await rig();
    const search = session.controller.scan();

    await clock.advance(20);
    const gone = player.goTo(new Map([[1, 900]])).then(() => "there", ({ code }) => code);

    await clock.advance(250);
    port.say("0 found", "ok");
    await clock.advance(10);
    await search;
    await clock.advance(1000);
    assert.equal(await gone, "there");
    assert.equal(goals().at(-1), 900);
});
