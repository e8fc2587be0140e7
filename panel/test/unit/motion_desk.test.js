// SPDX-License-Identifier: MIT
/* What the view Motion works on, at a session without a port. */

import assert from "node:assert/strict";
import test from "node:test";
import { MotionDesk } from "../../src/model/motion_desk.js";
import { Session } from "../../src/model/session.js";
import { tables } from "../support/tables.js";

test("play: the board is asked again after a load that has failed", async () => {
    const session = new Session({ tables: tables() });
    const desk = new MotionDesk(session);
    const outcomes = [Promise.reject(Object.assign(new Error(), { code: "timeout" })), Promise.resolve()];
    let loads = 0;

    session.controller = {};
    Object.defineProperties(desk.store, { canStore: { value: true }, canPlay: { value: true } });
    desk.store.load = () => outcomes[loads++];
    await desk.show();
    await desk.show();
    assert.equal(loads, 1, "the view is rendered often");
    await desk.play();
    await desk.play();
    assert.equal(loads, 2);
});
