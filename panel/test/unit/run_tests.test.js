// SPDX-License-Identifier: MIT
/* scripts/run-tests.py counts the tests of a suite like this one. */

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";

const RUN_TESTS = new URL("../../../scripts/run-tests.py", import.meta.url).pathname;
const PASSES = 'test("a", () => {});';
const FAILS = 'test("b", () => { throw new Error("b"); });';
const SKIPS = 'test("c", { skip: true }, () => {});';

function outcome(t, body) {
    const folder = mkdtempSync(join(tmpdir(), "suite-"));
    const suite = join(folder, "suite.test.js");

    t.after(() => rmSync(folder, { recursive: true }));
    writeFileSync(join(folder, "package.json"), '{"type": "module"}');
    writeFileSync(suite, `import test from "node:test";\n${body}`);
    const { NODE_TEST_CONTEXT: _, ...env } = process.env; // else the inner runner reports to this one
    const { status, stdout } = spawnSync(RUN_TESTS, [suite], { encoding: "utf8", env });

    return [status, stdout.trim().split("\n").at(-1)];
}

for (const [name, body, expected] of [
    ["passes", PASSES, [0, "1 passed, 0 failed"]],
    ["fails", PASSES + FAILS, [1, "1 passed, 1 failed"]],
    ["is skipped", PASSES + SKIPS, [1, "1 passed, 1 failed"]],
    ["ends early", "process.exit(3);", [1, "0 passed, 1 failed"]],
    ["does not load", "import './nothing.js';", [1, "0 passed, 1 failed"]],
])
    test(`run-tests.py counts a test that ${name}`, (t) => assert.deepEqual(outcome(t, body), expected));
