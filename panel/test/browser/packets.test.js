// SPDX-License-Identifier: MIT
/* The views Packets and Board in the browser, at the firmware in the simulator. */

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { parseCapture } from "../../src/port/replay.js";
import { PHONE, openPage, shows, startBrowser, startPanel, startRobot } from "../support/browser.js";

async function openTab(page, name) {
    await page.click(`#tab-${name}`);
    await page.waitForSelector(`panel-${name}`);
}

/* Puts text into a field in place of what stands there. */
async function fill(page, selector, text) {
    await page.focus(selector);
    await page.$eval(selector, (field) => field.select());
    if (text) await page.keyboard.type(text);
    else await page.keyboard.press("Backspace");
}

async function command(page, line) {
    await fill(page, ".console-line", line);
    await page.keyboard.press("Enter");
}

/* Waits until the element has the value. */
const holds = (page, selector, value) =>
    page.waitForFunction((css, wanted) => document.querySelector(css)?.value === wanted, {}, selector, value);

test("packets: sent by hand, shown decoded, and answered", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await page.select(".send-instruction", "WRITE");
    await fill(page, ".send-ids", "2");
    await page.select(".send-register", String(0x1e));
    await fill(page, ".send-values", "100, 20");
    await shows(page, "FF FF 02 07 03 1E 55 01 4A 01 34", ".preview");
    await page.click(".send-button");
    await shows(page, "Reply of 2: ok", ".outcome");
    await shows(page, /2\s+WRITE GOAL_POSITION 100\.0°, MOVING_SPEED 20\.0 rpm/, ".traffic .out");
    await page.select(".send-instruction", "READ");
    await page.click(".send-button");
    await shows(page, "GOAL_POSITION 100.0°", ".outcome");
});

test("page: an exception in a render, or in a listener, is one notice with a remedy", async (t) => {
    const { page } = await startRobot(t, { expected: /is not a function/ });
    const codes = () => page.$eval("panel-app", ({ session }) => session.notices.map(({ code }) => code));

    // The page itself must throw: the browser reports no error of a function of the test.
    await page.$eval("panel-app", ({ session }) => (session.traffic.describe = null));
    await openTab(page, "packets");
    await shows(page, /The page failed: .*describe is not a function\.[^]*Reload it\./, ".notice");
    assert.deepEqual(await codes(), ["unexpected"]);
    await page.click('[data-code="unexpected"] button');
    await openTab(page, "robot");
    await page.$eval("panel-app", ({ session }) => {
        session.withdraw(["unexpected"]);
        session.stop = null;
    });
    await page.click("button.stop");
    await shows(page, /The page failed: .*stop is not a function/, ".notice");
});

test("packets: raw bytes get a checksum, malformed are refused", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await page.select(".send-instruction", "hex");
    await fill(page, ".send-hex", "01 02 01 FC");
    await shows(page, "The checksum is 0xFC, it must be 0xFB", ".preview.malformed");
    assert.ok(await page.$eval(".send-button", (button) => button.disabled));
    await fill(page, ".send-hex", "01 02 01");
    await page.click(".send-button");
    await shows(page, "Reply of 1: ok", ".outcome");
});

test("packets: a driving packet is refused while inhibited", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await page.click("button.stop");
    await shows(page, "Torque is off", ".stop-state");
    await page.select(".send-instruction", "WRITE");
    await page.select(".send-register", String(0x18));
    await fill(page, ".send-values", "1");
    await page.click(".send-button");
    await shows(page, "Driving is inhibited", ".outcome.error");
});

test("packets: RESET is sent only after the dialog", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await page.select(".send-instruction", "RESET");
    await page.click(".send-button");
    await page.waitForSelector("dialog .no");
    await page.click("dialog .no");
    await page.waitForFunction(() => !document.querySelector("dialog"));
    assert.equal(await page.$$eval(".traffic .out", (rows) => rows.filter((row) => row.innerText.includes("RESET")).length), 0);
    await page.click(".send-button");
    await page.waitForSelector("dialog .yes");
    await page.click("dialog .yes");
    await shows(page, "RESET", ".traffic .out");
});

test("packets: at 1366 pixels, a scroll bar among them, the filter has one line, and the two boxes below end at one height", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.setViewport({ width: 1366 - 15, height: 768 });
    await openTab(page, "packets");
    const middles = await page.$$eval("panel-traffic .controls > *", (items) =>
        items.map((item) => Math.round(item.getBoundingClientRect().top + item.offsetHeight / 2)));
    const ends = await page.$$eval(".packets-below section", (boxes) => boxes.map((box) => Math.round(box.getBoundingClientRect().bottom)));

    assert.equal(middles.length, 7);
    assert.ok(Math.max(...middles) - Math.min(...middles) <= 2, `${middles}`);
    assert.equal(ends.length, 2);
    assert.equal(ends[0], ends[1]);
});

test("packets: a SAVE by hand is not sent, and names the view Board", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await openTab(page, "packets");
    await page.select(".send-instruction", "hex");
    await page.type(".send-hex", "FD 04 03 10 01");
    await page.click(".send-button");
    await shows(page, "Use the view Board", ".outcome");
    await page.type(".filter-text", "SAVE 1");
    await shows(page, "No packet or line fits", ".traffic");
});

test("packets: filter, pause and clear", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await command(page, "ping 2");
    await shows(page, "ping 2", ".traffic");
    await page.select(".filter-group", "SYNC READ");
    await shows(page, "No packet or line fits", ".traffic");
    await page.click(".withPolling");
    await shows(page, "PRESENT_POSITION to PRESENT_TEMPERATURE", ".traffic");
    await page.waitForFunction(() => document.querySelectorAll(".traffic .row").length === 200);
    await page.click(".showBytes");
    await shows(page, /FF FF (?:[0-9A-F]{2} ?)+/, ".traffic .bytes");
    await page.click(".pause");
    await shows(page, "Resume", ".pause");
    await page.click(".clear");
    await shows(page, "No packet or line fits", ".traffic");
    await page.click(".pause");
    await shows(page, "PRESENT_POSITION", ".traffic");
});

test("packets: the list follows again after a change of the view", async (t) => {
    const { page } = await startRobot(t);
    const isAtEnd = () =>
        page.waitForFunction(() => {
            const list = document.querySelector(".traffic");

            return list?.querySelector(".row") && list.scrollTop > 0 && list.scrollHeight - list.scrollTop - list.clientHeight <= 8;
        });

    await openTab(page, "packets");
    await page.click(".withPolling");
    await isAtEnd();
    await openTab(page, "robot");
    await openTab(page, "packets");
    await isAtEnd();
});

test("packets: the capture is saved and can be read", async (t) => {
    const { browser, page } = await startRobot(t);
    const folder = mkdtempSync(join(tmpdir(), "panel-"));
    const client = await browser.browser().target().createCDPSession();

    t.after(() => rmSync(folder, { recursive: true }));
    await client.send("Browser.setDownloadBehavior", { behavior: "allow", browserContextId: browser.id, downloadPath: folder, eventsEnabled: true });
    const done = new Promise((resolve) => client.on("Browser.downloadProgress", ({ state }) => state === "completed" && resolve()));

    await page.click("button.torque-on");
    await page.waitForFunction(() => document.querySelectorAll(".torque input:checked").length === 3);
    await openTab(page, "packets");
    await command(page, "ping 1"); // a second or more of feedback with torque
    await shows(page, /ping 1/, ".traffic");
    await page.click(".save");
    await done;
    const path = join(folder, readdirSync(folder)[0]);

    assert.ok(parseCapture(readFileSync(path, "utf8")).length > 5);
    await page.click("button.disconnect");
    await page.waitForSelector("dialog .yes");
    await page.click("dialog .yes");
    await shows(page, "Not connected", ".state-line");
    await (await page.$(".replay input")).uploadFile(path);
    await openTab(page, "robot");
    await shows(page, "A capture plays, no robot", ".state-line");
    await page.waitForFunction(() => document.querySelectorAll(".torque input:checked").length === 3);
    await page.click("button.disconnect"); // no robot: nothing to ask
    await shows(page, "Not connected", ".state-line");
});

test("console: a line and its reply, Up, and Tab", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await command(page, "get 1 GOAL_POSITION");
    await shows(page, /GOAL_POSITION = 150.*\nok/, ".console-output");
    await command(page, "ping 9");
    await shows(page, "error 2: servo 9", ".console-output");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("ArrowUp");
    await holds(page, ".console-line", "get 1 GOAL_POSITION");
    await fill(page, ".console-line", "torque 1 of");
    await page.keyboard.press("Tab");
    await holds(page, ".console-line", "torque 1 off ");
    await fill(page, ".console-line", "");
    await page.keyboard.press("Tab");
    await page.waitForFunction(() => document.activeElement?.className !== "console-line");
    await command(page, "mode person");
    await shows(page, "Use the view Board", ".console-output");
});

test("console: the line that is typed, and the newest echo, stay when the view or the connection changes", async (t) => {
    const { page } = await startRobot(t);
    const isAtEnd = () => page.waitForFunction(() => {
        const { scrollTop, scrollHeight, clientHeight } = document.querySelector(".console-output");

        return scrollHeight > 2 * clientHeight && scrollHeight - scrollTop - clientHeight < 8;
    });

    await openTab(page, "packets");
    await command(page, "help");
    await shows(page, /\nok\s*$/, ".console-output");
    await isAtEnd();
    await fill(page, ".console-line", "get 1 GOAL");
    await openTab(page, "board");
    await page.waitForSelector("panel-board");
    await openTab(page, "packets");
    await isAtEnd();
    await holds(page, ".console-line", "get 1 GOAL");
    await page.evaluate(() => (document.querySelector("panel-app").session.wire.hasConsole = false));
    await shows(page, "This firmware has no console", "panel-console");
    await page.evaluate(() => (document.querySelector("panel-app").session.wire.hasConsole = true));
    await holds(page, ".console-line", "get 1 GOAL");
    await page.focus(".console-line");
    await page.keyboard.press("Tab");
    await holds(page, ".console-line", "get 1 GOAL_POSITION ");
});

test("console: a command that goes on is ended", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await command(page, "monitor 1 as plot");
    await page.waitForSelector(".console-end");
    await shows(page, "Values are old", ".state-line");
    await page.click(".console-end");
    await shows(page, /\nok\s*$/, ".console-output");
    await page.waitForSelector(".console-run");
});

test("counters: with their meaning, and health in words", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "packets");
    await page.click(".read-counters");
    await shows(page, "The bus is well", ".health");
    await shows(page, "two servos have its ID", ".counters");
    await command(page, "ping 9");
    await shows(page, "error 2", ".console-output");
    await page.waitForSelector(".read-counters:not(:disabled)");
    await page.click(".read-counters");
    await shows(page, /No reply came to 1 transaction: .*Now all servos answer: press “Count from now”/, ".health");
    await page.click(".count-from-now");
    await shows(page, /Counted since \d\d:\d\d:\d\d/, "panel-counters");
    await shows(page, "The bus is well", ".health");
});

test("board: a setting is checked, applied, saved", async (t) => {
    const { panel, browser, page } = await startRobot(t);

    await openTab(page, "board");
    await page.waitForSelector("#setting-cycle_us");
    await fill(page, "#setting-cycle_us", "100");
    await shows(page, /2000 to 65535.*\sOut of range\./s, ".help");
    assert.ok(await page.$eval(".apply", (button) => button.disabled));
    await fill(page, "#setting-cycle_us", "5000");
    await page.click(".apply");
    await shows(page, "not saved", ".settings-state");
    await page.click(".save-settings");
    await shows(page, "As saved", ".settings-state");
    await page.click(".disconnect");
    await shows(page, "Not connected", ".state-line");
    await page.close();
    const again = await openPage(t, browser, `http://127.0.0.1:${panel.port}/?connect#board`);

    await again.waitForSelector("#setting-cycle_us");
    await holds(again, "#setting-cycle_us", "5000");
});

test("board: defaults only after the dialog", async (t) => {
    const { page } = await startRobot(t, { isFast: true });

    await openTab(page, "board");
    await page.waitForSelector("#setting-host_baud");
    await holds(page, "#setting-host_baud", "1");
    await page.click(".defaults");
    await page.waitForSelector("dialog .no");
    await page.click("dialog .no");
    await page.waitForFunction(() => !document.querySelector("dialog"));
    await holds(page, "#setting-host_baud", "1");
    await page.click(".defaults");
    await page.waitForSelector("dialog .yes");
    await page.click("dialog .yes");
    await holds(page, "#setting-host_baud", "255");
    await shows(page, "not saved", ".settings-state");
});

test("board: firmware, inhibit and release, alarm and its remedy", async (t) => {
    const { page } = await startRobot(t);

    await openTab(page, "board");
    await shows(page, /Profile\s+full/, ".firmware");
    await shows(page, "Driving is allowed", ".driving");
    await page.keyboard.press("Escape");
    await shows(page, "Driving is inhibited", ".driving");
    await page.click(".board-release");
    await shows(page, "Driving is allowed", ".driving");
    await openTab(page, "packets");
    await page.select(".send-instruction", "hex");
    await fill(page, ".send-hex", "01 05 03 06 FF FF"); // an angle limit out of range
    await page.click(".send-button");
    await shows(page, "out of range; not carried out", ".outcome.error");
    await openTab(page, "board");
    await shows(page, /Servo 1: range/, ".alarms");
    await page.click(".clear-alarms");
    await shows(page, "No alarm");
});

test("bridge: the page says what is missing, and offers the rest", async (t) => {
    const { page } = await startRobot(t, { board: "atmega128", elf: "build/atmega128/bridge.elf" });

    await shows(page, "profile bridge: it has no console", ".notice");
    await openTab(page, "packets");
    await shows(page, "This firmware has no console", "panel-console");
    await page.click(".send-button");
    await shows(page, "Reply of 1: ok", ".outcome");
    await openTab(page, "board");
    await shows(page, "For the rest flash the profile full", ".offers");
    await page.waitForSelector("#setting-cycle_us");
    await fill(page, "#setting-cycle_us", "5000");
    await page.click(".save-settings");
    await shows(page, "As saved", ".settings-state");
});

for (const width of [320, PHONE.width])
    test(`views fit a width of ${width} px`, async (t) => {
        const panel = await startPanel(t);
        const browser = await startBrowser(t);
        const page = await openPage(t, browser, panel.url, { viewport: { ...PHONE, width } });

        await shows(page, "3 servos", ".state-line");
        for (const name of ["graphs", "setup", "motion", "packets", "board", "robot"]) {
            await openTab(page, name);
            const widths = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);

            assert.ok(widths[0] <= width, `${name}: ${widths}`);
        }
    });
