// SPDX-License-Identifier: MIT
/* The view Motion with firmware that has no motions. */

import assert from "node:assert/strict";
import test from "node:test";
import { shows, startRobot } from "../support/browser.js";
import { fill, reaches, torque } from "../support/motion.js";

for (const [name, options] of [
    ["console", { board: "arbotix" }],
    ["bridge", { board: "atmega128", elf: "build/atmega128/bridge.elf" }],
])
    test(`profile ${name}: says what is missing, the page plays`, async (t) => {
        const { page } = await startRobot(t, { count: 1, ...options });

        await page.click("#tab-motion");
        await shows(page, "stores no poses and sequences", ".missing");
        assert.ok(await page.$eval("button.store", (it) => it.disabled));
        await page.click("button.hold");
        await torque(page, "held", 1);
        await page.click("button.capture");
        await shows(page, "pose1", ".pose");
        await page.click("button.add-step");
        await fill(page, ".editor input[data-id]", "100");
        await page.click("button.play");
        await reaches(page, 1, 99, 101);
        await shows(page, "Nothing plays", ".motion-state");
    });
