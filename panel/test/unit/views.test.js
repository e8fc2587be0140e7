// SPDX-License-Identifier: MIT
/* What views do that needs no browser. */

import "../support/elements.js";
import assert from "node:assert/strict";
import test from "node:test";
import { pathOfPoints } from "../../src/model/path.js";
import { Robot } from "../../src/model/robot.js";
import { chart } from "../../src/views/motion_chart.js";
import { BoardView } from "../../src/views/board_view.js";
import { colourOf, dashesOf } from "../../src/views/lines.js";
import { RobotView } from "../../src/views/robot_view.js";
import { texts } from "../../src/texts/texts.js";
import { Decoder } from "../../src/model/decode.js";
import "../../src/views/board_settings.js";
import { modeOf } from "../../src/views/part.js";
import "../../src/views/packets_send.js";
import { registerRows } from "../../src/model/registers.js";
import "../../src/views/setup_backup.js";
import "../../src/views/setup_diagnose.js";
import "../../src/views/setup_registers.js";
import { settle } from "../support/fake_clock.js";
import { tables } from "../support/tables.js";
import { attributeOf, valuesOf } from "../support/rendered.js";

/* A browser that a view can be put into and taken out of. */
Object.assign(globalThis, {
    document: new EventTarget(),
    addEventListener: () => {},
    removeEventListener: () => {},
    requestAnimationFrame: () => 0,
    cancelAnimationFrame: () => {},
});

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

test("robot: an inhibit by a lost host link names the link, once for all servos", () => {
    const view = new RobotView();

    view.session = turning();
    view.session.robot.setServos([1, 2]);
    for (const servo of view.session.robot.servos.values()) servo.takeLine("servo: online, torque on, inhibited: host link lost, alarms: range");
    const shown = valuesOf(view.render()).map(([, value]) => value);
    const advices = shown.filter((value) => typeof value === "string" && /inhibited/.test(value));

    assert.deepEqual(advices, [texts.robot.host]);
    assert.match(texts.robot.host, /lost the link/);
    assert.equal(shown.filter((value) => value === texts.robot.inhibited).length, 2);
});

test("robot: if no servo answers, the advice is about the line, once", () => {
    const view = new RobotView();
    const countOf = (text) => valuesOf(view.render()).filter(([, value]) => value === text).length;

    view.session = turning();
    const { robot } = view.session;

    robot.setServos([1, 2]);
    for (const servo of robot.servos.values()) servo.presence = "offline";
    assert.equal(countOf(texts.robot.allSilent), 1);
    robot.device = { busState: 2 };
    robot.servos.get(1).presence = "online"; // when it was asked last
    assert.equal(countOf(texts.robot.lineLow), 1);
    robot.device = null;
    robot.servos.get(2).takeLine("not at the rate of the bus, torque unknown");
    assert.equal(countOf(texts.robot.otherRate), 1);
});

test("robot: torque that is not known is not shown as off", () => {
    const view = new RobotView();
    const shown = (torque) => {
        Object.assign(view.session.robot.servos.get(1), { torque, raw: {} });
        const rendered = view.render();

        return [...[".checked", ".indeterminate"].map((name) => attributeOf(rendered, name)?.values[0]), attributeOf(rendered, "aria-valuetext").split("torque is ")[1]];
    };

    view.session = turning();
    assert.deepEqual(shown(null), [false, true, "not known"]);
    assert.deepEqual(shown(false), [false, false, "off"]);
    assert.deepEqual(shown(true), [true, false, undefined]);
});

/* A view in the document whose dial of servo 1 is dragged, and its pointer. */
function dragging(t) {
    const view = new RobotView();
    const dial = { focus: () => {}, getBoundingClientRect: () => ({ left: 0, top: 0, width: 100 }) };
    const currentTarget = { ownerSVGElement: dial, setPointerCapture: () => {} };
    const goals = [];
    const event = (name, at, buttons, button = 0) =>
        attributeOf(view.render(), `@pointer${name}`)({ currentTarget, clientX: at, clientY: 50, button, buttons, preventDefault: () => {} });

    view.session = turning();
    view.session.robot.servos.get(1).raw = { low: 0, high: 1023 };
    view.session.robot.setGoal = (id) => goals.push(id);
    view.shouldUpdate = () => false; // draws nothing
    view.connectedCallback();
    t.after(() => view.disconnectedCallback());
    event("down", 10, 2, 2);
    event("down", 10, 4, 1);
    event("move", 12, 2);
    assert.equal(goals.length, 0);
    event("down", 10, 1);
    event("move", 12, 1);
    assert.equal(goals.length, 2);
    return { view, session: view.session, goals, move: (buttons = 1) => event("move", 14, buttons) };
}

const letsGo = {
    "the button is up": ({ move }) => move(0),
    "the view is left": ({ view }) => {
        view.disconnectedCallback();
        view.connectedCallback();
    },
    "a stop begins": ({ session }) => (session.stopState = "stopping"),
    "the port is closed": ({ session }) => (session.isConnected = false),
    "driving is inhibited": ({ session }) => (session.robot.device = { inhibit: 1 }),
};

for (const [what, call] of Object.entries(letsGo))
    test(`robot: a drag ends when ${what}`, (t) => {
        const drag = dragging(t);

        call(drag);
        drag.session.dispatchEvent(new Event("change"));
        Object.assign(drag.session, { stopState: "none", isConnected: true });
        drag.session.robot.device = null;
        drag.move();
        assert.equal(drag.goals.length, 2);
    });

test("board: what is not known of driving is not shown as good", () => {
    const view = new BoardView();
    const shown = (device, hasDevice = true, lostIds = []) => {
        view.session = { isConnected: true, controller: { profile: "full" }, wire: { hasDevice }, robot: { device }, lostIds };
        const values = valuesOf(view.render());
        const at = values.findIndex(([before]) => before.endsWith('class="driving '));

        return values.slice(at, at + 2).map(([, value]) => value);
    };

    assert.deepEqual(shown(null), ["", texts.board.notRead]);
    assert.deepEqual(shown(null, false), ["", texts.board.unknownState]);
    assert.deepEqual(shown({ inhibit: 1 }), ["bad", texts.board.inhibited]);
    assert.deepEqual(shown({ inhibit: 0 }), ["good", texts.board.allowed]);
    assert.deepEqual(shown({ inhibit: 0 }, true, [2, 5]), ["warn", "Driving is allowed, but 2 servos are inhibited."]);
    assert.equal(attributeOf(view.render(), "?disabled"), false);
});

test("board: a servo whose torque went off by itself is told beside the alarms", () => {
    const view = new BoardView();
    const part = new (customElements.get("panel-board-state"))();
    view.session = { isConnected: true, controller: { profile: "full" }, wire: {}, robot: { device: null }, lostIds: [5] };
    part.lost = attributeOf(view.render(), ".lost");
    part.list = [];
    const shown = valuesOf(part.render()).map(([, value]) => value);

    assert.ok(shown.includes("Servo 5 inhibited:"));
    assert.ok(shown.includes(texts.robot.lost));
    assert.match(texts.robot.lost, /heat, overload or lost power/);
});

test("robot: a drag ends if its dial is moved on the screen, as by a card above that grows", () => {
    const view = new RobotView();
    let top = 0;
    const dial = { focus: () => {}, getBoundingClientRect: () => ({ left: 0, top, width: 100 }) };
    const at = (clientX) => ({ button: 0, buttons: 1, clientX, clientY: 0, preventDefault: () => {}, currentTarget: { ownerSVGElement: dial, setPointerCapture: () => {} } });

    view.session = turning();
    const { robot } = view.session;
    const goals = [];

    robot.servos.get(1).raw = { low: 0, high: 1023 };
    robot.setGoal = (id, degrees) => goals.push(degrees);
    attributeOf(view.render(), "@pointerdown")(at(40));
    attributeOf(view.render(), "@pointermove")(at(60));
    assert.equal(goals.length, 2);
    top = 20;
    for (const x of [60, 70]) attributeOf(view.render(), "@pointermove")(at(x));
    assert.equal(goals.length, 2);
});

/* The settings of a controller that answers `settings NAME VALUE` when the test says so. */
async function settingsPart() {
    const part = new (customElements.get("panel-settings"))();
    const answers = [];
    const run = (line) => (line === "settings" ? Promise.resolve(tables().settings.map(({ name, initial }) => `${name} = ${initial}`))
        : new Promise((resolve) => answers.push(() => resolve([]))));
    const field = (name) => {
        const values = valuesOf(part.render());
        const own = values.slice(values.findIndex(([, value]) => value === `setting-${name}`));

        return { value: own.find(([before]) => before.endsWith(".value="))[1], input: own.find(([before]) => before.endsWith("@input="))[1] };
    };

    part.requestUpdate = () => {};
    part.session = {
        isConnected: true, wire: { hasConsole: true }, tables: tables(), robot: { ids: [] },
        controller: { modeBefore: null, run, takeWatched: () => {} }, attempt: (call) => call(), notify: () => {},
    };
    part.updated();
    await settle();
    const apply = () => valuesOf(part.render()).filter(([before]) => before.endsWith("@click="))[0][1]();

    return { part, apply, shown: (name) => field(name).value, type: (name, value) => field(name).input({ target: { value } }),
        answer: async () => (answers.shift()(), settle()) };
}

test("settings: read again after a first read that failed", async () => {
    const part = new (customElements.get("panel-settings"))();
    const answers = [Promise.reject(new Error("stopped")), Promise.resolve(["cycle_us = 20000"])];
    const button = () => valuesOf(part.render()).find(([before]) => before.endsWith("@click="))?.[1];

    part.requestUpdate = () => {};
    part.session = {
        isConnected: true, wire: { hasConsole: true }, tables: tables(), robot: { ids: [] },
        controller: { modeBefore: null, run: () => answers.shift() }, attempt: (call) => call().catch(() => {}), notify: () => {},
    };
    part.updated();
    assert.equal(button(), undefined);
    await settle();
    assert.ok(button(), "a button that reads again");
    button()();
    await settle();
    assert.ok(valuesOf(part.render()).some(([, value]) => value === "20000"));
});

test("settings: read again after a reset of the controller, and what was typed before it is dropped", async () => {
    const { part, shown, type } = await settingsPart();
    const { session } = part;
    const mode = modeOf(session);

    type("link_loss_ms", "1234");
    session.controller.run = () => Promise.resolve(["link_loss_ms = 700", "settings at start: as saved"]);
    session.starts = 2;
    assert.notEqual(modeOf(session), mode); // so the part is rendered
    part.updated();
    await settle();
    assert.equal(shown("link_loss_ms"), "700");
});

test("settings: read again when the view is opened again; what is typed stays", async () => {
    const { part, shown, type } = await settingsPart();

    type("cycle_us", "20000");
    part.session.controller.run = () => Promise.resolve(["link_loss_ms = 700"]); // by the console
    part.shouldUpdate = () => false;
    part.connectedCallback();
    await settle();
    assert.deepEqual([shown("link_loss_ms"), shown("cycle_us")], ["700", "20000"]);
});

test("settings: tells when they have changed, so that the status is read again", async () => {
    const { part, apply, type, answer } = await settingsPart();
    let isTold = false;

    part.onDone = () => (isTold = true);
    type("link_loss_ms", "1234");
    const applied = apply();

    await settle();
    assert.ok(!isTold);
    await answer();
    await applied;
    assert.ok(isTold);
});

test("settings: what is typed while an Apply is under way stays", async () => {
    const { apply, shown, type, answer } = await settingsPart();
    const initial = shown("link_loss_ms");

    type("link_loss_ms", "1234");
    const applied = apply();

    await settle();
    type("link_loss_ms", "1235"); // the same field
    type("cycle_us", "20000"); // another one
    await answer();
    await applied;
    assert.deepEqual([shown("link_loss_ms"), shown("cycle_us")], ["1235", "20000"]);
    type("cycle_us", "0");
    const again = apply();

    await settle();
    type("link_loss_ms", "1234"); // the value in force, which is about to change
    await answer();
    await answer();
    await again;
    assert.equal(shown("link_loss_ms"), "1234");
    type("link_loss_ms", initial);
    assert.equal(shown("link_loss_ms"), initial);
});

test("restore: tells that a servo will turn without end", () => {
    const part = new (customElements.get("panel-setup-backup"))();
    const row = registerRows(tables()).find(({ name }) => name === "CCW_ANGLE_LIMIT");
    const shown = (low) => {
        const entry = { registers: { CW_ANGLE_LIMIT: low, CCW_ANGLE_LIMIT: 0 } };

        part.setup = { id: 1, ids: [1], plan: { servos: [{ id: 1, entry, changes: [{ row, now: 1023, file: 0 }] }] } };
        return valuesOf(part.render()).some(([, value]) => value === texts.setup.endless([1]));
    };

    assert.deepEqual([shown(0), shown(1)], [true, false]);
});

test("diagnosis: its result comes into view at its end", () => {
    const part = new (customElements.get("panel-setup-diagnose"))();
    let shown = 0;

    part.querySelector = () => ({ scrollIntoView: () => shown++ });
    for (const kind of ["search", "diagnose", "diagnose", undefined, undefined, "search"]) {
        part.setup = { operation: kind && { kind } };
        part.updated();
    }
    assert.equal(shown, 1);
});

test("factory: not offered while another servo has ID 1", () => {
    assert.match(texts.setup.askFactory(3, true), /First give servo 1 another ID/);
    assert.doesNotMatch(texts.setup.askFactory(1, false), /First/);
});

test("diagnosis: a remedy names the button Search, not the command", () => {
    const part = new (customElements.get("panel-setup-diagnose"))();

    part.setup = Object.assign(new EventTarget(), {
        ids: [], has: () => true, isRunning: false, operation: null, session: { robot: { servos: new Map() } },
        findings: [{ id: 1, ...tables().findings[11], measured: [], isGood: false }],
    });
    const shown = valuesOf(part.render()).map(([, value]) => value).filter((value) => typeof value === "string");

    assert.ok(shown.includes("check plug and power of this servo; then press “Search”: it may have another ID"), shown.join());
});

test("registers: Enter writes, and presses no button of the question behind it", () => {
    const part = new (customElements.get("panel-setup-registers"))();
    const row = tables().registers.find(({ name }) => name === "LED");
    const written = [];

    part.setup = Object.assign(new EventTarget(), {
        id: 1, rows: [{ ...row, scale: tables().units[row.unit] ?? { name: "", per: 1, of: 1, digits: 0 } }], registers: { id: 1, bytes: new Uint8Array(64), at: 0 },
        isRunning: false, operation: null, write: (...call) => written.push(call),
        session: { clock: { now: () => 0 }, robot: { servos: new Map() }, wire: {} },
    });
    part.querySelector = () => null;
    valuesOf(part.render()).filter(([before]) => before.endsWith("@click=")).at(-1)[1]();
    let isPrevented = false;

    attributeOf(part.render(), "@keydown")({ key: "Enter", target: { matches: () => true }, preventDefault: () => (isPrevented = true) });
    assert.deepEqual([isPrevented, written.length], [true, 1]);
});

test("registers: a wrong value leaves no old one in the other field, and the question names what is written", () => {
    const part = new (customElements.get("panel-setup-registers"))();
    const row = tables().registers.find(({ name }) => name === "MIN_VOLTAGE");

    part.setup = Object.assign(new EventTarget(), {
        id: 1, rows: [{ ...row, scale: tables().units[row.unit] }], registers: { id: 1, bytes: new Uint8Array(64).fill(60), at: 0 },
        isRunning: false, operation: null, session: { clock: { now: () => 0 }, robot: { servos: new Map() }, wire: {} },
    });
    part.querySelector = () => null;
    valuesOf(part.render()).filter(([before]) => before.endsWith("@click=")).at(-1)[1]();
    const raw = () => valuesOf(part.render()).filter(([before]) => before.endsWith(".value=")).at(-1)[1];

    assert.equal(raw(), "60");
    attributeOf(part.render(), "@input")({ target: { value: "99" } });
    assert.equal(raw(), "");
    assert.match(texts.setup.asks(3, "LOCK", "1", "Write it?"), /^Servo 3, LOCK = 1: /);
});

test("send: an empty field is no error and cannot be sent", () => {
    const part = new (customElements.get("panel-send"))();
    const shown = (form) => {
        part.form = { ...part.form, hex: "", values: "", ...form };
        const values = valuesOf(part.render());
        const valueAfter = (text) => values.find(([before]) => before.includes(text))?.[1];

        return [valueAfter("preview malformed"), valueAfter("?disabled=")];
    };

    part.session = { isConnected: true, tables: tables(), traffic: { decoder: new Decoder(tables(), () => 253) } };
    attributeOf(part.render(), "@change")({ target: { value: "WRITE" } });
    assert.equal(part.form.address, 0x19); // LED: no other register is as harmless
    assert.deepEqual(shown({ instruction: "PING" }), [undefined, false]);
    assert.deepEqual(shown({ instruction: "hex" }), ["", true]);
    assert.deepEqual(shown({ instruction: "WRITE" }), ["Write the values.", true]);
    part.form = { ...part.form, instruction: "READ", ids: "1" };
    valuesOf(part.render()).findLast(([before]) => before.endsWith("@input="))[1]({ target: { value: "1.5" } });
    assert.equal(part.form.count, 1);
    for (const form of [{ instruction: "hex", hex: "01" }, { instruction: "WRITE", values: "150," }, { instruction: "WRITE", ids: "x" }]) {
        const [error, isOff] = shown(form);

        assert.ok(error && isOff, JSON.stringify(form));
    }
});

test("chart: a recording of two minutes and 18 servos is drawn, with few marks", () => {
    const ids = Array.from({ length: 18 }, (_, index) => index);
    const samples = Array.from({ length: 12000 }, (_, index) => ({ t: index * 10, raw: ids.map((id) => 500 + ((index * id) % 7)) }));
    const shown = chart({ path: pathOfPoints(ids, samples), width: 800, label: "", other: samples, points: samples });
    const values = valuesOf(shown);

    assert.ok(values.length < 2000, `${values.length} values`);
    assert.ok(values.every(([, value]) => typeof value !== "string" || value.length < 20000));
    assert.equal(valuesOf(chart({ path: pathOfPoints(ids, samples), width: 800, label: "", points: samples.slice(0, 10) })).filter(([before]) => before.endsWith(" cy=")).length, 180);
});

test("lines: those of 32 servos differ in colour or dashes", () => {
    const looks = Array.from({ length: 32 }, (_, index) => `${colourOf(index)} ${dashesOf(index)}`);

    assert.equal(new Set(looks).size, 32);
    assert.deepEqual(dashesOf(7), [], "few servos have whole lines");
});
