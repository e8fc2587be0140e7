// SPDX-License-Identifier: MIT
/* The view Motion: record and replay. Loads of the simulator turn the outputs as a hand would. */

import assert from "node:assert/strict";
import test from "node:test";
import { PHONE, shows } from "../support/browser.js";
import { questions, reaches, startMotion, torque } from "../support/motion.js";

const HELD_UP = '.notice[data-code="motion-late"]';

/* Replays until the error is measured: again, twice at most, if a busy machine has held up the page. Returns what the page says. */
async function replay(page) {
    for (let tries = 0; tries < 3; tries++) {
        await page.click("button.replay");
        await page.waitForSelector(`.replayed, ${HELD_UP}`);
        const said = await page.$(".replayed");

        if (said) return said.evaluate((it) => it.innerText);
        await page.click(`${HELD_UP} button`);
    }
    throw new Error("the page was held up 3 times");
}

test("record: a movement by hand, replayed, error measured", async (t) => {
    const { page, hand } = await startMotion(t);

    await page.click("button.hold");
    await torque(page, "held", 3);
    await page.click("button.record");
    await shows(page, "Torque is on: servos 1, 2, 3", "dialog");
    await page.click("dialog .yes");
    await shows(page, /\d\.\d s/, ".recording-length");
    await torque(page, "limp", 3);
    assert.ok(await page.$("button.torque-off:enabled"));
    hand("load 1 200");
    await reaches(page, 1, 0, 110);
    hand("load 1 -200");
    await reaches(page, 1, 170, 300);
    hand("load 1 0");
    await page.click("button.record");
    await shows(page, /samples/, ".recorded");
    const rate = Number(/(\d+) samples a second/.exec(await page.$eval(".recorded", (it) => it.innerText))[1]);

    assert.ok(rate >= 20, `${rate} samples a second`);
    await page.click("button.replay");
    await shows(page, "Torque is not on", ".notice");
    await page.$eval("button.hold", (button) => button.scrollIntoView({ block: "center" })); // else it is below the header
    await page.click("button.hold");
    await torque(page, "held", 3);
    const text = await replay(page);
    const [, largest, mean] = /error ([\d.]+)°.*mean ([\d.]+)°/.exec(text).map(Number);

    t.diagnostic(`${rate} samples a second; ${text}`);
    assert.ok(largest > 0 && largest < 20 && mean < 5, text);

    await page.click("button.fit");
    await page.click("button.to-sequence");
    await shows(page, "rec1", ".sequence");
    await page.waitForFunction(() => document.querySelector(".player").getBoundingClientRect().top > 0); // in sight
    const steps = (await page.$$(".step")).length;

    assert.ok(steps >= 3 && steps <= 16, `${steps} steps`);
    await page.click("button.replay");
    await shows(page, /page plays/, ".player .motion-state");
    await page.waitForSelector(".recording .playhead");
    const isOnScreen = (element) => {
        const { left, top, width, height } = element.getBoundingClientRect();

        return element.contains(document.elementFromPoint(left + width / 2, top + height / 2));
    };

    assert.ok(await page.$eval(".player .end", isOnScreen)); // before the click, which would scroll to it
    assert.ok(await page.$eval(".player .motion-state", isOnScreen));
    assert.equal((await page.$$(".motion-state")).length, 1, "one status");
    assert.ok(await page.$(".recording .to-sequence:enabled"));
    await page.click(".player .end");
    await shows(page, "Nothing plays", ".motion-state");
    await page.waitForSelector(".recording .replay:enabled");

    await page.select("select.by", "page");
    await page.click("button.play");
    await shows(page, /page plays/, ".player .motion-state");
    await page.waitForSelector(".sequence .playhead");
    assert.equal(await page.$(".recording .playhead"), null);
    await page.click(".player .end");
    await shows(page, "Nothing plays", ".motion-state");
});

test("recording: kept when the connection is lost", async (t) => {
    const { page } = await startMotion(t);

    await page.click("button.torque-off");
    await torque(page, "limp", 3);
    await page.click("button.record");
    await shows(page, /0\.[2-9] s|[1-9]\.\d s/, ".recording-length");
    await page.click("button.disconnect");
    await shows(page, /recording has ended, since the connection is lost/, ".notice");
    await shows(page, /samples/, ".recorded");
    assert.equal(await page.$(".recording-length"), null);
    const asked = questions(page);

    await page.reload();
    assert.deepEqual(asked, ["beforeunload"]);
});

test("a recording comes into sight when it ends, and its heading has the focus", async (t) => {
    const { page } = await startMotion(t, { count: 1, viewport: PHONE });

    await page.focus("button.record");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => parseFloat(document.querySelector(".recording-length")?.innerText) > 0.3);
    await page.focus("button.record");
    await page.keyboard.press("Enter");
    await page.waitForSelector(".recording h2:focus");
    await page.waitForFunction(() => {
        const { top } = document.querySelector(".recording").getBoundingClientRect();

        return top >= document.querySelector("header").offsetHeight - 1 && top < innerHeight / 2;
    });
});
