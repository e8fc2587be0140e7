// SPDX-License-Identifier: MIT
/* What the browser tests of the view Motion share: a page at that view, its chips of servos, its fields. */

import { shows, startRobotWithHand } from "./browser.js";

/* A robot, its page at the view Motion, and a hand. */
export async function startMotion(t, options = {}) {
    const robot = await startRobotWithHand(t, options);

    await robot.page.click("#tab-motion");
    await shows(robot.page, /Free on the board: \d+ poses/, ".board");
    return robot;
}

/* Waits until servo `id` is shown between `low` and `high` degrees. */
export function reaches(page, id, low, high) {
    return page.waitForFunction(
        (index, from, to) => {
            const degrees = parseFloat(document.querySelectorAll(".chip .at")[index]?.innerText);

            return degrees >= from && degrees <= to;
        },
        {},
        id - 1,
        low,
        high,
    );
}

export const torque = (page, state, count) => page.waitForFunction((css, due) => document.querySelectorAll(css).length === due, {}, `.chip.${state}`, count);

export async function fill(page, selector, text) {
    await page.waitForSelector(selector);
    await page.$eval(selector, (input, value) => {
        input.value = value;
        input.dispatchEvent(new Event("change"));
    }, text);
}

/* The questions of the browser, which are answered with yes. */
export function questions(page) {
    const asked = [];

    page.on("dialog", (dialog) => {
        asked.push(dialog.type());
        return dialog.accept();
    });
    return asked;
}

/* Types as a hand does: feedback comes between two keys. The page shows `shown` when the field has taken it. */
export async function type(page, selector, text, shown = text) {
    await page.waitForSelector(selector);
    await page.$eval(selector, (input) => input.select());
    if (!text) await page.keyboard.press("Delete");
    await page.keyboard.type(text, { delay: 120 });
    await page.keyboard.press("Enter");
    await page.waitForFunction((css, value) => document.querySelector(css)?.value === value, {}, selector, shown);
}
