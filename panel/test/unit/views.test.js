// SPDX-License-Identifier: MIT
/* What views do that needs no browser. */

import assert from "node:assert/strict";
import test from "node:test";
import { Robot } from "../../src/model/robot.js";
import { BoardView } from "../../src/views/board_view.js";
import { RobotView } from "../../src/views/robot_view.js";
import { texts } from "../../src/texts.js";
import { attributeOf, valuesOf } from "../support/rendered.js";

/* A browser that a view can be taken out of. */
Object.assign(globalThis, { document: new EventTarget(), removeEventListener: () => {}, cancelAnimationFrame: () => {} });

/* A session whose servo 1 is in endless turn, with torque. */
function turning() {
    const session = new EventTarget();
    const robot = new Robot({ wire: { state: "ready", clock: { now: () => 0 } } });

    robot.setServos([1]);
    Object.assign(robot.servos.get(1), { torque: true, presence: "online", raw: { low: 0, high: 0 } });
    return Object.assign(session, { isConnected: true, clock: { now: () => 0 }, robot, attempt: (call) => call() });
}

test("robot: an endless turn ends when the view is left", () => {
    const view = new RobotView();
    const slider = { value: "20" };
    const held = [];

    view.session = turning();
    view.session.robot.hold = (id) => held.push(id);
    attributeOf(view.render(), "@input")({ target: slider });
    assert.equal(view.session.robot.servos.get(1).goalState, "waiting");
    view.disconnectedCallback();
    view.disconnectedCallback();
    assert.deepEqual(held, [1]);
    assert.equal(slider.value, 0);
});

test("board: what is not known of driving is not shown as good", () => {
    const view = new BoardView();
    const shown = (device, hasDevice = true) => {
        view.session = { isConnected: true, controller: { profile: "full" }, wire: { hasDevice }, robot: { device } };
        const values = valuesOf(view.render());
        const at = values.findIndex(([before]) => before.endsWith('class="driving '));

        return values.slice(at, at + 2).map(([, value]) => value);
    };

    assert.deepEqual(shown(null), ["", texts.board.notRead]);
    assert.deepEqual(shown(null, false), ["", texts.board.unknownState]);
    assert.deepEqual(shown({ inhibit: 1 }), ["bad", texts.board.inhibited]);
    assert.deepEqual(shown({ inhibit: 0 }), ["good", texts.board.allowed]);
});
