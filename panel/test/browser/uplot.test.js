// SPDX-License-Identifier: MIT
/* uPlot as the page has it, without what src/views/plot.js does not use (bundle/uplot.mjs), draws and answers as the whole
 * uPlot of its package: each pixel, each element, each call. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { build } from "esbuild";
import { withoutLegend } from "../../bundle/uplot.mjs";
import { openPage, startBrowser } from "../support/browser.js";

const ROOT = new URL("../../../", import.meta.url).pathname;
const WHOLE = join(ROOT, "panel/node_modules/uplot/dist/uPlot.esm.js");
const OF_PAGE = join(ROOT, "build/panel/uPlot.esm.js");
const STYLE = readFileSync(join(ROOT, "panel/node_modules/uplot/dist/uPlot.min.css"), "utf8");
const STYLE_OF_GRAPHS = "body { margin: 0; line-height: 1.4; color: #123; background: #fff } .graph { position: absolute; left: 2vw } .graph .uplot { font-family: serif }"; // the part has no font: no element has text
const SCALES = [1, 2]; // pixels of the screen for a pixel of the page

/* The text of a script that makes plot.js the global `plot`, with this uPlot. */
async function scriptOf(uPlot) {
    const { outputFiles } = await build({
        stdin: { contents: 'export * from "./plot.js"', resolveDir: join(ROOT, "panel/src/views") },
        alias: { uplot: uPlot },
        bundle: true,
        format: "iife",
        globalName: "plot",
        write: false,
    });

    return outputFiles[0].text;
}

/* In the page: two graphs of three lines, which share a cursor, and `calls`: what they have called. */
function makeGraphs() {
    globalThis.calls = [];
    globalThis.graphs = ["position", "temperature"].map((quantity, index) => {
        const element = document.createElement("div");
        const tell = (name) => (...values) => {
            const numbers = values.filter((value) => typeof value === "number");

            globalThis.calls.push([quantity, name, ...numbers].join(" "));
        };

        element.className = "graph";
        element.style.top = `${10 + 260 * index}px`;
        element.addEventListener("click", () => tell("click")());
        document.body.append(element);
        return new globalThis.plot.Plot(element, {
            quantity,
            lines: [
                { id: 1, quantity, color: "rgb(200, 0, 0)", dashes: [] },
                { id: 2, quantity, color: "rgb(0, 0, 200)", dashes: [6, 3] },
                { id: 1, quantity: "goal", color: "rgb(0, 120, 0)", dashes: [2, 2] },
            ],
            colors: { ink: "rgb(30, 30, 30)", line: "rgb(200, 200, 200)" },
            width: 600,
            height: 250,
            onZoom: tell("zoom"),
            onReset: tell("reset"),
            onCursor: tell("cursor"),
        });
    });
}

/* In the page: draws `count` values of each line from `from` to `to` s, with a gap. */
function draw({ count, from, to, width = 600, height = 250, size = 100 }) {
    const times = Array.from({ length: count }, (_, index) => from + ((to - from) * index) / Math.max(1, count - 1));
    const gapAt = Math.floor(count / 3);
    const lineOf = (phase) => times.map((time, index) => (index > 0 && index === gapAt ? null : size * Math.sin(time * 3 + phase) + index / 100));
    const nulls = times.map((time, index) => (index < count / 2 ? null : size / 2));
    const history = { lines: () => [times, lineOf(0), lineOf(1), nulls] };

    for (const graph of globalThis.graphs) graph.draw(history, [from, to], { width, height });
}

/* In the page: all that is seen, and what was called since. */
async function seen() {
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    const lookOf = (element) => [element.className, JSON.stringify(element.getBoundingClientRect()), ...Object.values({ ...getComputedStyle(element) })].join();

    return {
        looks: [...document.querySelectorAll(".graph *")].map(lookOf),
        pixels: [...document.querySelectorAll("canvas")].map((canvas) => canvas.toDataURL()),
        elements: [...document.querySelectorAll(".graph")].map((graph) => graph.innerHTML),
        times: globalThis.graphs.map((graph) => [graph.cursorTime, graph.isDragged]),
        texts: [...document.querySelectorAll(".graph")].map((graph) => graph.textContent),
        calls: globalThis.calls.splice(0),
    };
}

const STEPS = {
    "no values": (page) => page.evaluate(draw, { count: 0, from: 0, to: 10 }),
    "one value": (page) => page.evaluate(draw, { count: 1, from: 0, to: 10 }),
    "values with gaps": (page) => page.evaluate(draw, { count: 300, from: 0, to: 10 }),
    "more values than four a pixel": (page) => page.evaluate(draw, { count: 5000, from: 0, to: 10 }),
    "times below 0": (page) => page.evaluate(draw, { count: 50, from: -4, to: 1 }),
    "a short time": (page) => page.evaluate(draw, { count: 50, from: 100, to: 100.02 }),
    "great values": (page) => page.evaluate(draw, { count: 50, from: 0, to: 300, size: 1e6 }),
    "small values": (page) => page.evaluate(draw, { count: 50, from: 0, to: 300, size: 1e-3 }),
    "another size": (page) => page.evaluate(draw, { count: 50, from: 0, to: 10, width: 480, height: 150 }),
    "too small for an axis": (page) => page.evaluate(draw, { count: 50, from: 0, to: 10, width: 50, height: 20 }),
    "the first size": (page) => page.evaluate(draw, { count: 300, from: 0, to: 10 }),
    "pointer enters": (page) => page.mouse.move(200, 100),
    "pointer moves": (page) => page.mouse.move(303, 120),
    "values move below the pointer": (page) => page.evaluate(draw, { count: 300, from: 2, to: 12 }),
    "size changes below the pointer": (page) => page.evaluate(draw, { count: 300, from: 2, to: 12, width: 580, height: 240 }),
    "pointer leaves": (page) => page.mouse.move(900, 700),
    "pointer comes to the same place": (page) => page.mouse.move(303, 120),
    "pointer goes to the other graph": (page) => page.mouse.move(303, 400),
    "button goes down": (page) => page.mouse.down(),
    "drag begins": (page) => page.mouse.move(340, 410),
    "drag to the left": (page) => page.mouse.move(150, 420),
    "button goes up": (page) => page.mouse.up(),
    "pointer moves after the drag": (page) => page.mouse.move(220, 380),
    "click": (page) => page.mouse.click(400, 400),
    "double click": (page) => page.mouse.click(410, 390, { count: 2 }),
    "other button": (page) => page.mouse.click(420, 390, { button: "right" }),
    "drag leaves the graph": async (page) => {
        await page.mouse.move(500, 100);
        await page.mouse.down();
        await page.mouse.move(560, 110, { steps: 3 });
        await page.mouse.move(900, 110);
        await page.mouse.up();
    },
    "pointer at the edge": (page) => page.mouse.move(77, 90),
    "window has another size": async (page) => {
        const resized = page.evaluate(() => new Promise((resolve) => addEventListener("resize", () => resolve(), { once: true })));

        await page.setViewport({ ...page.viewport(), width: 900 });
        await resized;
        await page.mouse.move(250, 90);
    },
    "end of a graph": (page) => page.evaluate(() => globalThis.graphs.pop().end()),
    "pointer moves after the end": (page) => page.mouse.move(280, 90),
};

/* What is seen after each step, with this uPlot. */
async function run(page, uPlot, style, deviceScaleFactor) {
    const results = new Map();

    await page.goto("about:blank");
    await page.mouse.move(0, 0);
    await page.setViewport({ width: 1000, height: 800, deviceScaleFactor });
    await page.addStyleTag({ content: style + STYLE_OF_GRAPHS });
    await page.addScriptTag({ content: await scriptOf(uPlot) });
    await page.evaluate(() => globalThis.plot.load());
    await page.evaluate(makeGraphs);
    for (const [name, step] of Object.entries(STEPS)) {
        await step(page);
        results.set(name, await page.evaluate(seen));
    }
    return results;
}

for (const scale of SCALES)
    test(`uPlot: the page's part draws as the whole, scale ${scale}`, async (t) => {
        const page = await openPage(t, await startBrowser(t), "about:blank", { slow: 1 });
        const whole = await run(page, WHOLE, STYLE, scale);
        const part = await run(page, OF_PAGE, withoutLegend(STYLE), scale);
        const all = [...whole.values()];

        assert.ok(new Set(all.map(({ pixels }) => pixels[0])).size >= 10, "the steps draw different graphs");
        assert.ok(all.every(({ texts }) => texts.every((text) => text === "")), "no element has text");
        for (const call of ["zoom", "reset", "cursor", "click"])
            assert.ok(all.some(({ calls }) => calls.some((text) => text.includes(call))), call);
        for (const [name, result] of whole)
            for (const [what, value] of Object.entries(result))
                assert.ok(JSON.stringify(part.get(name)[what]) === JSON.stringify(value), `${name}: other ${what}`);
    });
