// SPDX-License-Identifier: MIT
/* The page in Chromium, with the real firmware in the simulator behind scripts/panel.py. A test waits
 * for what the page shows, never for a time. */

import { spawn } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import puppeteer from "puppeteer-core";

const ROOT = new URL("../../../", import.meta.url).pathname;
export const PATIENCE_MS = 120000; // only a page that hangs needs it, on a busy machine too
const DESKTOP = { width: 1366, height: 768 };
export const PHONE = { width: 375, height: 812, deviceScaleFactor: 2, isMobile: true, hasTouch: true };

function freePort() {
    return new Promise((resolve) => {
        const server = createServer().listen(0, "127.0.0.1", () => {
            const { port } = server.address();

            server.close(() => resolve(port));
        });
    });
}

/* A robot: simulator, WebSocket and page. `isNew`: without saved settings, so at the rate of the board.
 * `more`: options of the simulator. Ends with the test. */
export async function startPanel(
    t,
    { servos = "1-3", board = "arduino-mega", elf = `build/${board}/controller.elf`, port, isNew = false, more = [] } = {},
) {
    const folder = mkdtempSync(join(tmpdir(), "panel-"));
    const eeprom = join(folder, "eeprom");
    const ownPort = port ?? (await freePort());

    if (!isNew && board !== "arbotix") copyFileSync(join(ROOT, "build/panel.eeprom"), eeprom); // its chip has a smaller EEPROM
    const process = spawn(
        join(ROOT, "scripts/panel.py"),
        [elf, "--board", board, "--servos", servos, "--eeprom", eeprom, "--port", String(ownPort), ...(more.length ? ["--", ...more] : [])],
        { cwd: ROOT, stdio: ["ignore", "pipe", "pipe"] },
    );
    const ended = new Promise((resolve) => process.on("close", resolve));
    const panel = { url: "", port: ownPort, folder, output: "", end: () => (process.kill("SIGINT"), ended) };

    t.after(async () => {
        await panel.end();
        rmSync(folder, { recursive: true });
    });
    process.stderr.on("data", (data) => (panel.output += data));
    await new Promise((resolve, reject) => {
        process.stdout.on("data", (data) => {
            panel.output += data;
            panel.url ||= /control panel: (\S+)/.exec(panel.output)?.[1] ?? "";
            if (panel.url) resolve();
        });
        ended.then(() => reject(new Error(`panel.py has ended:\n${panel.output}`)));
    });
    return panel;
}

/* Chromium. --no-sandbox only for root, who has no other way. */
export async function startBrowser(t) {
    const browser = await puppeteer.launch({
        executablePath: "/usr/bin/chromium",
        args: process.getuid() === 0 ? ["--no-sandbox"] : [],
        protocolTimeout: PATIENCE_MS,
    });

    t.after(() => browser.close());
    return browser;
}

/* A page at `url`. Errors of the page fail the test at its end. */
export async function openPage(t, browser, url, { viewport = DESKTOP, scheme = "light" } = {}) {
    const page = await browser.newPage();
    const errors = [];

    page.setDefaultTimeout(PATIENCE_MS);
    await page.setViewport(viewport);
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    page.on("pageerror", (error) => errors.push(error.message));
    page.on("console", (message) => {
        if (message.type() === "error" && !message.text().includes("WebSocket")) errors.push(message.text());
    });
    t.after(() => {
        if (errors.length) throw new Error(`errors of the page:\n${errors.join("\n")}`);
    });
    await page.goto(url);
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

/* The page, the browser and the robot at once. The page is connected and has found `count` servos. */
export async function startRobot(t, { count = 3, ...options } = {}) {
    const panel = await startPanel(t, { servos: count === 1 ? "1" : `1-${count}`, ...options });
    const browser = await startBrowser(t);
    const page = await openPage(t, browser, panel.url, options);

    await shows(page, `${count} servo`, ".state-line");
    return { panel, browser, page };
}
