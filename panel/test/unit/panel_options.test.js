// SPDX-License-Identifier: MIT
/* scripts/panel.py hands what stands behind `--` over to the simulator. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import test from "node:test";

const SCRIPTS = new URL("../../../scripts", import.meta.url).pathname;
const PROGRAM = "import json, panel, sys; print(json.dumps(vars(panel.parse(sys.argv[1:]))))";

function parse(...options) {
    return JSON.parse(execFileSync("python3", ["-c", PROGRAM, ...options], { cwd: SCRIPTS, encoding: "utf8" }));
}

test("panel.py: options behind -- are for the simulator", () => {
    const options = parse("a.elf", "--board", "arduino-mega", "--eeprom", "e", "--", "--poke", "socket", "--servos", "9");

    assert.deepEqual(options, { elf: "a.elf", board: "arduino-mega", servos: "1-18", eeprom: "e", port: 8055, more: ["--poke", "socket", "--servos", "9"] });
});

test("panel.py: works without --", () => {
    assert.deepEqual(parse("a.elf", "--board", "b", "--eeprom", "e", "--servos", "1-3").more, []);
});
