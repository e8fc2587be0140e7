// SPDX-License-Identifier: MIT
/* Bundles the page into a folder that any web server can serve. Prints the gzipped size of each file that a browser can
 * load; fails if their sum is above the limit.
 *
 * usage: node build.mjs TABLES.json FOLDER */

import { copyFile, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { bundle } from "./bundle/bundle.mjs";
import { LIMIT, gzippedSizes, sumOf } from "./bundle/size.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const [tables = join(HERE, "../build/panel-tables.json"), folder = join(HERE, "../build/panel")] = process.argv.slice(2);

// The folder itself stays: a server that runs has it as its working directory.
await mkdir(folder, { recursive: true });
for (const name of await readdir(folder)) await rm(join(folder, name), { recursive: true });

await writeFile(join(folder, "index.html"), (await readFile(join(HERE, "index.html"), "utf8")).replace(/<!--.*-->\n/, "")); // the licence stands beside it
for (const { name, text } of await bundle(resolve(tables))) await writeFile(join(folder, name), text);
for (const [from, to] of [
    ["public/icon.svg", "icon.svg"],
    ["node_modules/lit/LICENSE", "LICENSE-lit.txt"],
    ["node_modules/uplot/LICENSE", "LICENSE-uplot.txt"],
    ["../LICENSE", "LICENSE.txt"],
])
    await copyFile(join(HERE, from), join(folder, to));

const sizes = gzippedSizes(folder);
const sum = sumOf(sizes);
const parts = Object.entries(sizes).map(([name, size]) => `${name} ${size}`);

console.log(`panel: ${sum} bytes gzipped, at most ${LIMIT} (${parts.join(", ")})`);
if (sum > LIMIT) {
    console.error("panel: too large: shorten texts or code");
    process.exitCode = 1;
}
