// SPDX-License-Identifier: MIT
/* The generated tables of the page (make panel-build, make test-panel). */

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { ROOT } from "./simulator.js";

export function tables() {
    return JSON.parse(readFileSync(join(ROOT, "build/panel-tables.json"), "utf8"));
}
