// SPDX-License-Identifier: MIT
/* The view Robot: torque, drag, jog and Stop move and stop simulated servos. */

import assert from "node:assert/strict";
import test from "node:test";
import { PHONE, shows, startRobot, startRobotWithHand } from "../support/browser.js";

const card = (id) => `[data-id="${id}"]`;

/* Switches torque on, and waits until the servo has confirmed it. On a busy machine the simulator may answer
 * too late: the page then asks the user to try again. */
async function torqueOn(page, id) {
    const box = `${card(id)} .torque input`;
    const tooLate = '.notice:is([data-code="servo-silent"], [data-code="late"]) button';

    for (;;) {
        await page.click(box);
        await page.waitForSelector(`${box}:checked, ${tooLate}`);
        if (await page.$(`${box}:checked`)) return;
        await page.click(tooLate);
    }
}

/* Point of the screen at which the dial of a servo has `degrees`. */
function pointOf(page, id, degrees) {
    return page.$eval(
        `${card(id)} .dial`,
        (dial, angle) => {
            const ring = dial.querySelector(".grip");
            const point = ring.getPointAtLength((ring.getTotalLength() * angle) / 300).matrixTransform(dial.getScreenCTM());

            return { x: point.x, y: point.y };
        },
        degrees,
    );
}

async function drag(page, id, from, to) {
    const [begin, end] = [await pointOf(page, id, from), await pointOf(page, id, to)];

    await page.mouse.move(begin.x, begin.y);
    await page.mouse.down();
    await page.mouse.move(end.x, end.y, { steps: 10 });
    await page.mouse.up();
}

const focusDial = (page, id) => page.$eval(`${card(id)} .dial`, (dial) => dial.focus());
const positionOf = (page, id) => page.$eval(`${card(id)} .position`, (text) => parseFloat(text.textContent));
const goalOf = (page, id) => page.$eval(`${card(id)} .dial`, (dial) => Number(dial.getAttribute("aria-valuenow")));

/* Waits until the position is `test`, a function of two numbers, together with `limit`. */
const waitForPosition = (page, id, compare, limit) =>
    page.waitForFunction(
        (css, name, bound) => {
            const position = parseFloat(document.querySelector(css).textContent);

            return { above: position > bound, below: position < bound, near: Math.abs(position - bound) < 1.5 }[name];
        },
        {},
        `${card(id)} .position`,
        compare,
        limit,
    );

/* Waits until the servo stands: its present speed reads 0. */
const waitForStand = (page, id) => shows(page, /Speed\s+0\.0/, `${card(id)} dl`);

test("drag: the goal is sent, and the servo arrives", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await torqueOn(page, 1);
    await drag(page, 1, 150, 120);
    await waitForPosition(page, 1, "near", 120);
    assert.ok(Math.abs((await goalOf(page, 1)) - 120) < 1.5);
    assert.equal(await page.$(`${card(1)} .note`), null);
});

test("drag: ignored while torque is off, and the card says so", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await drag(page, 1, 150, 60);
    await shows(page, "Ignored: torque is off", `${card(1)} .note`);
    await torqueOn(page, 1);
    assert.equal((await goalOf(page, 1)).toFixed(1), "150.1");
    assert.equal((await positionOf(page, 1)).toFixed(1), "150.1");
    assert.equal(await page.$(`${card(1)} .note`), null);
});

test("keys: a jog moves while the key is held", async (t) => {
    const { page } = await startRobot(t, { count: 2 });

    await torqueOn(page, 2);
    await page.keyboard.press("2"); // chooses the servo
    assert.equal(await page.evaluate(() => document.activeElement.closest("[data-id]").dataset.id), "2");
    await page.keyboard.down("ArrowLeft");
    await waitForPosition(page, 2, "above", 165);
    await page.keyboard.up("ArrowLeft");
    await waitForStand(page, 2);
    const position = await positionOf(page, 2);

    assert.ok(position < 290, "it has not run to its end");
    assert.ok(Math.abs((await goalOf(page, 2)) - position) < 3, `goal ${await goalOf(page, 2)}, position ${position}`);
    assert.equal((await positionOf(page, 1)).toFixed(1), "150.1");
});

test("keys: a jog ends when the dial loses the focus", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await torqueOn(page, 1);
    await focusDial(page, 1);
    await page.keyboard.down("ArrowRight");
    await waitForPosition(page, 1, "below", 140);
    await page.focus("button.find");
    await waitForStand(page, 1);
    assert.ok((await positionOf(page, 1)) > 20, "it has not run to its end");
});

test("keys: Up and Down step the goal, Home goes to the limit", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await torqueOn(page, 1);
    await focusDial(page, 1);
    await page.keyboard.press("PageUp");
    await waitForPosition(page, 1, "near", 160);
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("ArrowDown");
    await waitForPosition(page, 1, "near", 158);
    await page.keyboard.press("Home");
    await waitForPosition(page, 1, "below", 150);
});

test("Stop: Esc that closes the list of a select stops, too", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.focus("select");
    await page.keyboard.down("Alt");
    await page.keyboard.press("ArrowDown");
    await page.keyboard.up("Alt");
    await page.keyboard.press("Escape");
    await shows(page, "Torque is off", ".stop-state.verified");
});

test("Stop: Esc in mid-motion, torque is off and the servo stands", async (t) => {
    const { page } = await startRobot(t, { count: 3 });

    await page.click("button.torque-on");
    await page.waitForFunction(() => document.querySelectorAll(".torque input:checked").length === 3);
    assert.equal(await page.$eval(".stop-state", (text) => text.textContent), "");
    await focusDial(page, 1);
    await page.keyboard.press("Home"); // 150 degrees at 20 rpm: 1.25 s
    await waitForPosition(page, 1, "below", 145);
    await page.keyboard.press("Escape");
    await shows(page, "Torque is off", ".stop-state.verified");
    await page.waitForFunction(() => !document.querySelector(".torque input:checked"));
    await waitForStand(page, 1);
    assert.ok((await positionOf(page, 1)) > 1, "the servo was stopped on its way");

    await drag(page, 1, 100, 50);
    await shows(page, "Ignored: torque is off", `${card(1)} .note`);
    await page.click(`${card(1)} .torque input`);
    await shows(page, "driving is inhibited", ".notice");
    await page.click("button.release");
    await page.waitForFunction(() => !document.querySelector("button.release"));
    await torqueOn(page, 1);
});

test("keyboard: Release gives the focus to the tab, a disabled button gets it back, and the tabs stay in sight", async (t) => {
    const { page } = await startRobot(t, { count: 1, viewport: { width: 640, height: 384 } });

    await page.keyboard.press("Escape");
    await page.waitForSelector("button.release");
    await page.focus("button.release");
    await page.keyboard.press("Enter");
    await page.waitForSelector("#tab-robot:focus");
    await page.focus("button.find");
    await page.keyboard.press("Enter");
    await shows(page, "1 servo found", ".toolbar");
    await page.waitForSelector("button.find:enabled:focus");
    await page.evaluate(() => scrollTo(0, 1e6));
    assert.ok(await page.$eval("#tab-robot", (tab) => scrollY > 0 && tab.getBoundingClientRect().top >= 0));
});

const placeOf = (page, css) =>
    page.$eval(css, (element) => {
        const { left, top, right, bottom } = element.getBoundingClientRect();

        return { left, top, right, bottom };
    });

const pageWidth = (page) => page.evaluate(() => document.documentElement.scrollWidth);

test("Stop: keeps its place, and Release comes beside it, at each width", async (t) => {
    const { page } = await startRobot(t, { count: 2 });

    for (const width of [1280, 1000, 640, 375, 240]) {
        await page.setViewport({ width, height: 700 });
        const [before, stop] = [await pageWidth(page), await placeOf(page, "button.stop")];

        await page.mouse.click((stop.left + stop.right) / 2, (stop.top + stop.bottom) / 2, { count: 2 });
        await page.waitForSelector("button.release");
        const release = await placeOf(page, "button.release");
        const isApart = release.right <= stop.left || release.top >= stop.bottom;

        assert.deepEqual(await placeOf(page, "button.stop"), stop, `${width} px: Stop moves`);
        assert.ok(isApart, `${width} px: Release ${JSON.stringify(release)} over Stop ${JSON.stringify(stop)}`);
        assert.ok(release.left >= 0 && release.right <= width, `${width} px: Release from ${release.left} to ${release.right}`);
        assert.equal(await pageWidth(page), before, `${width} px: scrolls sideways`);
        await page.click("button.release");
        await page.waitForFunction(() => !document.querySelector("button.release"));
    }
});

/* Top and height of each card. */
const placesOf = (page) =>
    page.$$eval(".card", (cards) => cards.map((one) => [one.getBoundingClientRect().top, one.offsetHeight]));

/* In the page: what a screen reader tells of each text of a card: "polite" or "off". */
const liveOf = (page) => page.$$eval(".note", (notes) => notes.map((note) => `${note.closest("[aria-live]").ariaLive} ${note.innerText}`));

test("cards: texts of a stop and of an ignored drag do not move them, and a stop is told once", async (t) => {
    const { page } = await startRobot(t, { count: 3 });
    const places = await placesOf(page);

    await shows(page, "Home and End", "#robot-keys");
    await page.keyboard.press("Escape");
    await page.waitForFunction((css) => document.querySelectorAll(css).length === 3, {}, ".card .note");
    assert.deepEqual(await liveOf(page), ["off Inhibited", "off Inhibited", "off Inhibited"]);
    assert.deepEqual(await page.$$eval(".advice p", (lines) => lines.map((line) => line.innerText)),
        ["Driving is inhibited by a stop. Press Release to allow it."]);
    assert.deepEqual(await placesOf(page), places);
    await page.click("button.release");
    await page.waitForFunction(() => !document.querySelector(".note"));
    await drag(page, 2, 150, 60);
    await shows(page, "Ignored: torque is off", `${card(2)} .note`);
    assert.deepEqual(await placesOf(page), places);
});

test("cards: while inhibited by a stop, a screen reader still tells that a drag is ignored", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.keyboard.press("Escape");
    await shows(page, "Inhibited", ".card .note");
    await drag(page, 1, 150, 60);
    await shows(page, "Ignored", ".card .note");
    assert.deepEqual(await liveOf(page), ["off Inhibited", "polite Ignored: torque is off"]);
    assert.deepEqual(await page.$$eval(".advice p", (lines) => lines.map((line) => line.innerText)),
        ["Driving is inhibited by a stop. Press Release to allow it.", "Servo 1: torque is off. Switch torque on first."]);
});

test("cards: with five alarms they grow, so each text and button stays in sight", async (t) => {
    const { page } = await startRobot(t, { count: 4 });

    await page.evaluate(() => {
        const { session } = document.querySelector("panel-app");
        const alarms = ["input voltage", "angle limit", "overheating", "range", "overload"];

        for (const servo of session.robot.servos.values())
            Object.defineProperties(servo, { alarms: { get: () => alarms, set: () => {} }, inhibit: { get: () => "lost", set: () => {} } });
    });
    await page.waitForFunction(() => document.querySelectorAll(".note").length === 24 && document.querySelectorAll(".advice p").length === 6);
    assert.ok(await page.$$eval(".notes button, .note", (buttons) => buttons.every((button) => {
        const card = button.closest(".card").getBoundingClientRect();
        const { top, bottom, right } = button.getBoundingClientRect();

        return top >= card.top && bottom <= card.bottom && right <= card.right;
    })));
    const hidden = await page.$eval(".hints", (advice) => [getComputedStyle(advice).overflowY, advice.scrollHeight > advice.clientHeight]);

    assert.deepEqual(hidden, ["auto", true]);
});

test("cards: a servo that does not answer is named once, with what to do", async (t) => {
    const { page, hand } = await startRobotWithHand(t, { count: 2 });

    hand("power 2 off");
    await shows(page, "Does not answer", `${card(2)} .note`);
    await shows(page, "Servo 2", ".advice");
    assert.deepEqual(await page.$$eval(".advice p", (lines) => lines.map((line) => line.innerText)), ["Servo 2: no answer. Check power, wiring and ID."]);
});

/* What the box above the cards advises. */
const advice = (page) => page.$$eval(".advice p", (lines) => lines.map((line) => line.innerText));

test("power cut: no servo answers, then one Release releases all, and the view Board tells how many", async (t) => {
    const { page, hand } = await startRobotWithHand(t);

    await page.click("button.torque-on");
    await page.waitForFunction(() => document.querySelectorAll(".torque input:checked").length === 3);
    hand("power off");
    await shows(page, "No servo answers", ".advice");
    assert.deepEqual(await advice(page), ["No servo answers. Check their power, and whether the line is held low or disturbed. Diagnosis"]);
    hand("power on");
    await shows(page, "3 servos are inhibited", ".stop-state");
    await shows(page, "then press Release.", ".advice");
    await page.click("#tab-board");
    await shows(page, "Driving is allowed, but 3 servos are inhibited.", ".driving");
    await page.waitForSelector("button.board-release:enabled");
    await page.click("button.release");
    await shows(page, "Driving is allowed.", ".driving");
    await page.waitForFunction(() => !document.querySelector("button.release"));
    await page.click("#tab-robot");
    await torqueOn(page, 1);
});

test("line held low: told with the way to the diagnosis, never that the controller is silent; confirmed once it is free", async (t) => {
    const { page, hand } = await startRobotWithHand(t, { count: 18 });

    hand("fault stuck low");
    await shows(page, "The line is held low", ".advice");
    assert.equal((await advice(page)).length, 1);
    await page.evaluate(() => {
        globalThis.told = "";
        document.querySelector("panel-app").session.addEventListener("change", () => (globalThis.told += document.querySelector(".state-line").innerText));
    });
    await page.keyboard.press("Escape");
    await shows(page, "Driving is inhibited. No answer, so torque is not known", ".notice");
    await page.click(".advice a");
    await page.click("button.diagnose");
    await shows(page, "the signal wire stays at 0 V", ".finding");
    hand("fault stuck off");
    await shows(page, "Torque is off, driving is inhibited", ".stop-state.verified");
    assert.equal(await page.$(".notice"), null);
    assert.ok(!(await page.evaluate(() => globalThis.told)).includes("does not answer"));
});

test("disconnect: asks while a servo has torque", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await torqueOn(page, 1);
    await page.click("button.disconnect");
    await shows(page, "Torque is on, or not known.", "dialog");
    await page.click("dialog .no");
    await shows(page, "Connected", ".state-line");
    await page.click("button.disconnect");
    await page.click("dialog .yes");
    await shows(page, "Not connected", ".state-line");
});

test("Stop: Space stops at a dial; a switch takes it for itself", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.waitForSelector(`${card(1)} .torque input:enabled`); // its state was read
    await page.focus(`${card(1)} .torque input`);
    await page.keyboard.press("Space");
    await page.waitForSelector(`${card(1)} .torque input:checked`);
    assert.equal(await page.$eval(".stop-state", (text) => text.textContent), "");
    await focusDial(page, 1);
    await page.keyboard.press("Space");
    await shows(page, "Torque is off", ".stop-state.verified");
    await page.waitForSelector(`${card(1)} .torque input:not(:checked)`);
});

test("endless turn: the slider turns the servo while it is held", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.evaluate(() => document.querySelector("panel-app").session.controller.run("turn 1 0"));
    await page.waitForSelector(`${card(1)} .turn input`);
    await torqueOn(page, 1);
    const box = await (await page.$(`${card(1)} .turn input`)).boundingBox();
    const y = box.y + box.height / 2;

    await page.mouse.move(box.x + box.width / 2, y);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.2, y, { steps: 5 });
    await shows(page, /Speed\s+[1-9]\d/, `${card(1)} dl`);
    await shows(page, /^→ [1-9]\d rpm$/, `${card(1)} output.goal`);
    assert.equal(await page.$eval("#robot-keys", (hint) => hint.hidden), true); // there is no dial
    await page.mouse.up();
    await waitForStand(page, 1);
    assert.equal(await page.$eval(`${card(1)} .turn input`, (slider) => slider.value), "0");
    await page.focus(`${card(1)} .turn input`);
    await page.keyboard.down("PageUp");
    await shows(page, /Speed\s+-\d/, `${card(1)} dl`);
    await page.keyboard.up("PageUp");
    await waitForStand(page, 1);
});

test("touch: buttons step the goal, and an unplugged servo is told in the header", async (t) => {
    const { page, hand } = await startRobotWithHand(t, { count: 2, viewport: PHONE });

    await torqueOn(page, 1);
    await page.click(`${card(1)} .touch button`);
    await page.waitForFunction((css) => /→ 160/.test(document.querySelector(css).textContent), {}, `${card(1)} text.goal`);
    await page.click("button.find");
    await shows(page, "2 servos found", ".toolbar");
    hand("power 2 off");
    await shows(page, "2 servos, 1 offline", ".state-line");
    assert.ok(!(await page.$eval(".toolbar", (bar) => bar.innerText)).includes("found"));
});

test("robot: in a narrow window the hint about the keys is whole", async (t) => {
    const { page } = await startRobot(t, { count: 1, viewport: { width: 390, height: 844 } });

    assert.ok(await page.$eval(".hints", ({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight), "cut");
});
