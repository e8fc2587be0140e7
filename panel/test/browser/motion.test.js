// SPDX-License-Identifier: MIT
/* The view Motion: poses, steps, files; teach and play. Loads of the simulator turn the outputs as a hand would. */

import assert from "node:assert/strict";
import test from "node:test";
import { PHONE, shows, startRobot } from "../support/browser.js";
import { fill, questions, reaches, startMotion, torque, type } from "../support/motion.js";

test("fields keep what is typed slowly, while feedback comes", async (t) => {
    const { page } = await startMotion(t);

    await page.click("button.capture"); // opens the pose
    await type(page, '.editor input[data-id="1"]', "100.3");
    await type(page, ".editor .own-name", "wave");
    await shows(page, "wave", ".pose");
    await page.click("button.add-step");
    await type(page, '[data-step="1"] .time', "2.50");
    await type(page, '.editor input[data-id="1"]', "100.3");
    await page.$eval('.editor input[data-id="1"]', (input) => input.select());
    await page.keyboard.type("400", { delay: 120 });
    await page.keyboard.press("Enter");
    await shows(page, "out of range", ".notice");
    await page.waitForFunction(() => document.querySelector('.editor input[data-id="1"]').value === "100.3");
});

test("fields take a decimal comma, and refuse what is no number", async (t) => {
    const { page } = await startMotion(t, { count: 1 });

    await page.click("button.capture"); // opens the pose
    await type(page, '.editor input[data-id="1"]', "12,5", "12.6"); // the next raw value
    await page.click("button.add-step");
    await type(page, '[data-step="1"] .time', "0,5", "0.50");
    await type(page, '[data-step="1"] .dwell', "1,25", "1.25");
    for (const text of ["", "0x10"]) {
        await type(page, '[data-step="1"] .dwell', text, "1.25");
        await shows(page, "a time cannot be stored", ".notice");
        await page.click(".notice [aria-label=Dismiss]");
        await type(page, '.editor input[data-id="1"]', text, "12.6");
        await shows(page, "An angle is out of range", ".notice");
        await page.click(".notice [aria-label=Dismiss]");
    }
});

test("teach: two poses by hand, stored, played by the board", async (t) => {
    const { page, hand } = await startMotion(t);

    await page.click("button.torque-off");
    await torque(page, "limp", 3);
    hand("load 1 200");
    await reaches(page, 1, 0, 130);
    hand("load 1 0");
    await page.click("button.hold");
    await torque(page, "held", 3);
    await fill(page, ".pose-name", "left");
    await page.click("button.capture");
    await shows(page, "left", ".pose");
    await page.click("button.add-step");
    await page.click("button.torque-off");
    await torque(page, "limp", 3);
    hand("load 1 -200");
    await reaches(page, 1, 170, 300);
    hand("load 1 0");
    await page.click("button.hold");
    await torque(page, "held", 3);
    await fill(page, ".pose-name", "right");
    await page.click("button.capture");
    await shows(page, "right", ".pose");
    await page.click("button.add-step");
    await fill(page, '[data-step="2"] select', "right");
    await fill(page, '[data-step="2"] .time', "0.8");

    await page.click("input.loop");
    await shows(page, "Store and play seq1", "button.play");
    await page.click("button.play");
    await page.waitForFunction(() => document.querySelector(".player progress")?.value > 0);
    await shows(page, /confirmed 2 poses and 1 sequence/, ".notice");
    await shows(page, /seq1 plays: step 2 of 2/, ".motion-state");
    await page.waitForSelector(".sequence .playhead");
    await page.waitForSelector(".player [title^='Press End first'] input.loop:disabled");
    await page.waitForSelector("input.times:disabled");
    await shows(page, /^Play seq1/, "button.play");
    await reaches(page, 1, 0, 132);
    await reaches(page, 1, 168, 300);
    await page.click("button.pause");
    await shows(page, /paused/, ".motion-state");
    await page.click("button.resume");
    await page.click("button.end");
    await shows(page, "Nothing plays", ".motion-state");

    await page.click("button.play");
    await shows(page, /seq1 plays/, ".motion-state");
    await page.keyboard.press("Escape");
    await shows(page, "Torque is off", ".stop-state");
    await shows(page, "Nothing plays", ".motion-state");
});

test("after a reload the speed is that of the board, and how often it plays is shown as unknown", async (t) => {
    const { page } = await startMotion(t, { count: 1 });

    await page.click("button.hold");
    await torque(page, "held", 1);
    await page.click("button.capture");
    await page.click("button.add-step");
    await page.click("input.loop");
    await page.$eval("input.override", (input) => {
        input.value = "10";
        input.dispatchEvent(new Event("change"));
    });
    await page.click("button.play");
    await shows(page, /seq1 plays/, ".motion-state");
    await page.reload();
    await shows(page, /seq1 plays/, ".motion-state");
    await shows(page, "10 %", ".speed");
    const fields = await page.evaluate(() => {
        const [loop, times] = [document.querySelector("input.loop"), document.querySelector("input.times")];

        return [loop.indeterminate, loop.disabled, times.value, times.placeholder, times.disabled];
    });

    assert.deepEqual(fields, [true, true, "", "unknown", true]);
    await page.click("button.end");
    await shows(page, "Nothing plays", ".motion-state");
    await page.waitForSelector("input.loop:enabled");
    assert.deepEqual(await page.$eval("input.loop", ({ indeterminate, checked }) => [indeterminate, checked]), [false, false]);
});

test("phone: Play is the first box, and the limit of a name is told", async (t) => {
    const { page } = await startMotion(t, { count: 18, viewport: PHONE });
    const bottom = await page.$eval("button.play", (button) => button.getBoundingClientRect().bottom);

    assert.ok(bottom < PHONE.height, `Play ends at ${bottom} px`);
    await shows(page, "up to 8 letters and digits", ".teach");
});

test("the browser asks before it leaves poses that are not stored", async (t) => {
    const { page } = await startMotion(t, { count: 1 });
    const asked = questions(page);

    await page.reload();
    await shows(page, /Free on the board: \d+ poses/, ".board");
    assert.deepEqual(asked, []);
    await page.click("button.capture");
    await shows(page, "pose1", ".pose");
    await page.reload();
    assert.deepEqual(asked, ["beforeunload"]);
});

test("the proposed name of a pose is free after the poses of the board were loaded, and what is typed stays", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    for (const line of ["group 1", "pose save pose1"])
        await page.evaluate((text) => document.querySelector("panel-app").session.controller.run(text), line);
    await page.click("#tab-motion");
    await page.waitForFunction(() => document.querySelector(".pose-name")?.value === "pose2");
    await page.click("button.capture");
    await page.waitForFunction(() => document.querySelector(".pose-name").value === "pose3");
    await type(page, ".pose-name", "wave", "pose3");
    await shows(page, "wave", ".pose");
});

test("Stop is at hand while a question is open", async (t) => {
    const { page } = await startMotion(t, { count: 1 });

    await page.click("button.capture");
    await shows(page, "pose1", ".pose");
    await page.click("button.load");
    await page.waitForSelector("dialog[open] button.no:focus");
    await page.click("button.stop");
    await shows(page, "Torque is off", ".stop-state.verified");
    await page.click("dialog button.no");
    await page.waitForFunction(() => !document.querySelector("dialog"));
    assert.equal((await page.$$(".pose")).length, 1);
});

test("files: damaged changes nothing; undo restores a step", async (t) => {
    const { page } = await startMotion(t, { count: 1, viewport: PHONE });
    const open = (text) => page.$eval("input.import", (input, content) => {
        const files = new DataTransfer();

        files.items.add(new File([content], "motions.txt"));
        input.files = files.files;
        input.dispatchEvent(new Event("change"));
    }, text);

    await shows(page, "Press “Capture pose”", ".poses"); // what to do first
    await shows(page, "First capture poses", ".sequence");
    await open("group 1\npose set up 90\npose set down 9x\n");
    await shows(page, "Line 3 of the file is damaged", ".notice");
    assert.equal((await page.$$(".pose")).length, 0);
    await open("group 1\npose set up 90\nsequence nod new up 1s\n");
    await shows(page, /up/, ".list .pose");
    assert.equal((await page.$$(".step")).length, 1);
    const heights = await page.$$eval(".motion button:not(.open), .motion select, .motion .file, .motion input:not([type=checkbox], [type=radio], [type=range], [type=file])",
        (elements) => [...new Set(elements.map((element) => Math.round(element.getBoundingClientRect().height)))]);

    assert.equal(heights.length, 1, `heights: ${heights}`);
    await page.click(".step .remove");
    await page.click(".notice .undo");
    await page.waitForSelector(".step");
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "scrolls sideways");
});
