// SPDX-License-Identifier: MIT
/* The page in Chromium, with the real firmware in the simulator behind scripts/panel.py. A test waits
 * for what the page shows, never for a time. */

import { spawn } from "node:child_process";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import puppeteer from "puppeteer-core";

export const ROOT = new URL("../../../", import.meta.url).pathname;
export const PATIENCE_MS = 120000; // only a page that hangs needs it, on a busy machine too
/* In a test time runs so many times slower for the page and for the simulator: a busy machine still keeps
 * the times that the page allows for a reply or a goal. */
const SLOW = 4;
/* How often a test looks whether the page shows what it waits for. Each look computes the layout: at each frame, the default
 * of puppeteer, looks take a seventh of the CPU time of a suite. */
const LOOK_MS = 50;
const FAILURE_ROWS = 300;
export const DESKTOP = { width: 1366, height: 768 };
export const PHONE = { width: 375, height: 812, deviceScaleFactor: 2, isMobile: true, hasTouch: true };

const endings = new WeakMap(); // of each test

/* Calls `end` at the end of the test, the newest first: the page ends before the browser, the browser
 * before the simulator. */
export function atEnd(t, end) {
    if (!endings.has(t)) {
        endings.set(t, []);
        t.after(async () => {
            for (const each of endings.get(t).reverse()) await each();
        });
    }
    endings.get(t).push(end);
}

function freePort() {
    return new Promise((resolve) => {
        const server = createServer().listen(0, "127.0.0.1", () => {
            const { port } = server.address();

            server.close(() => resolve(port));
        });
    });
}

/* A robot: simulator, WebSocket and page. `isFast`: at 1 Mbps, with the settings of `make
 * panel`; else at the rate of the board. `slow`: of simulator and page. `more`: options of the simulator. Ends with the test. */
export async function startPanel(
    t,
    { servos = "1-3", board = "arduino-mega", elf = `build/${board}/controller.elf`, port, isFast = false, slow = SLOW, more = [] } = {},
) {
    const folder = mkdtempSync(join(tmpdir(), "panel-"));
    const eeprom = join(folder, "eeprom");
    const ownPort = port ?? (await freePort());

    if (isFast) copyFileSync(join(ROOT, "build/panel.eeprom"), eeprom);
    const simulation = spawn(
        join(ROOT, "scripts/panel.py"),
        [elf, "--board", board, "--servos", servos, "--eeprom", eeprom, "--port", String(ownPort), "--", "--slow", String(slow), ...more],
        { cwd: ROOT, stdio: ["ignore", "pipe", "pipe"] },
    );
    const ended = new Promise((resolve) => simulation.on("close", resolve));
    const panel = { url: "", port: ownPort, folder, output: "", onOutput: () => {}, end: (signal = "SIGINT") => (simulation.kill(signal), ended) };

    atEnd(t, async () => {
        await panel.end();
        rmSync(folder, { recursive: true });
    });
    const take = (data) => {
        panel.output += data;
        panel.onOutput();
    };

    simulation.stderr.on("data", take);
    await new Promise((resolve, reject) => {
        simulation.stdout.on("data", (data) => {
            take(data);
            panel.url ||= /control panel: (\S+)/.exec(panel.output)?.[1] ?? "";
            if (panel.url) resolve();
        });
        ended.then(() => reject(new Error(`panel.py has ended:\n${panel.output}`)));
    });
    return panel;
}

/* Waits until the simulator or panel.py has printed `pattern`. */
export function prints(panel, pattern) {
    return new Promise((resolve) => {
        panel.onOutput = () => pattern.test(panel.output) && resolve();
        panel.onOutput();
    });
}

/* Chromium without windows: `time make test-panel T=setup` takes 63 s of CPU time, with chromium --headless 82 s.
 * --no-sandbox only for root, who has no other way. Without --disable-gpu it emulates a GPU: a tenth of the CPU time. */
export function launch() {
    return puppeteer.launch({
        executablePath: "/usr/bin/chromium-headless-shell",
        headless: "shell",
        args: ["--disable-gpu", ...(process.getuid() === 0 ? ["--no-sandbox"] : [])],
        protocolTimeout: PATIENCE_MS,
        networkEnabled: false, // else each message of the WebSocket is reported to Node: a tenth of the CPU time of a suite
    });
}

/* A Chromium that ends with the test. */
export async function startChromium(t) {
    const browser = await launch();

    atEnd(t, () => browser.close());
    return browser;
}

/* In the page, before its scripts run: its clock and its timers run `slow` times slower. */
function slowTime(slow) {
    const now = performance.now.bind(performance);
    const set = setTimeout;

    performance.now = () => now() / slow;
    globalThis.setTimeout = (call, ms, ...values) => set(call, ms * slow, ...values);
}

/* What a page showed when its test failed: the text on stderr, a picture in build/panel-failures. */
async function saveFailure(t, page) {
    const folder = join(ROOT, "build/panel-failures");
    const path = join(folder, `${t.name.replace(/\W+/g, "-")}.png`);

    mkdirSync(folder, { recursive: true });
    await page.screenshot({ path, fullPage: true });
    const [text, traffic] = await page.evaluate((count) => {
        const rows = document.querySelector("panel-app")?.session.traffic?.select({ withPolling: false }, count) ?? [];
        const lineOf = ({ time, direction, kind, bytes, line }) => `${time.toFixed(0)} ${direction} ${kind} ${line || bytes}`;

        return [document.body.innerText, rows.map(lineOf).join("\n")];
    }, FAILURE_ROWS);

    process.stderr.write(`${path}: the page showed:\n${text}\nThe last packets and lines, times of the page in ms:\n${traffic}\n`);
}

/* A page at `url`. Errors of the page fail the test at its end, except those that `expected` (a RegExp) matches. */
export async function openPage(t, browser, url, { viewport = DESKTOP, scheme = "light", slow = SLOW, expected = null } = {}) {
    const page = await browser.newPage();
    const errors = [];

    page.setDefaultTimeout(PATIENCE_MS);
    await page.evaluateOnNewDocument(slowTime, slow);
    await page.setViewport(viewport);
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    page.on("pageerror", (error) => errors.push(error.message));
    page.on("console", (message) => {
        if (message.type() === "error" && !message.text().includes("WebSocket")) errors.push(message.text());
    });
    atEnd(t, async () => {
        if (expected) errors.splice(0, errors.length, ...errors.filter((text) => !expected.test(text)));
        if (t.passed === false) await saveFailure(t, page);
        if (errors.length) throw new Error(`errors of the page:\n${errors.join("\n")}`);
    });
    await page.goto(url);
    const waitForFunction = page.waitForFunction.bind(page);

    page.waitForFunction = (condition, options, ...values) => waitForFunction(condition, { polling: LOOK_MS, ...options }, ...values);
    page.click = (selector, options) => page.locator(selector).click(options); // waits until the element stands still, and is enabled
    return page;
}

/* Waits until the page shows `text` (string or RegExp) in the element `selector`. */
export function shows(page, text, selector = "body") {
    return page.waitForFunction(
        (css, source, flags) => [...document.querySelectorAll(css)].some((element) => new RegExp(source, flags).test(element.innerText)),
        {},
        selector,
        text instanceof RegExp ? text.source : text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"),
        text instanceof RegExp ? text.flags : "",
    );
}
