// SPDX-License-Identifier: MIT
/* Measures the page with 1, 18 and 50 servos, and with 18 at the slower rate of a new board: updates a
 * second, and the CPU time of the page. Prints a table; with a file as argument writes it there, too.
 *
 * The simulator, the WebSocket and the browser share this machine: on a busy machine all figures are
 * worse. `make panel-figures` */

import { writeFileSync } from "node:fs";
import { Ending } from "./support/ending.js";
import { openPage, shows, startChromium, startPanel } from "./support/page.js";

const CASES = [
    { count: 1, rate: 1000000 },
    { count: 18, rate: 1000000 },
    { count: 50, rate: 1000000 },
    { count: 18, rate: 115200 }, // of the board, while no other one is saved
];
const VIEWS = ["robot", "graphs"];
const WARM_UP_MS = 3000;
const MEASURE_MS = 10000;
const COLUMNS = ["servos", "bit/s", "view", "updates a second", "drawn frames a second", "CPU of the main thread %", "CPU of the page's process %", "heap MB"];

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/* Counters of the page: updates, frames, seconds of CPU. */
async function countersOf(page, browserSession) {
    const { metrics } = await page.client.send("Performance.getMetrics");
    const { processInfo } = await browserSession.send("SystemInfo.getProcessInfo");
    const metric = (name) => metrics.find((row) => row.name === name).value;
    const renderers = processInfo.filter(({ type }) => type === "renderer").map(({ cpuTime }) => cpuTime);

    return {
        ...(await page.evaluate(() => globalThis.figures)),
        time: metric("Timestamp"),
        busy: metric("TaskDuration"),
        cpu: renderers.reduce((sum, time) => sum + time, 0),
        heap: metric("JSHeapUsedSize"),
    };
}

async function measure(page, browserSession, view) {
    await page.click(`#tab-${view}`);
    await pause(WARM_UP_MS);
    const begin = await countersOf(page, browserSession);

    await pause(MEASURE_MS);
    const end = await countersOf(page, browserSession);
    const perSecond = (name) => (end[name] - begin[name]) / (end.time - begin.time);

    return [perSecond("updates"), perSecond("frames"), 100 * perSecond("busy"), 100 * perSecond("cpu"), end.heap / 1e6];
}

async function measureAll({ count, rate }) {
    const ending = new Ending();
    const rows = [];

    try {
        const panel = await startPanel(ending, { servos: `1-${count}`, isFast: rate === 1000000, slow: 1 });
        const browser = await startChromium(ending);
        const browserSession = await browser.target().createCDPSession();
        const page = await openPage(ending, browser, panel.url, { slow: 1 });

        page.client = await page.createCDPSession();
        await page.client.send("Performance.enable");
        await shows(page, new RegExp(`${count} servos?\\b.*updates`), ".state-line");
        await page.evaluate(() => {
            const figures = (globalThis.figures = { updates: 0, frames: 0 });
            const frame = () => (figures.frames++, requestAnimationFrame(frame));

            document.querySelector("panel-app").session.addEventListener("feedback", () => figures.updates++);
            frame();
        });
        for (const view of VIEWS) rows.push([count, rate, view, ...(await measure(page, browserSession, view)).map((value) => value.toFixed(0))]);
    } finally {
        await ending.end();
    }
    return rows;
}

const STOPS = 20;
const TORQUE_OFF = "->in: FF FF FE 04 03 18 00";

const median = (values) => values.sort((one, other) => one - other)[values.length >> 1].toFixed(1);

/* Wall time in ms from the command that presses Esc to torque off on the wire, as the simulator reports it,
 * and to "Torque is off" on the page: medians. */
async function measureStops() {
    const ending = new Ending();
    const [toWire, toPage] = [[], []];

    try {
        const panel = await startPanel(ending, { servos: "1-18", isFast: true, slow: 1, more: ["--echo"] });
        const page = await openPage(ending, await startChromium(ending), panel.url, { slow: 1 });

        await shows(page, "18 servos", ".state-line");
        for (let count = 0; count < STOPS; count++) {
            panel.output = "";
            const begun = performance.now();
            const isOnWire = new Promise((resolve) => {
                panel.onOutput = () => panel.output.includes(TORQUE_OFF) && resolve(performance.now() - begun);
            });

            await page.keyboard.press("Escape");
            toWire.push(await isOnWire);
            await shows(page, "Torque is off", ".stop-state");
            toPage.push(performance.now() - begun);
            await page.click("button.release");
            await page.waitForFunction(() => !document.querySelector("button.release"));
        }
    } finally {
        await ending.end();
    }
    return [median(toWire), median(toPage)];
}

const rows = [COLUMNS];

for (const one of CASES) rows.push(...(await measureAll(one)));
console.log(rows.map((row) => row.map((cell, index) => String(cell).padEnd(COLUMNS[index].length)).join("  ")).join("\n"));
const [toWire, toPage] = await measureStops();

console.log(`Esc to torque off on the wire: ${toWire} ms; to “Torque is off” on the page: ${toPage} ms (medians of ${STOPS})`);
if (process.argv[2]) writeFileSync(process.argv[2], rows.map((row) => row.join("\t")).join("\n") + "\n");
