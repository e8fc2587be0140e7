// SPDX-License-Identifier: MIT
/* The view Set-up: a new servo; backup, change, restore; files that are refused; questions before changes. */

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { PHONE, shows, startRobot } from "../support/browser.js";

/* A page with the view Set-up in front. */
async function startSetup(t, options) {
    const robot = await startRobot(t, options);

    await robot.page.click("#tab-setup");
    await robot.page.waitForSelector("panel-setup-find");
    return robot;
}

/* Clicks as soon as the element is enabled. */
async function press(page, selector) {
    await page.waitForSelector(`${selector}:enabled`);
    await page.click(selector);
}

/* Clicks a button that saves a file. Resolves with its path. */
async function saveBy(page, folder, selector) {
    const devtools = await page.createCDPSession();
    let name;
    const saved = new Promise((resolve) => {
        devtools.on("Browser.downloadWillBegin", (event) => (name = event.suggestedFilename));
        devtools.on("Browser.downloadProgress", ({ state }) => state === "completed" && resolve());
    });

    await devtools.send("Browser.setDownloadBehavior", { behavior: "allow", browserContextId: page.browserContext().id, downloadPath: folder, eventsEnabled: true });
    await press(page, selector);
    await saved;
    return join(folder, name);
}

async function open(page, path) {
    const input = await page.waitForSelector(".backup-file:enabled");

    await input.uploadFile(path);
}

/* Writes a register by its row of the table. */
async function edit(page, name, value) {
    const row = `[data-register="${name}"]`;

    await press(page, `${row} .edit`);
    await page.waitForFunction((css) => document.activeElement?.matches(css), {}, `${row} input`);
    await page.keyboard.down("Control");
    await page.keyboard.press("a");
    await page.keyboard.up("Control");
    await page.keyboard.type(value);
    await page.keyboard.press("Enter");
}

test("new servo: gets the ID that is typed, step by step", async (t) => {
    const { page } = await startSetup(t, { count: 1 });

    assert.equal(await page.$eval(".new-id", (input) => input.value), "2");
    await page.click(".new-id", { clickCount: 3 });
    await page.keyboard.type("7");
    await press(page, ".set-up-new");
    await shows(page, "Nothing was written", ".new-outcome"); // the page has found servo 1, so it is in the list
    await press(page, ".forget-and-set-up");
    await shows(page, "step 3 of 4: ID 1 becomes 7", ".steps");
    await shows(page, "Servo 7 is set up", ".new-outcome");
    await press(page, ".search");
    await shows(page, /^7\t1\t/m, ".found tbody");
    await press(page, "button.diagnose");
    await shows(page, "the servo answers well", ".finding");
    await shows(page, "Servo 7 answers at 1000000 bit/s", ".finding"); // what was measured
});

test("question: another connection, Esc at Stop and another tab answer no", async (t) => {
    const { page } = await startSetup(t, { count: 1 });
    const voids = {
        esc: () => page.focus(".stop").then(() => page.keyboard.press("Escape")),
        tab: () => page.click("#tab-board").then(() => page.click("#tab-setup")),
        disconnect: () => page.click(".disconnect"),
    };

    for (const call of Object.values(voids)) {
        await press(page, ".change-id");
        await page.waitForSelector("dialog[open]");
        await call();
        await page.waitForSelector("dialog", { hidden: true });
        await page.waitForFunction(() => !document.querySelector("main").inert);
    }
});

test("question: one at a time, none of a view that was left, and Esc closes it", async (t) => {
    const { page } = await startSetup(t, { count: 1 });
    const dialogs = () => page.$$eval("dialog", (all) => all.length);

    await page.click("#tab-motion");
    const desk = await page.waitForFunction(() => document.querySelector("panel-motion")?.desk);
    const both = await page.evaluateHandle((it) => ({ first: it.ask("first"), second: it.ask("second") }), desk);

    await shows(page, "second", "dialog");
    await page.waitForFunction(() => document.querySelectorAll("dialog").length === 1); // the event `close` comes later
    assert.equal(await page.evaluate(({ first }) => first, both), false);
    await page.keyboard.press("Escape");
    assert.equal(await page.evaluate(({ second }) => second, both), false);
    assert.equal(await dialogs(), 0);
    assert.equal(await page.$eval("main", (main) => main.inert), false);
    await page.click("#tab-setup");
    await page.click(".change-id");
    await shows(page, "gets another ID", "dialog");
    assert.equal(await page.evaluate((it) => it.ask("third"), desk), null);
    assert.equal(await dialogs(), 1);
    await page.keyboard.press("Escape");
    await page.waitForFunction(() => !document.querySelector("dialog"));
});

/* Switches torque of the first servo on, in the view Robot. */
async function torqueOn(page) {
    await page.click("#tab-robot");
    await press(page, ".torque input");
    await page.waitForFunction(() => document.querySelector(".torque input").checked);
    await page.click("#tab-setup");
}

test("rate of the bus: asked for while torque may be on", async (t) => {
    const { page } = await startSetup(t, { count: 1 });

    await torqueOn(page);
    await press(page, ".set-bus-rate");
    await shows(page, "no stop reaches them", "dialog");
    await page.click("dialog .no");
    await press(page, ".set-bus-rate");
    await page.click("dialog .yes");
    await shows(page, "The rate of the bus is changed.", ".place-outcome");
});

test("backup, change, restore", async (t) => {
    const { panel, page } = await startSetup(t, { count: 3 });
    const path = await saveBy(page, panel.folder, ".save-all");

    assert.deepEqual(JSON.parse(readFileSync(path, "utf8")).servos.map(({ id }) => id), [1, 2, 3]);
    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await edit(page, "MIN_VOLTAGE", "6.5");
    await shows(page, "6.5 V", '[data-register="MIN_VOLTAGE"] .value');
    await shows(page, "MIN_VOLTAGE is written and was read back", "panel-setup-registers");
    await press(page, ".read-all");
    await shows(page, "Read just now", "panel-setup-registers");
    await page.waitForSelector(".scope:enabled");
    await page.select(".scope", "all");
    await open(page, path);
    await shows(page, "1 register differs in 1 servo", ".plan");
    await shows(page, /1\s+MIN_VOLTAGE\s+6\.5 V \(65\)\s+6\.0 V \(60\)/, ".differences");
    await press(page, ".restore");
    await shows(page, "1 register is written and was read back", ".restored");
    await press(page, ".read-all");
    await shows(page, "6.0 V", '[data-register="MIN_VOLTAGE"] .value');
});

test("restore: a damaged file, a file of another servo", async (t) => {
    const { panel, page } = await startSetup(t, { count: 2 });
    const path = await saveBy(page, panel.folder, ".save-one");
    const bad = join(panel.folder, "bad.json");

    writeFileSync(bad, readFileSync(path, "utf8").slice(0, 200));
    await open(page, bad);
    await shows(page, /backup is damaged.*Nothing was written.*Choose another copy/s, ".notice");
    await page.select("select.servo", "2");
    await open(page, path);
    await shows(page, /backup is of servo 1, not of servo 2. Nothing was written/, ".notice");
    assert.equal(await page.$(".plan"), null);
});

test("registers: a limit asks only if both become 0, once", async (t) => {
    const { page } = await startSetup(t, { count: 1 });

    await torqueOn(page);
    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await edit(page, "CW_ANGLE_LIMIT", "60");
    await shows(page, "CW_ANGLE_LIMIT is written and was read back", "panel-setup-registers");
    assert.equal(await page.$("dialog"), null);
    await edit(page, "CW_ANGLE_LIMIT", "0");
    await shows(page, "0.0°", '[data-register="CW_ANGLE_LIMIT"] .value');
    await page.click("#tab-robot");
    await press(page, ".torque-off");
    await page.waitForFunction(() => !document.querySelector(".torque input").checked);
    await page.click("#tab-setup");
    await edit(page, "CCW_ANGLE_LIMIT", "0");
    await shows(page, "turns without end", "dialog");
    await page.click("dialog .yes");
    await shows(page, "CCW_ANGLE_LIMIT is written and was read back", "panel-setup-registers");
    assert.equal(await page.$("dialog"), null);
});

test("registers: a value out of range cannot be written", async (t) => {
    const { page } = await startSetup(t, { count: 1 });

    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await edit(page, "MIN_VOLTAGE", "26");
    await shows(page, "Out of range. 0 to 25.5 V; 0 to 255 raw", "#edit-note");
    assert.equal(await page.$eval(".edit-form .write", (button) => button.disabled), true);
});

test("other ID: asks first, and Stop stays at hand", async (t) => {
    const { page } = await startSetup(t, { count: 2 });

    await press(page, ".change-id");
    await shows(page, "Servo 1 gets another ID", "dialog");
    await page.click("button.stop");
    await shows(page, "Torque is off", ".stop-state");
    await page.waitForSelector("dialog .yes:enabled");
    await page.click("dialog .no");
    await page.waitForSelector("dialog", { hidden: true });
    await page.click("button.release");
    await press(page, ".change-id");
    await page.keyboard.type("9");
    await page.keyboard.press("Enter");
    await shows(page, "ID 9 at 1000000bps", ".place-outcome");
    await page.waitForFunction(() => document.querySelector("select.servo").value === "9"); // once the controller was asked
});

test("other ID: a full list is told before, and forgotten", async (t) => {
    const { page } = await startSetup(t, { count: 18 });

    await press(page, ".change-id");
    await shows(page, "The controller’s list is full", "dialog");
    await shows(page, "Esc cancels, and stops the robot", "dialog");
    await page.keyboard.type("50");
    await page.keyboard.press("Enter");
    await shows(page, "ID 50 at 1000000bps", ".place-outcome");
    await page.waitForFunction(() => document.querySelectorAll("select.servo option").length === 18); // all servos are found again
});

test("rate of the bus: the true one is shown, with the servos that do not have it, and set back", async (t) => {
    const { page } = await startSetup(t, { count: 2 });

    await shows(page, "The bus has 1000000 bit/s.", ".hint");
    await press(page, ".change-rate");
    await page.select("dialog select", "57600");
    await page.click("dialog .yes");
    await shows(page, "The bus has 57143 bit/s; 1 servo is not at this rate.", ".hint");
    assert.equal(await page.$eval("select.bus-rate", (list) => list.value), "57600");
    await page.reload();
    await shows(page, "The bus has 57143 bit/s", ".hint");
    await page.select("select.bus-rate", "1000000");
    await press(page, ".set-bus-rate");
    await shows(page, "Servos of another rate keep their torque", "dialog");
    await page.click("dialog .yes");
    await shows(page, "The bus has 1000000 bit/s", ".hint");
});

test("profile bridge: offers search, registers and backup", async (t) => {
    const { page } = await startSetup(t, { count: 2, board: "atmega128", elf: "build/atmega128/bridge.elf" });

    await press(page, ".search");
    await shows(page, "2 servos found", ".search-state");
    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await edit(page, "MIN_VOLTAGE", "6.5");
    await shows(page, "6.5 V", '[data-register="MIN_VOLTAGE"] .value');
    await shows(page, "The profile bridge of this firmware does not have this", "panel-setup-new");
    for (const missing of [".set-up-new", "button.diagnose", ".change-id", ".factory", ".set-bus-rate"]) assert.equal(await page.$(missing), null, missing);
    assert.equal((await page.$$(".how option")).length, 1);
    await page.waitForSelector(".save-all:enabled");
});

/* Holds up what follows a write, so that the test can type meanwhile. */
const holdWrites = (page) => page.$eval("panel-setup-registers", ({ setup }) => {
    const write = setup.write.bind(setup);

    setup.write = async (...all) => {
        const isWritten = await write(...all);

        await new Promise((resolve) => (globalThis.goOn = resolve));
        return isWritten;
    };
});
const goOn = async (page) => {
    await page.waitForFunction(() => globalThis.goOn);
    await page.evaluate(() => (globalThis.goOn(), (globalThis.goOn = null)));
};

test("registers: what is typed while a write is under way stays, in its form and in other fields", async (t) => {
    const { page } = await startSetup(t, { count: 1 });

    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await holdWrites(page);
    await edit(page, "MIN_VOLTAGE", "6.5");
    await page.keyboard.type("1");
    await goOn(page);
    await shows(page, "MIN_VOLTAGE is written and was read back", "panel-setup-registers");
    assert.equal(await page.$eval(".edit-form input", (input) => input.value), "6.51");
    await page.keyboard.press("Backspace");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => globalThis.goOn);
    await page.focus(".new-id");
    await goOn(page);
    await page.waitForFunction(() => !document.querySelector(".edit-form"));
    assert.ok(await page.$eval(".new-id", (input) => input === document.activeElement));
    await press(page, '[data-register="MAX_VOLTAGE"] .edit');
    await page.keyboard.type("5"); // behind the value
    await page.$eval("panel-setup-registers", ({ setup }) => setup.backup(1));
    await page.$eval("panel-setup-registers", ({ setup }) => setup.readAll(1));
    assert.match(await page.$eval(".edit-form input", (input) => input.value), /^16\.05$/);
});

test("phone: no horizontal scroll, with registers and a dialog", async (t) => {
    const { page } = await startSetup(t, { count: 1, viewport: PHONE });
    const width = () => page.evaluate(() => document.documentElement.scrollWidth);

    await press(page, ".read-all");
    await page.waitForSelector(".registers");
    await press(page, '[data-register="BAUD_RATE"] ~ tr .edit');
    await page.waitForSelector(".edit-form");
    assert.equal(await width(), PHONE.width);
    await press(page, ".factory");
    const box = await (await page.waitForSelector("dialog[open]")).boundingBox();

    assert.ok(box.x >= 0 && box.x + box.width <= PHONE.width, JSON.stringify(box));
});
