// SPDX-License-Identifier: MIT
/* Takes pictures of each view, light and dark, at a desktop's size and at a phone's, with 18 servos of which
 * three have learnt two poses. `make panel-pictures` writes them to build/panel-pictures; two of them stand
 * in README.md and docs/panel.md. */

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { Ending } from "./support/ending.js";
import { DESKTOP, PHONE, openPage, shows, startChromium, startPanel } from "./support/page.js";

const VIEWS = ["robot", "graphs", "setup", "motion", "packets", "board"];
const SIZES = { desktop: DESKTOP, phone: PHONE };
const POSES = ["group 1 2 3", "pose save up", "pose 100 200 130 in 0.5s", "motion wait", "pose save down",
    "sequence wave new up 1.2s", "sequence wave add down 0.8s dwell 0.3s"];

const GRAPH_MS = 3000; // of a graph
const [folder] = process.argv.slice(2);
const ending = new Ending();

async function readRegisters(page) {
    await page.waitForSelector(".read-all:enabled");
    await page.click(".read-all");
    await page.waitForSelector(".registers");
}

/* Waits until the view shows what it is about. */
const READY = {
    robot: (page) => page.waitForSelector("[data-id='18'] .dial"),
    graphs: (page) => page.waitForSelector(".uplot canvas"),
    setup: readRegisters,
    motion: (page) => page.waitForSelector(".board"),
    packets: (page) => page.waitForSelector(".traffic .row"),
    board: (page) => page.waitForSelector("#setting-cycle_us"),
};

const run = (page, line) => page.evaluate((text) => document.querySelector("panel-app").session.controller.run(text), line);

/* Torque on for all servos, and a sequence that the page has loaded and the board plays. */
async function begin(page) {
    await page.click("button.torque-on");
    await page.waitForFunction(() => document.querySelectorAll(".torque input:checked").length === 18);
    for (const line of POSES) await run(page, line);
    await loadMotions(page);
    await run(page, "play wave loop");
}

/* The view loads what the board has. */
async function loadMotions(page) {
    await page.click("#tab-motion");
    await page.waitForSelector(".step");
}

async function takePicture(page, view, name) {
    await page.evaluate((id) => (location.hash = id), view);
    await READY[view](page);
    await page.evaluate((ms) => new Promise((resolve) => setTimeout(resolve, ms)), GRAPH_MS);
    await page.screenshot({ path: join(folder, name) });
}

/* A page of its own for each size: a change to a phone loads the page again. */
async function takePictures(browser, url, size) {
    const page = await openPage(ending, browser, url, { viewport: SIZES[size], slow: 1 });

    await shows(page, "18 servos", ".state-line");
    if (size === "desktop") await begin(page);
    for (const view of VIEWS)
        for (const scheme of ["light", "dark"]) {
            await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
            await takePicture(page, view, `${view}-${size}-${scheme}.png`);
        }
    await page.close();
}

try {
    mkdirSync(folder, { recursive: true });
    const { url } = await startPanel(ending, { servos: "1-18", isFast: true, slow: 1 });
    const browser = await startChromium(ending);

    for (const size of Object.keys(SIZES)) await takePictures(browser, url, size);
} finally {
    await ending.end();
}
