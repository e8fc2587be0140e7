// SPDX-License-Identifier: MIT
/* The size of the page: all that a browser can load, uPlot included. */

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

export const LIMIT = 100000; // bytes, gzipped

/* Bytes of each file of `folder`, gzipped. No page loads the licence texts. */
export function gzippedSizes(folder) {
    const names = readdirSync(folder).filter((name) => !name.startsWith("LICENSE"));

    return Object.fromEntries(names.map((name) => [name, gzipSync(readFileSync(join(folder, name)), { level: 9 }).length]));
}

export const sumOf = (sizes) => Object.values(sizes).reduce((one, other) => one + other);
