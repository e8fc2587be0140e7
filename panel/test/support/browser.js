// SPDX-License-Identifier: MIT
/* For the tests of the page: one Chromium for all tests of a file, and a robot behind the page. */

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after } from "node:test";
import { ROOT, atEnd, launch, openPage, shows, startPanel } from "./page.js";

export * from "./page.js";

let chromium = null; // one for all tests of a file: a start takes a second of CPU

after(async () => (await chromium)?.close());

/* The browser, whose pages end with the test. Tests of a file share its context, since a context for each test costs 1.3 s of
 * CPU. The page stores nothing, and each robot has a port of its own. */
export async function startBrowser(t) {
    chromium ??= launch();
    const browser = (await chromium).defaultBrowserContext();
    const before = await browser.pages();

    atEnd(t, async () => {
        const pages = await browser.pages();

        await Promise.all(pages.filter((page) => !before.includes(page)).map((page) => page.close()));
    });
    return browser;
}

/* The page, the browser and the robot at once. The page is connected and has found `count` servos. */
export async function startRobot(t, { count = 3, ...options } = {}) {
    const panel = await startPanel(t, { servos: count === 1 ? "1" : `1-${count}`, ...options });
    const browser = await startBrowser(t);
    const page = await openPage(t, browser, panel.url, options);

    await shows(page, `${count} servo`, ".state-line");
    return { panel, browser, page };
}

/* As startRobot(), with hand(order): an order to the simulator, as a load that turns an output. */
export async function startRobotWithHand(t, options = {}) {
    const folder = mkdtempSync(join(tmpdir(), "poke-"));
    const socket = join(folder, "poke");
    const robot = await startRobot(t, { ...options, more: [...(options.more ?? []), "--poke", socket] });

    t.after(() => rmSync(folder, { recursive: true }));
    return { ...robot, hand: (order) => execFileSync(join(ROOT, "build/host/cds55xx-sim"), ["poke", socket, order]) };
}
