// SPDX-License-Identifier: MIT
/* The real firmware in the simulator, at a pty, and a port that connects to it. */

import { spawn } from "node:child_process";
import { once } from "node:events";
import { constants, openSync } from "node:fs";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { ReadStream, WriteStream } from "node:tty";
import { fileURLToPath } from "node:url";

export const ROOT = join(dirname(fileURLToPath(import.meta.url)), "../../..");

export class Simulator {
    constructor(process, path) {
        this.process = process;
        this.path = path;
    }

    /* Starts the simulator. `options`: more options of cds55xx-sim. */
    static async start({ board = "atmega128", elf = "controller", servos = "1-3", options = [] } = {}) {
        const process = spawn(
            join(ROOT, "build/host/cds55xx-sim"),
            ["firmware", join(ROOT, `build/${board}/${elf}.elf`), "--board", board, "--servos", servos,
                "--host", "pty", ...options],
            { stdio: ["ignore", "pipe", "inherit"] },
        );
        const [path] = await once(createInterface(process.stdout), "line");

        return new Simulator(process, path.trim());
    }

    async end() {
        if (this.process.exitCode !== null) return;
        const exit = once(this.process, "exit");

        this.process.kill("SIGTERM");
        await exit;
    }
}

/* A port on the pty of a simulator. */
export class PtyPort {
    constructor(path) {
        this.path = path;
    }

    async open() {
        this.file = openSync(this.path, constants.O_RDWR | constants.O_NOCTTY | constants.O_NONBLOCK);
        this.input = new ReadStream(this.file);
        this.output = new WriteStream(this.file);
        this.input.on("data", (bytes) => this.onBytes(bytes));
        this.input.on("error", (error) => this.#lost(error.message));
        this.input.on("end", () => this.#lost("the simulator has ended"));
        this.output.on("error", (error) => this.#lost(error.message));
    }

    write(bytes) {
        this.output.write(bytes);
    }

    #lost(reason) {
        if (!this.input) return;
        this.close();
        this.onClose(reason);
    }

    async close() {
        this.input?.destroy();
        this.output?.destroy();
        this.input = null;
    }
}
