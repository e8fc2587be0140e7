// SPDX-License-Identifier: MIT
/* The session at a fake port and a fake clock: stop and release. */

import assert from "node:assert/strict";
import test from "node:test";
import { Session } from "../../src/model/session.js";
import { FakeClock } from "../support/fake_clock.js";
import { FakePort } from "../support/fake_port.js";
import { tables } from "../support/tables.js";

async function rig() {
    const clock = new FakeClock();
    const port = new FakePort();
    const session = new Session({ tables: tables(), clock });

    port.addServo(1, 1);
    const connect = session.connect(port);

    await clock.advance(2000);
    await connect;
    return { clock, port, session };
}

test("stop: Ctrl-X leaves before anything else", async () => {
    const { port, session } = await rig();
    let stops = 0;

    session.robot.forgetGoals = () => (stops = port.stops);
    session.stop();
    assert.equal(stops, 1);
});
