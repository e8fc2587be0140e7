// SPDX-License-Identifier: MIT
/* Bundles the page into a folder that any web server can serve. Prints the gzipped size of what a browser
 * loads to show the page, and of what the view Graphs adds (uPlot); fails if the first is above the limit.
 *
 * usage: node build.mjs TABLES.json FOLDER */

import { build } from "esbuild";
import { copyFile, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const LIMIT = 100 * 1024; // bytes, gzipped
const LOADED = ["index.html", "app.js", "style.css", "icon.svg"];
const LATER = ["uPlot.esm.js"];
const HERE = dirname(fileURLToPath(import.meta.url));
const [tables = join(HERE, "../build/panel-tables.json"), folder = join(HERE, "../build/panel")] = process.argv.slice(2);

// The folder itself stays: a server that runs has it as its working directory.
await mkdir(folder, { recursive: true });
for (const name of await readdir(folder)) await rm(join(folder, name), { recursive: true });

/* Indentation within templates: saves 0.8 KB gzipped. */
const withoutIndentation = {
    name: "without-indentation",
    setup: ({ onLoad }) =>
        onLoad({ filter: /panel\/src\/.*\.js$/ }, async ({ path }) => ({
            contents: (await readFile(path, "utf8")).replace(/\n\s+/g, "\n"),
            loader: "js",
        })),
};

/* Parts of uPlot that no graph of the page uses: saves 2.6 KB gzipped. */
const UNUSED = [/\(paths\.stepped = stepped\);/, /\(paths\.bars += bars\);/, /\(paths\.spline += monotoneCubic\);/, /uPlot\.join = join;/];
const withoutUnused = {
    name: "without-unused",
    setup: ({ onLoad }) =>
        onLoad({ filter: /uPlot\.esm\.js$/ }, async ({ path }) => {
            let contents = await readFile(path, "utf8");

            for (const part of UNUSED) {
                if (!part.test(contents)) throw new Error(`uPlot has no ${part}: renew the list`);
                contents = contents.replace(part, "");
            }
            return { contents, loader: "js" };
        }),
};

await build({
    absWorkingDir: HERE,
    plugins: [withoutIndentation, withoutUnused],
    entryPoints: { app: "src/app.js", style: "src/style.css" },
    outdir: resolve(folder),
    alias: { "#tables": resolve(tables) },
    bundle: true,
    splitting: true, // what is imported later is a file of its own
    chunkNames: "[name]",
    minify: true,
    format: "esm",
    target: ["chrome115", "firefox128", "safari17"],
    legalComments: "none", // the licence texts stand beside the page
    logLevel: "warning",
});
for (const [from, to] of [
    ["index.html", "index.html"],
    ["public/icon.svg", "icon.svg"],
    ["node_modules/lit/LICENSE", "LICENSE-lit.txt"],
    ["node_modules/uplot/LICENSE", "LICENSE-uplot.txt"],
    ["../LICENSE", "LICENSE.txt"],
])
    await copyFile(join(HERE, from), join(folder, to));

async function sizeOf(names) {
    const sizes = await Promise.all(names.map(async (name) => gzipSync(await readFile(join(folder, name)), { level: 9 }).length));

    return sizes.reduce((sum, size) => sum + size);
}

// In minified code a line that begins with blanks is within a template of HTML, where one blank does as well.
const app = join(folder, "app.js");

await writeFile(app, (await readFile(app, "utf8")).replace(/\n {4,}/g, " "));
const size = await sizeOf(LOADED);

console.log(`panel: ${size} bytes gzipped, at most ${LIMIT}; graphs: ${await sizeOf(LATER)} more`);
if (size > LIMIT) {
    console.error("panel: too large; find out with esbuild --analyze what grew");
    process.exitCode = 1;
}
