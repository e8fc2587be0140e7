// SPDX-License-Identifier: MIT
/* Bundles the modules and the style sheets of the page, without what the page does not use. Each step says what it saves. */

import { readFileSync, readdirSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parse } from "acorn";
import { build } from "esbuild";
import { minify } from "terser";
import { moduleOfTables } from "./tables.mjs";
import { withShortTemplates } from "./templates.mjs";
import { withFacts, withoutLegend } from "./uplot.mjs";

const PANEL = join(dirname(fileURLToPath(import.meta.url)), "..");
const read = (path) => readFileSync(path, "utf8");

/* Changes the text of each file that `filter` finds. */
const transform = (name, filter, change, loader = "js") => ({
    name,
    setup: ({ onLoad }) => onLoad({ filter }, ({ path }) => ({ contents: change(read(path)), loader })),
});

/* gzip finds what a text repeats within 32 KB only. So modules that are alike stand side by side, a storey after another:
 * saves 1.8 KB gzipped. */
const STOREYS = ["texts", "model", "wire", "port", "views"];
const orderByStorey = {
    name: "order-by-storey",
    setup({ onResolve, onLoad }) {
        onResolve({ filter: /^storeys$/ }, ({ path }) => ({ path, namespace: "storeys" }));
        onLoad({ filter: /./, namespace: "storeys" }, () => {
            const namesOf = (storey) => readdirSync(join(PANEL, "src", storey)).filter((name) => name.endsWith(".js")).sort();
            const modules = ["#tables", ...STOREYS.flatMap((storey) => namesOf(storey).map((name) => `./${storey}/${name}`)), "./app.js"];

            return { contents: modules.map((path) => `import "${path}";`).join("\n"), resolveDir: join(PANEL, "src") };
        });
    },
};

/* What esbuild leaves: saves 4.4 KB gzipped. Names that begin with one _ are private to Lit and to uPlot: 0.2 KB of it. */
const MINIFY = {
    module: true,
    ecma: 2022,
    compress: { passes: 8, keep_fargs: false, lhs_constants: false, pure_getters: true, unsafe_arrows: true },
    mangle: { properties: { regex: /^_(?!_)/, keep_quoted: true } },
};

const KEPT = ["baudRate", "hasConsole", "readAll", "setServos"]; // Web Serial or tests in the page use them

function* nodesOf(node) {
    if (!node || typeof node !== "object") return;
    yield node;
    for (const child of Object.values(node)) yield* nodesOf(child);
}

/* Names as isRunning that only the page has: keys of its texts, methods and fields of its classes, and what begins with is or
 * has. A name that stands in a string stays: it may be looked up. Short names for them save 1.4 KB gzipped. */
function ownNames() {
    const names = new Set();
    const strings = new Set(KEPT);

    for (const path of readdirSync(join(PANEL, "src"), { recursive: true }).filter((name) => name.endsWith(".js")))
        for (const { type, key, left, value, name } of nodesOf(parse(read(join(PANEL, "src", path)), { ecmaVersion: "latest", sourceType: "module" }))) {
            if ((type === "MethodDefinition" && key.type === "Identifier") || (type === "Property" && path.startsWith("texts"))) names.add(key.name);
            if (type === "AssignmentExpression" && left.object?.type === "ThisExpression" && left.property.type === "Identifier") names.add(left.property.name);
            if (type === "Identifier" && /^(?:is|has|on|keeps|names|reset|bus|alarm|speed)[A-Z]/.test(name)) names.add(name);
            if (type === "Literal") strings.add(value);
        }
    return [...names].filter((name) => /^[a-z]+[A-Z]\w*$/.test(name) && !strings.has(name));
}

/* What esbuild makes. `tables`: path of the generated tables. */
const runEsbuild = (tables) =>
    build({
        absWorkingDir: PANEL,
        plugins: [
            orderByStorey,
            transform("short-templates", /panel\/src\/.*\.js$/, withShortTemplates),
            transform("columns", /\.json$/, moduleOfTables),
            transform("uplot-facts", /uPlot\.esm\.js$/, withFacts),
            transform("uplot-style", /uPlot\.min\.css$/, withoutLegend, "css"),
        ],
        entryPoints: { app: "storeys", style: "src/style.css" },
        outdir: PANEL,
        alias: { "#tables": tables },
        bundle: true,
        splitting: true, // what is imported later is a file of its own
        chunkNames: "[name]",
        minify: true,
        format: "esm",
        target: ["chrome115", "firefox128", "safari17"],
        legalComments: "none", // the licence texts stand beside the page
        logLevel: "warning",
        write: false,
        metafile: true,
    });

/* Paths of all files whose text is in the bundle. */
export const filesBundled = async (tables) => Object.keys((await runEsbuild(tables)).metafile.inputs);

/* Returns the files of the bundle: [{name, text}]. */
export async function bundle(tables) {
    const { outputFiles } = await runEsbuild(tables);
    const properties = { regex: new RegExp(`^(?:_(?!_)|(?:${ownNames().join("|")})$)`), keep_quoted: true };
    const optionsOf = (path) => (path.endsWith("app.js") ? { ...MINIFY, compress: { ...MINIFY.compress, conditionals: false, inline: 1 }, mangle: { properties } } : MINIFY);
    const minified = async ({ path, text }) => ({ name: basename(path), text: path.endsWith(".js") ? (await minify(text, optionsOf(path))).code : text });

    return Promise.all(outputFiles.map(minified));
}
