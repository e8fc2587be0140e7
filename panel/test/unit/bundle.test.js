// SPDX-License-Identifier: MIT
/* The bundle: small enough, and nothing in it that the strict Content-Security-Policy would block. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { gzipSync } from "node:zlib";
import { ROOT } from "../support/simulator.js";

const LIMIT = 100 * 1024; // bytes, gzipped
const files = ["index.html", "app.js", "style.css", "icon.svg"];
const read = (name) => readFileSync(join(ROOT, "build/panel", name));

// uPlot is loaded when the view Graphs is shown.
test("bundle: the page loads at most 100 KB gzipped", () => {
    const size = files.reduce((sum, name) => sum + gzipSync(read(name), { level: 9 }).length, 0);

    assert.ok(size <= LIMIT, `${size} bytes`);
});

test("bundle: loads nothing from elsewhere", () => {
    assert.ok(!/@import|url\((?!#)/.test(read("style.css")), "style.css");
    assert.ok(!/(?:src|href)="(?:https?:)?\/\//.test(read("index.html")), "index.html");
    assert.ok(!/import\s*\((?!"\.\/uPlot\.esm\.js"\))|\beval\(|new Function\(/.test(read("app.js")), "app.js");
});

test("bundle: no template has an attribute style", () => {
    assert.ok(!/<\w+[^<>]*\sstyle=/.test(read("app.js")));
});
