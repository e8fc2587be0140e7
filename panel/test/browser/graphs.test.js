// SPDX-License-Identifier: MIT
/* The view Graphs: it shows and saves what simulated servos do. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { shows, startRobot, startRobotWithHand } from "../support/browser.js";

/* Moves servo 1 to its lower end while the page shows the view Robot, then shows the graphs. */
async function moveThenShow(page) {
    await page.click('[data-id="1"] .torque input');
    await page.waitForSelector('[data-id="1"] .torque input:checked');
    await page.$eval('[data-id="1"] .dial', (dial) => dial.focus());
    await page.keyboard.press("Home");
    await page.waitForFunction(() => parseFloat(document.querySelector('[data-id="1"] .position').textContent) < 2);
    await page.click("#tab-graphs");
    await page.waitForSelector('[data-quantity="position"] canvas');
}

/* Clicks “Save as CSV”, and returns the rows of the file as objects. */
async function save(page, folder) {
    const client = await page.createCDPSession();
    let name;
    const saved = new Promise((resolve) => {
        client.on("Browser.downloadWillBegin", (event) => (name = event.suggestedFilename));
        client.on("Browser.downloadProgress", ({ state }) => state === "completed" && resolve());
    });

    await client.send("Browser.setDownloadBehavior", { behavior: "allow", browserContextId: page.browserContext().id, downloadPath: folder, eventsEnabled: true });
    await page.click("button.save");
    await saved;
    assert.match(name, /^servos.*\.csv$/);
    const [head, ...lines] = readFileSync(join(folder, name), "utf8").trim().split("\r\n").map((line) => line.split(","));

    return lines.map((line) => Object.fromEntries(head.map((name, index) => [name, line[index] === "" ? null : Number(line[index])])));
}

/* Pixels of a graph that are drawn in the colour `mark`: c0 is that of the first servo. */
const countPixels = (page, quantity, mark = "c0") =>
    page.evaluate((name, css) => {
        const canvas = document.querySelector(`[data-quantity="${name}"] canvas`);
        const color = getComputedStyle(document.querySelector(`.mark .${css}`)).color.match(/\d+/g).map(Number);
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;

        for (let at = 0; at < data.length; at += 4)
            if (data[at + 3] > 200 && color.every((value, index) => Math.abs(data[at + index] - value) < 12)) count++;
        return count;
    }, quantity, mark);

test("graphs: values of a move are drawn, and saved as CSV", async (t) => {
    const { panel, page } = await startRobot(t, { count: 2 });

    await page.setViewport({ ...page.viewport(), deviceScaleFactor: 2 });
    await moveThenShow(page);
    await page.click("button.pause");
    await shows(page, "Paused", ".toolbar .hint");
    assert.ok((await countPixels(page, "position")) > 300, "a line is drawn"); // its goal alone has fewer
    await shows(page, /1: 0\.\d/, '[data-quantity="position"] figcaption');
    const rows = await save(page, panel.folder);
    const positions = rows.map((row) => row.servo_1_position_deg).filter((value) => value !== null);

    assert.ok(rows.length > 50, `${rows.length} rows`);
    assert.ok(Math.max(...positions) > 149 && Math.min(...positions) < 2, "the whole move");
    assert.ok(positions.some((value) => value > 40 && value < 110), "the way, too");
    assert.equal(rows.at(-1).servo_1_goal_deg, 0);
    assert.equal(Math.round(rows.at(-1).servo_2_position_deg), 150);
    assert.ok(rows.some((row) => Math.abs(row.servo_1_load_percent) > 1), "the load of the move");
    assert.ok(rows.every((row, index) => index === 0 || row.time_s > rows[index - 1].time_s));
});

test("graphs: servos and quantities can be chosen", async (t) => {
    const { panel, page } = await startRobot(t, { count: 2 });

    await page.click("#tab-graphs");
    await page.waitForSelector('[data-quantity="position"] canvas');
    await page.click('.servos input[value="1"]');
    await page.click('.quantities input[value="voltage"]');
    await page.waitForSelector('[data-quantity="voltage"] canvas');
    await shows(page, "2: 12.0", '[data-quantity="voltage"] figcaption');
    await page.click('.quantities input[value="load"]');
    await page.waitForFunction(() => !document.querySelector('[data-quantity="load"]'));
    const [row] = await save(page, panel.folder);

    assert.deepEqual(Object.keys(row), ["time_s", "servo_2_position_deg", "servo_2_goal_deg", "servo_2_voltage_V"]);
});

/* Pixels of the graph of the position in the colour of each mark. */
const pixelsOfMarks = async (page) => [await countPixels(page, "position", "c0"), await countPixels(page, "position", "c1")].map((count) => count > 100);

test("graphs: a curve has the colour of its legend after a servo has joined the list", async (t) => {
    const { page } = await startRobot(t, { count: 2 });

    await page.setViewport({ ...page.viewport(), deviceScaleFactor: 2 });
    await page.click("#tab-graphs");
    await page.waitForSelector('[data-quantity="position"] canvas');
    await page.click('.servos input[value="2"]');
    await shows(page, "1: 150", '[data-quantity="position"] figcaption');
    await new Promise((resolve) => setTimeout(resolve, 1000)); // some samples
    assert.deepEqual(await pixelsOfMarks(page), [true, false]);
    await page.$eval("panel-app", ({ session }) => session.robot.setServos([0, 1, 2]));
    await page.waitForSelector('[data-quantity="position"] figcaption .c1');
    await new Promise((resolve) => setTimeout(resolve, 1000));
    assert.deepEqual(await pixelsOfMarks(page), [false, true]);
});

test("graphs: the right and the middle button of the mouse do not zoom", async (t) => {
    const { page } = await startRobot(t, { count: 1 });

    await page.click("#tab-graphs");
    await page.waitForSelector('[data-quantity="position"] canvas');
    const box = await (await page.$('[data-quantity="position"] .u-over')).boundingBox();

    for (const button of ["right", "middle"]) {
        await page.mouse.move(box.x + box.width * 0.5, box.y + 20);
        await page.mouse.down({ button });
        await page.mouse.move(box.x + box.width * 0.8, box.y + 30, { steps: 5 });
        await page.mouse.up({ button });
        assert.equal(await page.$eval(".span", (select) => select.value), "10", button);
        await shows(page, "Drag in a graph", ".toolbar .hint");
    }
});

test("graphs: all servos can be chosen at once, or none", async (t) => {
    const { page } = await startRobot(t, { count: 4 });

    await page.click("#tab-graphs");
    await page.click(".servos .all");
    await shows(page, "4: 150", '[data-quantity="position"] figcaption');
    await page.click(".servos .none");
    await shows(page, "Choose a servo.", ".graphs");
});

test("graphs: a drag zooms and pauses, go on shows the present", async (t) => {
    const { panel, page } = await startRobot(t, { count: 1 });

    await moveThenShow(page);
    const box = await (await page.$('[data-quantity="position"] .u-over')).boundingBox();

    await page.mouse.move(box.x + box.width * 0.9, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.95, box.y + 30, { steps: 5 });
    await page.mouse.up();
    await shows(page, "Paused", ".toolbar .hint");
    const rows = await save(page, panel.folder);
    const width = rows.at(-1).time_s - rows[0].time_s;

    assert.ok(width > 0.3 && width < 0.52, `${width} s of 10`);
    assert.equal(await page.$eval(".span", (select) => select.selectedOptions[0].text), "0.5 s");
    await page.click("button.go-on");
    await shows(page, "Drag in a graph", ".toolbar .hint");
    assert.equal(await page.$eval(".span", (select) => select.value), "10");
});

test("graphs: the sign of load is told, and is the way in which the load pushes", async (t) => {
    const { page, hand } = await startRobotWithHand(t, { count: 1 });
    const box = '[data-id="1"] .torque input';

    await page.click(box);
    await page.waitForSelector(`${box}:checked`);
    hand("load 1 -300");
    await shows(page, /Load\s+[1-9]/, '[data-id="1"] dl'); // more than 0
    await page.click(box);
    await page.waitForFunction(() => parseFloat(document.querySelector('[data-id="1"] .position').textContent) > 170); // counterclockwise
    await page.click("#tab-graphs");
    await shows(page, "+: the load pushes counterclockwise", '[data-quantity="load"] figcaption');
});
