// SPDX-License-Identifier: MIT
/* scripts/panel.py and make panel: options, the port, the end. */

import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { join } from "node:path";
import test from "node:test";

const SCRIPTS = new URL("../../../scripts", import.meta.url).pathname;
const PROGRAM = "import json, panel, sys; print(json.dumps(vars(panel.parse(sys.argv[1:]))))";

function parse(...options) {
    return JSON.parse(execFileSync("python3", ["-c", PROGRAM, ...options], { cwd: SCRIPTS, encoding: "utf8" }));
}

test("panel.py: options behind -- are for the simulator", () => {
    const options = parse("a.elf", "--board", "arduino-mega", "--eeprom", "e", "--", "--poke", "socket", "--servos", "9");

    assert.deepEqual(options, { elf: "a.elf", board: "arduino-mega", servos: "1-18", eeprom: "e", port: "8055", more: ["--poke", "socket", "--servos", "9"] });
});

test("make panel: takes servos of one ID, as make run does", () => {
    const lines = execFileSync("make", ["-n", "panel", "SERVOS=1,1,1"], { cwd: join(SCRIPTS, ".."), encoding: "utf8" });

    assert.match(lines, /panel\.py .*--servos '1,1,1'[^]*? -- --allow-duplicates /);
});

test("panel.py: works without --", () => {
    assert.deepEqual(parse("a.elf", "--board", "b", "--eeprom", "e", "--servos", "1-3").more, []);
});

test("panel.py: a port that cannot be is refused in one line", () => {
    for (const port of ["70000", "-1", "0", "", "x"]) {
        const { status, stderr } = spawnSync("python3", ["-c", "import panel, sys; panel.check_port(sys.argv[1])", port], { cwd: SCRIPTS, encoding: "utf8" });

        assert.equal(status, 1);
        assert.equal(stderr, `panel: no port '${port}': give a number of 1 to 65535, as in make panel PANEL_PORT=8056\n`);
    }
});

test("panel.py: a server that heeds no SIGTERM is killed", () => {
    const deaf = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); time.sleep(99)";
    const program = `import panel, subprocess, sys
process = subprocess.Popen([sys.executable, "-c", sys.argv[1]], stdout=subprocess.PIPE)
process.stdout.readline()
panel.end(process)
print(process.returncode)`;

    assert.equal(execFileSync("python3", ["-c", program, deaf], { cwd: SCRIPTS, encoding: "utf8", timeout: 60000 }), "-9\n");
});
