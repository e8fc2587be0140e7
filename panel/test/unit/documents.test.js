// SPDX-License-Identifier: MIT
/* What the documents and the bundle promise: the table of notices, the views, the texts of licences. */

import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { filesBundled } from "../../bundle/bundle.mjs";
import { texts } from "../../src/texts/texts.js";
import { withNotices } from "../support/notices.js";
import { ROOT } from "../support/simulator.js";

const read = (path) => readFileSync(join(ROOT, path), "utf8");
const LICENSES = { lit: "LICENSE-lit.txt", uplot: "LICENSE-uplot.txt" };

test("docs/panel.md: its table has all notices (make docs)", () => {
    const page = read("docs/panel.md");

    assert.match(page, /<!-- notices -->/);
    assert.equal(page, withNotices(page));
});

test("docs/panel.md: placeholders of the notices are explained", () => {
    const [, told, table] = /## Notices and remedies\n(.*)<!-- notices -->(.*)<!-- end -->/s.exec(read("docs/panel.md"));
    const used = table.match(/\b(?:N|A|B|X|NAME|LINE|COMMAND|TEXT|CAUSE)\b/g);

    for (const name of new Set(used)) assert.match(told, new RegExp(`^\\| [A-Z, ]*\\b${name}\\b[A-Z, ]* \\|`, "m"));
    assert.ok(table.includes(" Line LINE: ") && table.includes("| “COMMAND”: error N"));
});

test("docs/panel.md: a section for each view", () => {
    const page = read("docs/panel.md");

    for (const name of Object.values(texts.tabs)) assert.ok(page.includes(`\n### ${name}\n`), name);
});

/* The storeys of docs/internals/panel.md, the lowest first. */
const STOREYS = ["port", "wire", "model", "views"];

test("internals/panel.md: a storey imports only from storeys below it, and from texts", () => {
    const heightOf = (folder) => (folder === "texts" ? -1 : STOREYS.indexOf(folder));

    for (const storey of [...STOREYS, "texts"])
        for (const name of readdirSync(join(ROOT, "panel/src", storey)).filter((path) => path.endsWith(".js")))
            for (const [, other] of read(`panel/src/${storey}/${name}`).matchAll(/from "\.\.\/(\w+)\//g))
                assert.ok(heightOf(other) < heightOf(storey), `${storey}/${name} imports from ${other}`);
});

/* Packages of npm whose code is in the bundle. */
async function packagesOfBundle() {
    const paths = await filesBundled(join(ROOT, "build/panel-tables.json"));

    return new Set(paths.map((path) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1]).filter((name) => name));
}

/* The packages of Lit have one licence, by one text. */
const licenceOf = (name) => (/^(?:@lit\/|lit(?:-|$))/.test(name) ? "lit" : name);

test("bundle: has the licence text of each package", async () => {
    const packages = await packagesOfBundle();

    assert.deepEqual([...packages].sort(), ["lit", "lit-html", "uplot"]);
    for (const name of packages) {
        const file = LICENSES[licenceOf(name)];

        assert.ok(file, `no licence text for ${name}`);
        assert.equal(read(`build/panel/${file}`), read(`panel/node_modules/${licenceOf(name)}/LICENSE`));
        const own = `panel/node_modules/${name}/LICENSE`;

        if (existsSync(join(ROOT, own))) assert.equal(read(own).trim(), read(`build/panel/${file}`).trim(), name);
    }
    assert.match(read("build/panel/LICENSE-lit.txt"), /Redistribution and use in source and binary forms/);
    assert.match(read("build/panel/LICENSE-uplot.txt"), /Permission is hereby granted/);
    assert.equal(read("build/panel/LICENSE.txt"), read("LICENSE"));
});
