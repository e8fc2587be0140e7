// SPDX-License-Identifier: MIT
/* The bundle: small enough, and nothing in it that the strict Content-Security-Policy would block. */

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { LIMIT, gzippedSizes, sumOf } from "../../bundle/size.mjs";
import { moduleOfTables } from "../../bundle/tables.mjs";
import { shortened, withShortTemplates } from "../../bundle/templates.mjs";
import { withFacts } from "../../bundle/uplot.mjs";
import { ROOT } from "../support/simulator.js";

const FOLDER = join(ROOT, "build/panel");
const read = (name) => readFileSync(join(FOLDER, name), "utf8");

test("bundle: all that the page can load is at most 100 KB gzipped", () => {
    const sizes = gzippedSizes(FOLDER);
    const sum = sumOf(sizes);

    assert.equal(LIMIT, 100000);
    assert.deepEqual(Object.keys(sizes).sort(), ["app.js", "icon.svg", "index.html", "style.css", "uPlot.esm.js"]);
    assert.ok(sum <= LIMIT, `${sum} bytes: ${JSON.stringify(sizes)}`);
});

test("bundle: the packed tables are the generated tables", async (t) => {
    const json = readFileSync(join(ROOT, "build/panel-tables.json"), "utf8");
    const folder = mkdtempSync(join(tmpdir(), "panel-"));
    const path = join(folder, "tables.mjs");

    t.after(() => rmSync(folder, { recursive: true }));
    writeFileSync(path, moduleOfTables(json));
    const { default: tables } = await import(path);

    assert.deepEqual(tables, JSON.parse(json));
});

test("bundle: a table that would not come out of the packing as it was is refused", () => {
    for (const rows of [[{ usage: "a~b" }], [{ usage: "a`b" }], [{ unit: "" }, {}], [{ words: ["a b"] }], [{ at: null }]])
        assert.throws(() => moduleOfTables(JSON.stringify({ commands: rows })), /cannot pack/, JSON.stringify(rows));
});

test("bundle: uPlot of another version is refused", () => {
    assert.throws(() => withFacts("export { uPlot as default };"), /uPlot has no/);
});

const SHORT = {
    '<p  class="row">\n    a  b </p>': "<p class=row> a b </p>",
    '<a href="#\0" title="\0" id="">': '<a href="#\0" title=\0 id="">',
    '<a title="a b" alt="a>b">': '<a title="a b" alt="a>b">',
    '<input value="1" />': "<input value=1>",
    '<i class="a"/>': '<i class="a"/>',
    "<pre>a\n  b</pre>": "<pre>a\n  b</pre>",
    "a < b": "a < b",
};

for (const [template, expected] of Object.entries(SHORT))
    test(`bundle: template ${JSON.stringify(template)} is shortened`, () => assert.equal(shortened(template), expected));

test("bundle: elements of SVG keep their slash", () => {
    assert.equal(shortened('<line x1="\0" />', false), "<line x1=\0 />");
});

test("bundle: only templates are shortened", () => {
    const text = 'const a = `x  y`; html`<p  class="b">${html`<i  />`}  ${"<p  >"}</p>`; css`a  b`;';

    assert.equal(withShortTemplates(text), 'const a = `x  y`; html`<p class=b>${html`<i />`} ${"<p  >"}</p>`; css`a  b`;');
});

// The minifier gives other names to properties that begin with _ (bundle/bundle.mjs).
test("bundle: no property of the page begins with _", () => {
    for (const name of readdirSync(join(ROOT, "panel/src"), { recursive: true }).filter((path) => path.endsWith(".js")))
        assert.ok(!/[.{,;\n]\s*_\w/.test(readFileSync(join(ROOT, "panel/src", name), "utf8")), name);
});

test("bundle: loads nothing from elsewhere", () => {
    assert.ok(!/@import|url\((?!#)/.test(read("style.css")), "style.css");
    assert.ok(!/(?:src|href)="(?:https?:)?\/\//.test(read("index.html")), "index.html");
    assert.ok(!/import\s*\((?!"\.\/uPlot\.esm\.js"\))|\beval\(|new Function\(/.test(read("app.js")), "app.js");
});

test("bundle: no template has an attribute style", () => {
    assert.ok(!/<\w+[^<>]*\sstyle=/.test(read("app.js")));
});

// The minifier gives short names to what only the page has (bundle/bundle.mjs).
test("bundle: names that a browser looks up stay", () => {
    for (const name of ["baudRate", "connectedCallback", "disconnectedCallback", "focusVisible", "isComposing", "preventScroll", "requestPort"])
        assert.match(read("app.js"), new RegExp(`\\b${name}\\b`), name);
});
