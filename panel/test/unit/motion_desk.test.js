// SPDX-License-Identifier: MIT
/* What the view Motion works on, at a session without a port. */

import assert from "node:assert/strict";
import test from "node:test";
import { MotionDesk } from "../../src/model/motion_desk.js";
import { Session } from "../../src/model/session.js";
import { tables } from "../support/tables.js";

/* The notices of a motion of the board that ends with error 54; `meanwhile` is called before. */
function ended(meanwhile) {
    const session = new Session({ tables: tables() });
    const tell = (state, error) => {
        session.robot.motion = { state, error };
        session.dispatchEvent(new Event("change"));
    };

    session.robot = {};
    new MotionDesk(session);
    tell(2, 0);
    meanwhile(session);
    tell(2, 0);
    session.stopState = "none";
    tell(0, 54);
    return session.notices;
}

/* A desk with `names` as poses of servo 1. */
function deskWith(...names) {
    const session = new Session({ tables: tables() });
    const desk = new MotionDesk(session);

    for (const name of names) desk.motions.setPose(name, new Map([[1, 512]]));
    return { session, desk };
}

const posesOf = (steps) => steps.map(({ pose }) => pose);

test("step: each new one takes the next pose of the list, after the last pose the first", async () => {
    const { desk } = deskWith("up", "down", "left");

    desk.showPose("left");
    for (let count = 0; count < 4; count++) await desk.addStep();
    assert.deepEqual(posesOf(desk.steps), ["up", "down", "left", "up"]);
    await desk.changeStep(3, { pose: "down" });
    await desk.addStep();
    assert.equal(desk.steps.at(-1).pose, "left");
});

test("motion: the notice of its end tells the error in words", () => {
    assert.equal(ended(() => {})[0].text, "The motion has ended with error 54: stopped: driving is inhibited.");
});

test("motion: its end by a stop of the user is no notice", () => {
    assert.deepEqual(ended((session) => (session.stopState = "stopping")), []);
});

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
